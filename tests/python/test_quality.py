"""Methods against the figures that other programs reached with the same parameters, where `PLANISH_MESHES` names a folder that
has a table of them."""

import csv
import json
import subprocess

import pytest

from conftest import NO_MESHES, external

# Column of the manifest, the options that mean the same, and the pairs they are run on; all of them where it is None.
SMALL = {"fandisk0.3", "spot_n0.2", "kinect_pyramid"}
METHODS = {
    "Ea_lap_it3": (["--method", "laplacian", "--iterations", "3", "--step", "0.5"], None),
    "Ea_taubin_it10": (["--method", "taubin", "--iterations", "10", "--step", "0.5", "--inflate", "-0.53"], None),
    "Ea_bmd": (["--method", "bilateral", "--preset", "paper"], SMALL),
    "Ea_sun": (["--method", "sun", "--preset", "paper"], SMALL),
    "Ea_bnf": (["--method", "bilateral-normals", "--preset", "paper"], SMALL),
    "Ea_gnf": (["--method", "guided-normals", "--preset", "paper"], SMALL),
    "Ea_l0abs": (["--method", "l0", "--preset", "paper"], SMALL),
}


def cases():
    """Clean file, noisy file, options and Ea in degrees of every figure there is."""
    manifest = external("MANIFEST.tsv")
    if manifest is None:
        return
    with open(manifest, encoding="utf-8", newline="") as lines:
        for row in csv.DictReader(lines, delimiter="\t", quoting=csv.QUOTE_NONE):
            for column, (options, pairs) in METHODS.items():
                wanted = pairs is None or row["name"] in pairs
                if wanted and row["clean"] != "-" and row[column] != "-":
                    files = [manifest.parent / row[name] for name in ("clean", "noisy")]
                    yield pytest.param(*files, options, float(row[column]), id=f"{row['name']}-{column}")


NONE = pytest.param(None, None, None, None, id="external", marks=pytest.mark.skip(reason=NO_MESHES))


@pytest.mark.parametrize(("clean", "noisy", "options", "reference"), list(cases()) or [NONE])
def test_a_method_reaches_the_reference(planish, tmp_path, clean, noisy, options, reference):
    result = tmp_path / "result.obj"
    subprocess.run([planish, "denoise", noisy, "-o", result, "--quiet", *options], check=True)
    printed = subprocess.run([planish, "compare", clean, result, "--json"], check=True, capture_output=True).stdout
    found = json.loads(printed)["results"][0]["Ea_deg"]
    # The references of laplacian and taubin move the boundary and planish does not: 2 % on the mesh with the longest one.
    assert abs(found / reference - 1) < 0.03, f"{found:.3f} against {reference}"
