"""`planish compare --json` against an independent metrics.py, where `PLANISH_MESHES` names a folder that has it."""

import csv
import importlib.util
import json
import math
import subprocess

import pytest

from conftest import MESHES, NO_MESHES, external, unpacked

# Otherwise "every key that both have" could be none.
NEEDED = {"Ea_deg", "Ea_area_deg", "off15_pct", "d_mean_el", "d_max_el", "vtx_mean_el", "flipped"}


def pairs():
    """Clean and noisy file of every line of the manifests that has both."""
    if external("metrics.py") is None:
        return
    for folder in (MESHES, MESHES / "scans"):
        manifest = folder / "MANIFEST.tsv"
        if not manifest.is_file():
            continue
        with open(manifest, encoding="utf-8", newline="") as lines:
            for row in csv.DictReader(lines, delimiter="\t", quoting=csv.QUOTE_NONE):
                clean, noisy = folder / row["clean"], folder / row["noisy"]
                if clean.is_file() and noisy.is_file():
                    yield pytest.param(clean, noisy, id=row["name"])


NONE = pytest.param(None, None, id="external", marks=pytest.mark.skip(reason=NO_MESHES))
PAIRS = list(pairs()) or [NONE]


@pytest.fixture(scope="module")
def metrics():
    spec = importlib.util.spec_from_file_location("metrics", external("metrics.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    # It rounds to five decimals at the very end, which would hide what is smaller.
    module.round = lambda value, _: value
    return module


def agree(ours, theirs):
    if isinstance(theirs, (bool, str)):
        return ours == theirs
    if not math.isfinite(theirs):
        # JSON has no word for it.
        return ours is None
    return ours is not None and math.isclose(ours, theirs, rel_tol=1e-6, abs_tol=1e-6)


@pytest.mark.parametrize("clean, noisy", PAIRS)
def test_every_metric(clean, noisy, planish, metrics, tmp_path):
    expected = metrics.evaluate(metrics.read_obj(str(clean)), metrics.read_obj(str(noisy)))
    files = [unpacked(path, tmp_path) for path in (clean, noisy)]
    output = subprocess.run([planish, "compare", *files, "--json"], check=True, capture_output=True).stdout
    (actual,) = json.loads(output)["results"]
    both = actual.keys() & expected.keys()
    assert NEEDED <= both
    wrong = {key: (actual[key], expected[key]) for key in sorted(both) if not agree(actual[key], expected[key])}
    assert wrong == {}
