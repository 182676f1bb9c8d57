"""planish's geometry against libigl, trimesh and plain numpy; and those against each other.

What the libraries mean differently is in `peers.py` and README.md, what rounding may do in `bounds.py`.
"""

import copy
import functools

import numpy as np
import pytest

import obj
from bounds import EXACT, differences, tolerances
from conftest import NO_MESHES, external, parameters, reference_meshes
from peers import PEERS
from polygons import tidied

# Triangles only. Between them they are closed and open, noisy and decimated, and have non-manifold edges, degenerate
# faces, faces that are there twice and vertices without faces.
REAL = [
    "spot_clean.obj",
    "fandisk0.3_noisy.obj",
    "nicolo0.2_noisy.obj",
    "kinect_pyramid_noisy.obj",
    "scans/fran_cut.obj",
    "scans/ggg_owl.obj",
    "scans/leeperrysmith.obj",
    "scans/esp32cam_meshroom.obj",
]
EXTERNAL_MESHES = [path for name in REAL if (path := external(name))]
MESHES = [
    *parameters(reference_meshes()),
    *parameters(EXTERNAL_MESHES, NO_MESHES),
]


@functools.cache
def mesh(path):
    positions, faces = obj.read_triangles(path)
    return positions, np.array(tidied(faces.tolist()))


@functools.cache
def from_peer(peer, path):
    return PEERS[peer](*mesh(path))


@pytest.mark.parametrize("path", MESHES)
@pytest.mark.parametrize("peer", PEERS)
def test_planish_agrees_with(peer, path, planish_quantities):
    bounds = tolerances(*mesh(path), by_lengths=peer == "igl")
    assert differences(planish_quantities(path), from_peer(peer, path), bounds) == []


@pytest.mark.parametrize("path", MESHES)
@pytest.mark.parametrize("peer", ["igl", "trimesh"])
def test_numpy_agrees_with(peer, path):
    """The frozen references come from numpy, so they rest on this test."""
    bounds = tolerances(*mesh(path), by_lengths=peer == "igl")
    assert differences(from_peer("numpy", path), from_peer(peer, path), bounds) == []


def leaves(quantities, above=()):
    """The path of names to each quantity."""
    for name, value in quantities.items():
        yield from leaves(value, (*above, name)) if isinstance(value, dict) else [(*above, name)]


@pytest.mark.parametrize("path", parameters(reference_meshes()))
def test_a_wrong_digit_is_found(path):
    """Every comparison can fail: 1e-6 (relative or absolute, whichever is more), or one index, exceeds every bound."""
    bounds = tolerances(*mesh(path), by_lengths=True)
    right = from_peer("numpy", path)
    for *above, name in leaves(right):
        wrong = copy.deepcopy(right)
        group = functools.reduce(dict.__getitem__, above, wrong)
        group[name] = spoiled(name, group[name])
        assert len(differences(wrong, right, bounds)) == 1, (*above, name)


def spoiled(name, value):
    if name == "rings":
        return [*value[:-2], value[-1], value[-2]]
    if name in EXACT:
        return value + 1 if np.ndim(value) == 0 or len(value) else [0]
    value = np.array(value)
    numbers = value[:, 2] if name == "cotangent_laplacian" else value.reshape(-1)
    numbers[len(numbers) // 2] += 1e-6 * max(1, np.abs(numbers).max())
    return value
