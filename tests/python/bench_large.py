#!/usr/bin/env python3
"""Times planish on a mesh with a million vertices, in pairs with what PyMeshLab does to the same file.

    cargo build --release && pip install numpy pymeshlab && python tests/python/bench_large.py [--pairs 3]

`planish bake` reads, takes ten Laplacian steps, bakes a 2048² map and a normal map, reads them and the carrier back,
measures the error and writes them. `planish denoise` and PyMeshLab read, take ten steps and write the mesh. They take
turns, so that a machine that drifts drifts for all. Printed: wall and CPU seconds and peak memory of each whole process, the
ratio pair by pair, and the share of each stage of planish.
"""
import argparse, json, os, statistics, subprocess, sys, tempfile, time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PEER = """
import sys, pymeshlab
meshes = pymeshlab.MeshSet()
meshes.load_new_mesh(sys.argv[1])
meshes.apply_coord_laplacian_smoothing(stepsmoothnum=10, cotangentweight=False)
meshes.save_current_mesh(sys.argv[2])
"""


def write_tube(path, side=1000):
    """A noisy open tube of side × side vertices with one seam; v, vt and f v/vt lines."""
    turn, along = np.meshgrid(2 * np.pi * np.arange(side) / side, 6 * np.arange(side) / (side - 1))
    noise = np.random.default_rng(1).normal(0, 1e-3, turn.shape)
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


def run(command):
    """Wall seconds, CPU seconds, peak MB and stdout of one process."""
    start = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.PIPE)
    out = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    if status:
        sys.exit(f"{command[0]} failed with status {status}")
    return time.perf_counter() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=3)
    pairs = parser.parse_args().pairs
    planish = os.environ.get("PLANISH", ROOT / "target/release/planish")
    with tempfile.TemporaryDirectory() as folder:
        mesh = Path(folder) / "tube.obj"
        write_tube(mesh)
        ten_steps = ["--method", "laplacian", "--iterations", "10", "--json", "-v"]
        commands = {
            "planish bake": [planish, "bake", mesh, "-o", f"{folder}/out", "--size", "2048", *ten_steps],
            "planish denoise": [planish, "denoise", mesh, "-o", f"{folder}/denoised.obj", *ten_steps],
            "PyMeshLab": [sys.executable, "-c", PEER, mesh, f"{folder}/peer.obj"],
        }
        runs = {name: [] for name in commands}
        for _ in range(pairs):
            for name, command in commands.items():
                runs[name].append(run(list(map(str, command))))
    for name, of in runs.items():
        wall, cpu, memory = (statistics.median(r[k] for r in of) for k in range(3))
        ratios = sorted(ours[0] / theirs[0] for ours, theirs in zip(of, runs["PyMeshLab"]))
        shown = " ".join(f"{ratio:.3f}" for ratio in ratios)
        print(f"{name:15} {wall:6.2f} s wall {cpu:6.2f} s CPU {memory:6.0f} MB, wall / PyMeshLab: {shown}")
    seconds = json.loads(runs["planish bake"][-1][3])["seconds"]
    for stage, s in seconds.items():
        print(f"  {stage:16} {s:7.3f} s {100 * s / seconds['total']:5.1f} %")


if __name__ == "__main__":
    main()
