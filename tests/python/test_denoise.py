"""`planish denoise --method laplacian` against ten lines of scipy, on every mesh there is; and what a rewrite keeps."""

import subprocess

import numpy as np
import pytest
from scipy.sparse import coo_matrix, diags

import obj
from bounds import EPS, REL
from conftest import MESHES, NO_MESHES, REPO, parameters, reference_meshes, unpacked
from polygons import tidied, welded

ITERATIONS, STEP = 10, 0.5
OPTIONS = ["--method", "laplacian", "--iterations", str(ITERATIONS), "--step", str(STEP)]

OURS = [*reference_meshes(), *sorted((REPO / "data").glob("*.obj"))]
THEIRS = sorted(path for suffix in ("*.obj", "*.obj.xz") for path in MESHES.rglob(suffix)) if MESHES else []
MESHES = [*parameters(OURS), *parameters(THEIRS, NO_MESHES)]


def smoothed(positions, polygons):
    """Positions after the steps, and how often rounding may have hit each: its valence and a little, every step."""
    vertex, faces = welded(positions, polygons)
    faces = tidied(faces)
    n = len(positions)
    halves = np.array([(a, b) for f in faces for a, b in zip(f, [*f[1:], f[0]])]).reshape(-1, 2)
    edges, uses = np.unique(np.sort(halves, axis=1), axis=0, return_counts=True)
    i, j = np.concatenate([edges, edges[:, ::-1]]).T
    adjacency = coo_matrix((np.ones(len(i)), (i, j)), shape=(n, n)).tocsr()
    valence = np.bincount(i, minlength=n)
    moves = valence > 0
    moves[edges[uses == 1].ravel()] = False
    mean = diags(1 / np.maximum(valence, 1)) @ adjacency
    result = np.zeros((n, 3))
    result[vertex] = positions
    for _ in range(ITERATIONS):
        result[moves] += STEP * (mean @ result - result)[moves]
    return result[vertex], ITERATIONS * (valence.max(initial=0) + 3)


def vertex_lines(text):
    """Whether each line is a `v` line."""
    return [line.split(None, 1)[:1] == [b"v"] for line in text]


@pytest.mark.parametrize("path", MESHES)
def test_laplacian(path, planish, tmp_path):
    before, after = unpacked(path, tmp_path), tmp_path / "denoised.obj"
    subprocess.run([planish, "denoise", before, "-o", after, *OPTIONS], check=True, capture_output=True)

    positions, polygons = obj.read(before)
    expected, roundings = smoothed(positions, polygons)
    actual, polygons_after = obj.read(after)
    # Means of coordinates lose ulps of the coordinates, not of the mesh, however far from the origin it lies.
    scale = np.linalg.norm(np.ptp(positions, axis=0))
    bound = REL * scale + roundings * EPS * np.abs(positions).max()
    assert polygons_after == polygons
    assert actual.shape == expected.shape
    worst = np.abs(actual - expected).max()
    assert worst <= bound, f"{worst:.3g} off, {worst / scale:.3g} of the diagonal"

    lines, lines_after = before.read_bytes().splitlines(True), after.read_bytes().splitlines(True)
    is_vertex = vertex_lines(lines)
    assert vertex_lines(lines_after) == is_vertex
    kept = [(old, new) for old, new, moved in zip(lines, lines_after, is_vertex) if not moved]
    assert all(old == new for old, new in kept)
    # Colours and weights stand behind the coordinates.
    tails = [(old.split()[4:], new.split()[4:]) for old, new, moved in zip(lines, lines_after, is_vertex) if moved]
    assert all(old == new for old, new in tails)


def test_the_step_moves_something():
    """Otherwise a command that copies its input would pass."""
    positions, polygons = obj.read(reference_meshes()[0])
    expected, _ = smoothed(positions, polygons)
    assert np.abs(expected - positions).max() > 1e-3
