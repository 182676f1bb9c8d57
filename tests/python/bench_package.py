"""No test: figures of the Python package for docs/python.md. `bench_package.py calls` measures the overhead of a call, copies of the vertices
and two threads side by side; `bench_package.py tiles VERTICES TILES METHOD [WORKERS …]` denoises a mesh that is made on the spot in tiles, with each number
of workers, of 2 GB each, and `--whole` compares the bytes with those of `planish denoise`."""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

import planish
from test_large import torus, write_ply


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


def tiles(vertices, count, method, workers, whole):
    from planish import dask

    folder = Path(tempfile.mkdtemp(dir=os.environ.get("TMPDIR")))
    mesh = folder / "mesh.ply"
    side = round((vertices / 1.5625) ** 0.5)
    write_ply(mesh, *torus(round(side * 1.5625), side))
    print(f"{mesh.stat().st_size / 1e6:.0f} MB of mesh", flush=True)
    for number in workers:
        start, before = time.perf_counter(), of_children()
        report = dask.denoise_large(mesh, folder / "tiles.ply", method, tiles=count, workers=number, memory_limit="2GB")
        seconds = time.perf_counter() - start
        del report["choices"]
        rate = report["vertices"] / seconds / 1e3
        print(f"{number} workers: {seconds:.1f} s and {of_children() - before:.1f} s of processors, {rate:.0f} thousand vertices a second")
        print(json.dumps(report), flush=True)
    if whole:
        planish.read(mesh).denoise(method).write(folder / "whole.ply")
        same = (folder / "tiles.ply").read_bytes() == (folder / "whole.ply").read_bytes()
        print("the bytes of the whole mesh" if same else "not the bytes of the whole mesh")
    for file in folder.iterdir():
        file.unlink()
    folder.rmdir()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("calls")
    of_memory = commands.add_parser("memory")
    of_memory.add_argument("kind")
    of_tiles = commands.add_parser("tiles")
    of_tiles.add_argument("vertices", type=int)
    of_tiles.add_argument("count", type=int)
    of_tiles.add_argument("method")
    of_tiles.add_argument("workers", type=int, nargs="*", default=[1, 2])
    of_tiles.add_argument("--whole", action="store_true")
    args = parser.parse_args()
    if args.command == "calls":
        calls()
    elif args.command == "memory":
        memory(args.kind)
    else:
        tiles(args.vertices, args.count, args.method, args.workers, args.whole)


if __name__ == "__main__":
    main()
