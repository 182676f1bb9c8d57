#!/usr/bin/env python3
"""Times planish on a large mesh, in turns with what other programs do to the same file.

    cargo build --release && pip install numpy pymeshlab meshlib open3d trimesh && python tests/python/bench_large.py [--pairs 3]

`planish denoise` and its peers read the mesh, take ten Laplacian steps and write it. `planish bake` also bakes a 2048² map and a normal
map, reads them and the carrier back, measures the error and writes them. All take turns, so that a machine that drifts drifts for
all. Printed: wall and CPU seconds and peak memory of each whole process (medians), and the ratio of `planish denoise` to each peer,
turn by turn. Peers that are not installed are named and left out. `--side` 1000 makes a million vertices; `--scaling` measures planish
alone at several sizes and prints the exponent of the time.
"""
import argparse, importlib.util, json, multiprocessing, os, statistics, subprocess, sys, tempfile, time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
# What each peer runs, by the module that it needs.
PEERS = {
    "pymeshlab": """
meshes = pymeshlab.MeshSet()
meshes.load_new_mesh(source)
meshes.apply_coord_laplacian_smoothing(stepsmoothnum=10, cotangentweight=False)
meshes.save_current_mesh(result)
""",
    "meshlib": """
from meshlib import mrmeshpy
mesh = mrmeshpy.loadMesh(source)
settings = mrmeshpy.MeshRelaxParams()
settings.iterations = 10
mrmeshpy.relax(mesh, settings)
mrmeshpy.saveMesh(mesh, result)
""",
    "open3d": """
mesh = open3d.io.read_triangle_mesh(source)
open3d.io.write_triangle_mesh(result, mesh.filter_smooth_laplacian(10))
""",
    "trimesh": """
mesh = trimesh.load(source, process=False)
trimesh.smoothing.filter_laplacian(mesh, iterations=10)
mesh.export(result)
""",
}


def write_tube(path, side=1000):
    """A noisy open tube of side × side vertices with one seam, noise a sixth of an edge; v, vt and f v/vt lines."""
    turn, along = np.meshgrid(2 * np.pi * np.arange(side) / side, 6 * np.arange(side) / (side - 1))
    noise = np.random.default_rng(1).normal(0, 1 / side, turn.shape)
    radius = 1 + 0.2 * np.sin(3 * turn) * np.cos(2 * along) + noise
    points = np.stack([radius * np.cos(turn), radius * np.sin(turn), along], -1).reshape(-1, 3)
    u, v = np.meshgrid(np.arange(side + 1) / side, np.arange(side) / (side - 1))
    uvs = 0.01 + 0.98 * np.stack([u, v], -1).reshape(-1, 2)
    j, i = (x.ravel() for x in np.meshgrid(np.arange(side - 1), np.arange(side), indexing="ij"))
    vertex = lambda i, j: 1 + j * side + i % side
    uv = lambda i, j: 1 + j * (side + 1) + i
    a, b, c, d = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
    face = lambda *corners: np.stack([f(*corner) for corner in corners for f in (vertex, uv)], 1)
    with open(path, "w") as out:
        np.savetxt(out, points, fmt="v %.7f %.7f %.7f")
        np.savetxt(out, uvs, fmt="vt %.7f %.7f")
        np.savetxt(out, np.concatenate([face(a, b, c), face(a, c, d)]), fmt="f %d/%d %d/%d %d/%d")


def make_tube(path, side):
    """Writes the tube in a process of its own: what this one holds would count as memory of the programs that it starts."""
    writer = multiprocessing.Process(target=write_tube, args=(path, side))
    writer.start()
    writer.join()
    if writer.exitcode:
        sys.exit(f"{path} could not be written")


def run(command):
    """Wall seconds, CPU seconds, peak MB and stdout of one process."""
    start = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.PIPE)
    out = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    if status:
        sys.exit(f"{command[0]} failed with status {status}")
    return time.perf_counter() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, out


def peers(source, result):
    """The command of each peer that is installed."""
    commands = {}
    for module, script in PEERS.items():
        if importlib.util.find_spec(module) is None:
            print(f"{module} is not installed")
            continue
        script = f"import sys, {module}\nsource, result = sys.argv[1:]\n{script}"
        commands[module] = [sys.executable, "-c", script, source, result]
    return commands


def scaling(planish, folder):
    """Times ten steps and `auto` over the number of vertices; prints the exponent of a power through the times."""
    for method, sides in (("laplacian", (250, 500, 1000, 2000)), ("auto", (120, 240, 480))):
        logs = []
        for side in sides:
            mesh = Path(folder) / "scaling.obj"
            make_tube(mesh, side)
            command = [planish, "denoise", mesh, "-o", f"{folder}/scaled.obj", "--method", method, "--quiet"]
            wall, cpu, memory, _ = min(run(list(map(str, command))) for _ in range(3))
            logs.append((np.log(side**2), np.log(cpu)))
            print(f"{method:10} {side**2:9} vertices {wall:7.2f} s wall {cpu:7.2f} s CPU {memory:6.0f} MB", flush=True)
        print(f"{method:10} CPU seconds grow like vertices^{np.polyfit(*np.transpose(logs), 1)[0]:.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--side", type=int, default=1000)
    parser.add_argument("--scaling", action="store_true")
    arguments = parser.parse_args()
    planish = os.environ.get("PLANISH", ROOT / "target/release/planish")
    with tempfile.TemporaryDirectory() as folder:
        if arguments.scaling:
            return scaling(planish, folder)
        mesh = Path(folder) / "tube.obj"
        make_tube(mesh, arguments.side)
        ten_steps = ["--method", "laplacian", "--iterations", "10", "--json", "-v"]
        commands = {
            "planish bake": [planish, "bake", mesh, "-o", f"{folder}/out", "--size", "2048", *ten_steps],
            "planish denoise": [planish, "denoise", mesh, "-o", f"{folder}/denoised.obj", *ten_steps],
            **peers(mesh, f"{folder}/peer.obj"),
        }
        runs = {name: [] for name in commands}
        for _ in range(arguments.pairs):
            for name, command in commands.items():
                runs[name].append(run(list(map(str, command))))
    ours = runs["planish denoise"]
    for name, of in runs.items():
        wall, cpu, memory = (statistics.median(r[k] for r in of) for k in range(3))
        ratios = sorted(mine[0] / other[0] for mine, other in zip(ours, of))
        shown = "" if name.startswith("planish") else ", planish denoise / this: " + " ".join(f"{r:.3f}" for r in ratios)
        print(f"{name:15} {wall:6.2f} s wall {cpu:6.2f} s CPU {memory:6.0f} MB{shown}")
    for command in ("planish denoise", "planish bake"):
        seconds = json.loads(runs[command][-1][3])["seconds"]
        print(command)
        for stage, s in seconds.items():
            print(f"  {stage:16} {s:7.3f} s {100 * s / seconds['total']:5.1f} %")


if __name__ == "__main__":
    main()
