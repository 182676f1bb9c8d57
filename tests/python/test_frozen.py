"""The committed files of tests/reference are what the scripts here write."""

import json

import numpy as np
import pytest

import freeze
import make_meshes
import obj
from bounds import EXACT
from conftest import REFERENCE, parameters, reference_meshes
from make_meshes import MESHES

MESH_FILES = parameters(reference_meshes())


@pytest.mark.parametrize("path", MESH_FILES)
def test_references_are_what_freeze_writes(path):
    committed = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    assert_alike(committed, freeze.frozen(path))


def assert_alike(committed, fresh, name=""):
    if isinstance(fresh, dict):
        assert committed.keys() == fresh.keys()
        for key in fresh:
            assert_alike(committed[key], fresh[key], key)
    elif name in EXACT:
        assert committed == fresh, name
    else:
        # The rows [i, j, w] of the Laplacian are in a fixed order, so the indices compare as numbers.
        np.testing.assert_allclose(committed, fresh, rtol=0, atol=1e-13 * np.abs(fresh).max(), err_msg=name)


@pytest.mark.parametrize("function", MESHES, ids=lambda function: function.__name__)
def test_meshes_are_what_make_meshes_writes(function):
    positions, faces = make_meshes.make(function)
    committed, committed_faces = obj.read_triangles(REFERENCE / f"{function.__name__}.obj")
    np.testing.assert_array_equal(committed_faces, faces)
    np.testing.assert_allclose(committed, positions, rtol=1e-14, atol=1e-14)


def test_every_mesh_is_made_here():
    assert {path.stem for path in reference_meshes()} == {function.__name__ for function in MESHES}
