#!/usr/bin/env python3
"""Times planish's filters of normals in turns with MeshDenoiser, the program published with the static/dynamic filter.

    apt install meshsdfilter-tools && cargo build --release
    python3 tests/python/bench_normals.py NOISY.obj … [--rounds 3] [--preset paper]

Each whole process is measured: reading, denoising, writing. The programs take turns, so that a machine that drifts drifts
for all. Printed, for each mesh: medians of wall and CPU seconds (user and system), and how many times as long MeshDenoiser
takes (the median of the ratios round by round); Ea as well where X_clean.obj or NAME_clean.obj lies beside X_noisy.obj.

MeshDenoiser runs with the settings that come with it. Juyong Zhang, Bailin Deng, Yang Hong, Yue Peng, Wenjie Qin, Ligang Liu.
Static/Dynamic Filtering for Mesh Geometry. IEEE TVCG 2018.
"""
import argparse, json, os, statistics, subprocess, sys, tempfile, time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FILTERS = ["sun", "bilateral-normals", "guided-normals", "tgv-normals", "l0"]
# Its authors' defaults.
SETTINGS = """OuterIterations 5
Lambda 2.0
Eta 1.5
Mu 1.5
Nu 0.3
MaxFilterIterations 100
MeshUpdateClosenessWeight 0.001
MeshUpdateIterations 20
LinearSolverType 1
"""


def run(command):
    """Wall and CPU seconds of one process."""
    start = time.perf_counter()
    with tempfile.TemporaryFile() as said:
        child = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=said)
        _, status, usage = os.wait4(child.pid, 0)
        if status:
            said.seek(0)
            sys.exit(f"{command[0]} failed with status {status}: {said.read().decode(errors='replace')}")
    return time.perf_counter() - start, usage.ru_utime + usage.ru_stime


def ea(planish, clean, result):
    """Mean angle to the clean normals, degrees; none where there is no clean mesh."""
    if clean is None:
        return None
    printed = subprocess.run([planish, "compare", clean, result, "--json"], check=True, capture_output=True).stdout
    return json.loads(printed)["results"][0]["Ea_deg"]


def clean_beside(noisy):
    stem = noisy.stem.removesuffix("_noisy")
    places = [noisy.with_name(f"{name}_clean.obj") for name in (stem, stem.rsplit("_", 1)[0])]
    return next((place for place in places if place.is_file()), None)


def measure(planish, noisy, arguments, folder):
    options = Path(folder, "options.txt")
    options.write_text(SETTINGS)
    result = lambda name: Path(folder, f"{name}.obj")
    commands = {"MeshDenoiser": [arguments.peer, options, noisy, result("MeshDenoiser")]}
    for name in arguments.methods.split(","):
        preset = ["--preset", arguments.preset] if name != "tgv-normals" else []
        commands[name] = [planish, "denoise", noisy, "-o", result(name), "--quiet", "--method", name, *preset]
    times = {name: [] for name in commands}
    for _ in range(arguments.rounds):
        for name, command in commands.items():
            times[name].append(run(command))
    clean = clean_beside(noisy)
    print(f"{noisy.name}\n  {'':18}{'wall s':>9}{'CPU s':>9}{'x wall':>9}{'x CPU':>9}{'Ea °':>9}")
    for name, of in times.items():
        wall, cpu = (statistics.median(t[k] for t in of) for k in range(2))
        ratios = (statistics.median(p[k] / t[k] for p, t in zip(times["MeshDenoiser"], of)) for k in range(2))
        angle = ea(planish, clean, result(name))
        shown = "-" if angle is None else f"{angle:.2f}"
        print(f"  {name:18}{wall:9.2f}{cpu:9.2f}" + "".join(f"{r:9.1f}" for r in ratios) + f"{shown:>9}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("noisy", type=Path, nargs="+")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--preset", choices=["default", "paper"], default="default")
    parser.add_argument("--methods", default=",".join(FILTERS))
    parser.add_argument("--peer", default="MeshDenoiser")
    arguments = parser.parse_args()
    planish = os.environ.get("PLANISH", ROOT / "target/release/planish")
    for noisy in arguments.noisy:
        with tempfile.TemporaryDirectory() as folder:
            measure(planish, noisy, arguments, folder)


if __name__ == "__main__":
    main()
