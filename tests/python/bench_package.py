"""No test: figures of the Python package for docs/python.md. `bench_package.py calls` measures the overhead of a call, copies of the vertices
and two threads side by side; `bench_package.py tiles VERTICES METHOD [WORKERS …]` denoises a mesh that is made on the spot in tiles, with each number
of workers, of 2 GB and one thread each: seconds of each stage, the peak of each worker, vertices a second. `--whole` compares the bytes with those of
`planish denoise`, `--bake` bakes the map instead. Files lie in TMPDIR: 38 bytes for a vertex of the mesh, and 190 between the stages."""

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

import planish
from test_large import torus


def best(work, times=5):
    """Shortest of a few times, seconds."""

    def once():
        start = time.perf_counter()
        work()
        return time.perf_counter() - start

    return min(once() for _ in range(times))


def peak():
    """Largest memory of this process so far, MiB; what `resource` tells may be that of its parent."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1024


def of_children():
    """Seconds of processors that processes which have ended have taken: those of a cluster that is closed."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def in_a_process(*arguments):
    done = subprocess.run([sys.executable, __file__, *map(str, arguments)], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def calls():
    points, faces = torus(224, 224)
    faces = faces.astype(np.uint32)
    wrong = faces.copy()
    wrong[-1, 0] = len(points)

    def refused():
        try:
            planish.denoise(points, wrong, "taubin")
        except planish.InputError:
            pass

    tent, sides = np.eye(3), np.array([[0, 1, 2]], dtype=np.uint32)
    print(f"{len(faces)} faces: {1e3 * best(lambda: planish.denoise(points, faces, 'taubin')):.1f} ms a call of taubin, of which")
    print(f"  {1e3 * best(refused):.2f} ms until all arrays are checked, and")
    print(f"  {1e3 * best(lambda: planish.denoise(tent, sides, 'taubin')):.2f} ms for a call with a single triangle")
    one = best(lambda: planish.denoise(points, faces, "bilateral-normals"), 3)

    def two():
        both = [threading.Thread(target=planish.denoise, args=(points, faces, "bilateral-normals")) for _ in range(2)]
        for thread in both:
            thread.start()
        for thread in both:
            thread.join()

    print(f"one thread {one:.3f} s, two threads side by side {best(two, 3):.3f} s, of {os.cpu_count()} processors")
    for kind in ("borrowed", "copied"):
        print(f"4 million vertices, {kind}: {in_a_process('memory', kind)} MiB above the arrays")


def memory(kind):
    """Peak of a call that ends before any work, because a face names no vertex, for positions that are borrowed or of another type."""
    points = np.zeros((4_000_000, 3), dtype=np.float64 if kind == "borrowed" else np.float32)
    points += 1
    before = peak()
    try:
        planish.denoise(points, np.array([[0, 1, 4_000_000]], dtype=np.uint32), "taubin")
    except planish.InputError:
        pass
    print(json.dumps(round(peak() - before)))


def write_torus(path, vertices):
    """A bumpy torus with noise of 0.2 edges as a binary PLY, which is written row by row: a mesh larger than memory could be, too."""
    across = round((vertices / 1.5625) ** 0.5)
    around = round(across * 1.5625)
    edge = 2 * np.pi * 0.6 / across
    random = np.random.default_rng(1)
    v = np.arange(across) * 2 * np.pi / across
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {around * across}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {2 * around * across}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    with open(path, "wb") as file:
        file.write(head.encode())
        for i in range(around):
            u = i * 2 * np.pi / around
            radius = 0.6 + 0.03 * np.sin(5 * u) * np.cos(3 * v)
            out = 1.5 + radius * np.cos(v)
            points = np.stack([out * np.cos(u), out * np.sin(u), radius * np.sin(v)], 1) + random.normal(0, 0.2 * edge, (across, 3))
            file.write(points.astype("<f4").tobytes())
        row = np.arange(across)
        ahead = (row + 1) % across
        for i in range(around):
            this, other = i * across, (i + 1) % around * across
            triangles = np.zeros(2 * across, [("n", "u1"), ("v", "<i4", 3)])
            triangles["n"] = 3
            triangles["v"][::2] = np.stack([this + row, other + row, other + ahead], 1)
            triangles["v"][1::2] = np.stack([this + row, other + ahead, this + ahead], 1)
            file.write(triangles.tobytes())


def tiles(vertices, method, workers, args):
    import distributed
    from planish import dask

    folder = Path(tempfile.mkdtemp(dir=os.environ.get("TMPDIR")))
    mesh = folder / "mesh.ply"
    write_torus(mesh, vertices)
    print(f"{mesh.stat().st_size / 1e6:.0f} MB of mesh", flush=True)
    os.environ["RAYON_NUM_THREADS"] = "1"
    for number in workers:
        before, largest = of_children(), [0]

        def size_of_folder(stage, fraction):
            largest[0] = max(largest[0], sum(file.stat().st_size for file in folder.rglob("*")))

        cluster = distributed.LocalCluster(n_workers=number, threads_per_worker=1, dashboard_address=None, memory_limit=args.memory)
        with cluster, distributed.Client(cluster) as client:
            start = time.perf_counter()
            options = {"tiles": args.tiles, "client": client, "progress": size_of_folder}
            if args.bake:
                report = dask.bake_large(mesh, folder / "map", method, **options)
            else:
                report = dask.denoise_large(mesh, folder / "tiles.ply", method, **options)
            seconds = time.perf_counter() - start
            peaks = [round(each) for each in client.run(peak).values()]
        rate = report["vertices"] / seconds / 1e3
        print(f"{number} workers: {seconds:.1f} s and {of_children() - before:.1f} s of processors, {rate:.0f} thousand vertices a second")
        print(f"  peaks {peaks} MiB, {largest[0] / 1e9:.2f} GB of files, {len(report['tiles'])} tiles, halo {report['halo']}, exact {report['exact']}")
        print("  " + ", ".join(f"{stage} {s:.1f} s" for stage, s in report["seconds"].items()), flush=True)
        print("  " + json.dumps(report["borders"]), flush=True)
    if args.whole:
        planish.read(mesh).denoise(method).write(folder / "whole.ply")
        same = (folder / "tiles.ply").read_bytes() == (folder / "whole.ply").read_bytes()
        print("the bytes of the whole mesh" if same else "not the bytes of the whole mesh")
    shutil.rmtree(folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("calls")
    of_memory = commands.add_parser("memory")
    of_memory.add_argument("kind")
    of_tiles = commands.add_parser("tiles")
    of_tiles.add_argument("vertices", type=lambda text: int(float(text)))
    of_tiles.add_argument("method")
    of_tiles.add_argument("workers", type=int, nargs="*", default=[1, 2])
    of_tiles.add_argument("--tiles", type=int)
    of_tiles.add_argument("--memory", default="2GB")
    of_tiles.add_argument("--whole", action="store_true")
    of_tiles.add_argument("--bake", action="store_true")
    args = parser.parse_args()
    if args.command == "calls":
        calls()
    elif args.command == "memory":
        memory(args.kind)
    else:
        tiles(args.vertices, args.method, args.workers, args)


if __name__ == "__main__":
    main()
