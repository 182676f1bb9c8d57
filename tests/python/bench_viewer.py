#!/usr/bin/env python3
"""Times planish-viewer on tubes of a hundred thousand, a million and five million triangles.

    cargo build --release && pip install numpy && python tests/python/bench_viewer.py [--triangles 100000 1000000]

Seconds of a frame of 1280×720 as a window draws it (medians of 3 to 15, as many as fit into ten seconds): the mesh as it is; with its map at λ = 1; with soft shadows on a
ground as well; with the heights as colours; both halves of the split view; and with the map while the mesh is baked anew in the
background. Then seconds from the start of the program to its first picture with the map, megabytes of the mesh on the graphics adapter,
and at most in memory. The map is baked before, with `taubin`.
"""
import argparse, json, math, os, subprocess, tempfile
from pathlib import Path

from bench_large import ROOT, make_tube

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--triangles", type=int, nargs="+", default=[100_000, 1_000_000, 5_000_000])
sizes = parser.parse_args().triangles
planish = os.environ.get("PLANISH", ROOT / "target/release/planish")
viewer = os.environ.get("PLANISH_VIEWER", ROOT / "target/release/planish-viewer")
VIEWS = {
    "mesh": ["--lambda", "0"],
    "map": ["--lambda", "1"],
    "shadows": ["--lambda", "1", "--shadow", "pcss", "--ground", "plane"],
    "heights": ["--lambda", "1", "--shading", "height"],
}


def timings(mesh, manifest, options):
    """What the viewer measures of one view."""
    command = [viewer, mesh, "--map", manifest, "--timings", "--size", "1280x720", *options]
    return json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)


with tempfile.TemporaryDirectory() as folder:
    mesh, manifest = Path(folder) / "tube.obj", Path(folder) / "baked/tube.planish.json"
    for number, wanted in enumerate(sizes):
        make_tube(mesh, math.isqrt(wanted // 2))
        bake = [planish, "bake", mesh, "-o", manifest.parent, "--method", "taubin", "--no-glb", "--quiet"]
        subprocess.run(bake, check=True)
        seen = {view: timings(mesh, manifest, options) for view, options in VIEWS.items()}
        with_map = seen["map"]
        if number == 0:
            print(with_map["adapter"])
            names = [*VIEWS, "split", "baking", "start"]
            print(f"{'triangles':>10}", *(f"{name:>8}" for name in names), f"{'MB on it':>9} {'MB':>6}")
        frames = [view["frame"] for view in seen.values()] + [with_map["split_frame"], with_map["frame_while_baking"]]
        print(
            f"{with_map['triangles']:>10}",
            *(f"{seconds:>8.3f}" for seconds in [*frames, with_map["start_to_picture"]]),
            f"{with_map['scene_bytes'] / 1e6:>9.0f} {with_map.get('peak_memory', 0) / 1e6:>6.0f}",
            flush=True,
        )
