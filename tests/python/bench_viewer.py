#!/usr/bin/env python3
"""Times planish-viewer on tubes of a hundred thousand, a million and five million triangles.

    cargo build --release -p planish-viewer && pip install numpy && python tests/python/bench_viewer.py [--lambda 1]

Seconds of a frame of 1280×720 as a window draws it (the median), from the start of the program to its first picture, and of
that for the opening (reading, and baking unless λ is 0); megabytes of the mesh on the graphics adapter, and at most in memory.
"""
import argparse, json, math, os, subprocess, tempfile
from pathlib import Path

from bench_large import ROOT, write_tube

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--lambda", dest="strength", default="0")
strength = parser.parse_args().strength
viewer = os.environ.get("PLANISH_VIEWER", ROOT / "target/release/planish-viewer")
with tempfile.TemporaryDirectory() as folder:
    mesh = Path(folder) / "tube.obj"
    for wanted in (100_000, 1_000_000, 5_000_000):
        write_tube(mesh, math.isqrt(wanted // 2))
        command = [viewer, mesh, "--timings", "--size", "1280x720", "--lambda", strength]
        seen = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)
        if wanted == 100_000:
            print(seen["adapter"])
            print(f"{'triangles':>10} {'frame':>7} {'start':>7} {'opening':>7} {'MB on it':>9} {'MB':>6}")
        print(
            f"{seen['triangles']:>10} {seen['frame']:>7.2f} {seen['start_to_picture']:>7.2f} {seen['opening']:>7.2f}"
            f" {seen['scene_bytes'] / 1e6:>9.0f} {seen.get('peak_memory', 0) / 1e6:>6.0f}"
        )
