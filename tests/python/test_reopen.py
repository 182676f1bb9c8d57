"""Other programs find whole what was written: meshes in trimesh and PyMeshLab, images in Pillow and OpenEXR."""

import numpy as np
import pytest
import trimesh

from baked import DUCK, SPOT
from clients import figures, missing

FLOAT = 2.0**-23
CARRIERS = [
    pytest.param(DUCK, "uvs", (), id="duck"),
    pytest.param(SPOT, "uvs", (), id="spot"),
    pytest.param(DUCK, "bare", ("--layout", "vertex"), id="bare-vertex"),
]


def in_order(rows):
    return rows[np.lexsort(rows.T[::-1])]


@pytest.mark.parametrize("mesh, uvs, options", CARRIERS)
def test_pymeshlab(mesh, uvs, options, baked):
    try:
        import pymeshlab
    except ImportError as error:
        missing(f"PyMeshLab cannot be loaded: {error}")
    case = baked(mesh, uvs, *options)
    # A mesh lives only as long as the set that it belongs to.
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.load_new_mesh(str(case.carrier))
    mesh = meshes.current_mesh()
    vertex, uv = case.corners.T
    assert np.array_equal(mesh.vertex_matrix(), case.positions)
    assert np.array_equal(mesh.vertex_normal_matrix(), case.normals)
    assert np.array_equal(mesh.face_matrix().ravel(), vertex)
    # It keeps texture coordinates in single precision.
    assert np.abs(mesh.wedge_tex_coord_matrix() - case.uvs[uv]).max() <= FLOAT


@pytest.mark.parametrize("mesh, uvs, options", CARRIERS)
def test_trimesh(mesh, uvs, options, baked):
    """It makes a mesh of each material; every corner of every triangle is in one of them."""
    case = baked(mesh, uvs, *options)
    scene = trimesh.load_scene(case.carrier, process=False)
    corners = np.concatenate(
        [np.hstack([part.vertices, part.visual.uv])[part.faces.ravel()] for part in scene.geometry.values()]
    )
    vertex, uv = case.corners.T
    expected = np.hstack([case.positions[vertex], case.uvs[uv]])
    assert np.array_equal(in_order(corners), in_order(expected))

    settings = case.manifest["clients"]["mtl"]
    for part in scene.geometry.values():
        option, base, gain, file = part.visual.material.kwargs["disp"]
        assert (option, file) == ("-mm", case.map["file"])
        assert {"base": float(base), "gain": float(gain)} == settings


FORMATS = [
    ("--bits", "8"),
    ("--bits", "16"),
    ("--bits", "32"),
    ("--format", "exr", "--bits", "16"),
    ("--format", "tiff", "--bits", "16"),
    ("--format", "tiff", "--bits", "32"),
]


@pytest.mark.parametrize("options", FORMATS, ids=lambda options: "-".join(options).replace("--", ""))
def test_image(options, baked):
    """The texels that the image holds for others give the heights that `apply` takes from it."""
    case = baked(DUCK, "uvs", *options)
    assert case.image.shape == (case.map["height"], case.map["width"])
    places = case.positions - case.map["lambda"] * case.bilinear[:, None] * case.normals
    error = case.errors(places, case.places)
    figures(f"reopen-{case.map['file']}", all=error)
    # `apply` rounds the height, the product and the sum.
    assert error.max() <= 3 * case.ulp / case.range
