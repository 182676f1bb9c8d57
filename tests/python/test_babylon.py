"""Babylon.js, whose displacement is computed on the CPU: its positions are those of `planish apply`."""

import json

import numpy as np
from baked import DUCK
from clients import SCRIPTS, execute, figures, numbers, package, program, snippet, text

# Of the range: Babylon weights red, green and blue of each texel, in double precision, and normalises normals.
EXACT = 2e-6


def test_displacement_map(baked, tmp_path):
    node = program("node")
    package("@babylonjs/core")
    case = baked(DUCK, "uvs", "--layout", "vertex", "--bits", "32")
    # Packages are looked up from the folder of the module that names them.
    (tmp_path / "node_modules").symlink_to(SCRIPTS / "node_modules")
    code = tmp_path / "code.mjs"
    code.write_text(snippet("babylon"), encoding="utf-8")
    job = {
        "snippet": str(code),
        "positions": text(case.positions),
        "normals": text(case.normals),
        "uvs": text(case.sampled_at * np.float32([1, -1]) + np.float32([0, 1])),
        "indices": case.corners[:, 0].tolist(),
        "image": text(case.image),
        "entry": case.map,
        "result": str(tmp_path / "places.json"),
    }
    (tmp_path / "job.json").write_text(json.dumps(job), encoding="utf-8")
    execute([node, SCRIPTS / "babylon.mjs", tmp_path / "job.json"])
    places = numbers(json.loads((tmp_path / "places.json").read_text(encoding="utf-8")))
    error = case.errors(places, case.places)
    figures("babylon", all=error)
    assert error.max() <= EXACT + case.ulp / case.range
