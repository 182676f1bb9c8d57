#!/usr/bin/env python3
"""Times the filters of normals, in turns with the MeshDenoiser that Debian packages (meshsdfilter-tools), on one mesh.

    cargo build --release && apt-get install meshsdfilter-tools && python tests/python/bench_normals.py MESH.obj [--rounds 3]

MeshDenoiser (Zhang et al., Static/dynamic filtering for mesh geometry, 2018) has the settings with which its authors denoise,
planish its defaults. Both read the file, filter and write the result. CPU is user and system time over all threads. Ratios are of the runs
of one round, which a busy machine slows alike. PLANISH names another binary. Needs nothing but Python.
"""

import argparse
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
METHODS = ["sun", "bilateral-normals", "guided-normals", "tgv-normals"]
OPTIONS = """OuterIterations 5
Lambda 2
Eta 1.5
Mu 1.5
Nu 0.3
MeshUpdateClosenessWeight 0.001
MeshUpdateIterations 20
"""


def run(command):
    """Wall and CPU seconds of one process."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--methods", default=",".join(METHODS), help="of planish, with commas between them")
    parser.add_argument("--no-peer", action="store_true", help="time planish alone")
    arguments = parser.parse_args()
    if not arguments.no_peer and shutil.which("MeshDenoiser") is None:
        sys.exit("there is no MeshDenoiser; apt-get install meshsdfilter-tools, or --no-peer")
    planish = os.environ.get("PLANISH", ROOT / "target/release/planish")
    with tempfile.TemporaryDirectory() as folder:
        options = Path(folder) / "options.txt"
        options.write_text(OPTIONS, encoding="utf-8")
        denoise = [planish, "denoise", arguments.mesh, "-o", f"{folder}/planish.obj", "--quiet", "--method"]
        commands = {method: [*denoise, method] for method in arguments.methods.split(",")}
        if not arguments.no_peer:
            commands["MeshDenoiser"] = ["MeshDenoiser", options, arguments.mesh, f"{folder}/peer.obj"]
        runs = {name: [] for name in commands}
        for _ in range(arguments.rounds):
            for name, command in commands.items():
                runs[name].append(run(list(map(str, command))))
    print(f"{'':18} {'wall s':>8} {'CPU s':>8}" + ("" if arguments.no_peer else "   MeshDenoiser over it: wall, CPU"))
    for name, of in runs.items():
        wall, cpu = (statistics.median(r[k] for r in of) for k in range(2))
        line = f"{name:18} {wall:8.2f} {cpu:8.2f}"
        if not arguments.no_peer:
            peers = list(zip(of, runs["MeshDenoiser"]))
            line += "".join(f" {statistics.median(peer[k] / own[k] for own, peer in peers):8.1f}" for k in range(2))
        print(line)


if __name__ == "__main__":
    main()
