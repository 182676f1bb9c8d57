#!/usr/bin/env python3
"""Writes tests/reference/NAME.json beside each NAME.obj: the quantities that `cargo test` holds planish to.

They come from `reference.py`, never from planish; `pytest` compares that with libigl and trimesh.
"""

import json

import numpy as np

import obj
import reference
from conftest import reference_meshes


def plain(value):
    if isinstance(value, dict):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, (list, np.ndarray)):
        return [plain(item) for item in value]
    return int(value) if isinstance(value, (int, np.integer)) else float(value)


def frozen(path):
    quantities = plain(reference.quantities(*obj.read_triangles(path)))
    quantities["cotangent_laplacian"] = [[int(i), int(j), w] for i, j, w in quantities["cotangent_laplacian"]]
    return quantities


if __name__ == "__main__":
    for path in reference_meshes():
        # One quantity a line, so that a diff names what changed.
        compact = {name: json.dumps(value, separators=(",", ":")) for name, value in frozen(path).items()}
        lines = ",\n".join(f'"{name}":{value}' for name, value in compact.items())
        path.with_suffix(".json").write_text("{\n" + lines + "\n}\n", encoding="utf-8")
