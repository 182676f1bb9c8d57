"""three.js in Chromium: its own vertex shader puts every vertex where `planish apply` does.

The snippets of docs/clients.md load the files. What is read back is `transformed` at the end of the vertex shader that
three.js made for the material."""

import numpy as np
import pytest
from PIL import Image

from baked import DUCK, SPOT
from clients import figures, in_browser, numbers, picture

# Of the range: filters interpolate with rounded weights, and p + n h is rounded in another order than by `apply`.
EXACT = 2e-6


def looked_at(path):
    """The three views are no empty pictures, and displacing changes what is seen."""
    with Image.open(path) as image:
        grey = np.asarray(image.convert("L"), dtype=float)
    noisy, flat, smooth = np.split(grey, 3, axis=1)
    assert min(view.std() for view in (noisy, flat, smooth)) > 10, path
    roughness = [np.abs(np.diff(view, axis=1)).mean() for view in (noisy, flat)]
    assert roughness[1] < 0.9 * roughness[0], path


def shown(name, case, call, parameters, code, tmp_path):
    """Runs a snippet; gives for each of its meshes the vertices at rest and displaced, its materials, and the vertices
    that its faces use."""
    settings = case.manifest["clients"]["threejs"]
    arguments = {
        "call": call,
        "parameters": parameters,
        "settings": {"scale": settings["displacementScale"], "bias": settings["displacementBias"]},
    }
    path = picture(name, tmp_path)
    meshes = in_browser("threejs.js", arguments, case.folder, tmp_path, path, code)
    looked_at(path)
    return [(numbers(mesh["rest"]), numbers(mesh["displaced"]), mesh["materials"], mesh["used"]) for mesh in meshes]


EXR = ("--bits", "32")
VERTEX = ("--layout", "vertex")
# Browsers cut 16 bits to 8 on loading a PNG.
CUT = 1 / 255
# Bounds where a vertex samples at its dominant texture coordinate, and elsewhere: OBJLoader knows no dominant ones, so
# each wedge samples at its own.
CARRIERS = [
    pytest.param(DUCK, "uvs", EXR, EXACT, EXACT, id="duck-uv-32"),
    pytest.param(DUCK, "uvs", ("--bits", "8"), EXACT, CUT, id="duck-uv-8"),
    pytest.param(DUCK, "uvs", (*EXR, "--lambda", "0.5"), EXACT, EXACT, id="duck-uv-half"),
    pytest.param(DUCK, "beside", EXR, EXACT, EXACT, id="duck-beside-32"),
    pytest.param(SPOT, "uvs", EXR, EXACT, EXACT, id="spot-uv-32"),
    pytest.param(SPOT, "uvs", ("--bits", "16"), CUT, CUT, id="spot-uv-16"),
    pytest.param(DUCK, "bare", (*VERTEX, *EXR), EXACT, EXACT, id="duck-vertex-32"),
    pytest.param(DUCK, "bare", (*VERTEX, "--bits", "8"), EXACT, EXACT, id="duck-vertex-8"),
    pytest.param(DUCK, "bare", (*VERTEX, "--bits", "16"), CUT, CUT, id="duck-vertex-16"),
]


@pytest.mark.parametrize("mesh, uvs, options, bound, elsewhere", CARRIERS)
def test_carrier(mesh, uvs, options, bound, elsewhere, baked, tmp_path, request):
    case = baked(mesh, uvs, *options)
    assert case.map.get("tile", [0, 0]) == ([1, 0] if uvs == "beside" else [0, 0])
    name = f"threejs-{request.node.callspec.id}"
    meshes = shown(name, case, "loadCarrier", ["/files/", case.name], "threejs-obj", tmp_path)
    settings = case.manifest["clients"]["threejs"]
    for _, _, materials, _ in meshes:
        assert all(material == settings for material in materials)
    rest = np.concatenate([mesh[0] for mesh in meshes])
    displaced = np.concatenate([mesh[1] for mesh in meshes])
    # OBJLoader makes a vertex of every corner of every triangle.
    vertex, uv = case.corners.T
    assert np.array_equal(rest, case.positions[vertex].astype("f4"))

    error = case.errors(displaced, case.places[vertex])
    dominant = case.texels[vertex] == uv
    rounding = case.filtered + case.ulp / case.range
    figures(name, all=error, dominant=error[dominant])
    assert error[dominant].max() <= bound + rounding
    assert error[~dominant].max(initial=0) <= elsewhere + rounding


GLTFS = [
    pytest.param(DUCK, "uvs", EXR, id="duck-uv-32"),
    pytest.param(DUCK, "beside", EXR, id="duck-beside-32"),
    pytest.param(SPOT, "uvs", EXR, id="spot-uv-32"),
    pytest.param(DUCK, "uvs", (*VERTEX, *EXR), id="duck-vertex-32"),
    pytest.param(DUCK, "uvs", (*VERTEX, "--bits", "8"), id="duck-vertex-8"),
    pytest.param(DUCK, "bare", (*VERTEX, *EXR), id="bare-vertex-32"),
    pytest.param(DUCK, "folded", ("--layout", "auto", *EXR), id="folded-private-32"),
]


@pytest.mark.parametrize("mesh, uvs, options", GLTFS)
def test_gltf_map(mesh, uvs, options, baked, tmp_path, request):
    """All vertices exactly, those at seams too: TEXCOORD_1 is where the vertex samples."""
    case = baked(mesh, uvs, *options)
    name = f"threejs-gltf-{request.node.callspec.id}"
    parameters = [f"/files/{case.glb.name}", case.map["lambda"]]
    for rest, displaced, materials, _ in shown(name, case, "loadDisplaced", parameters, "threejs-gltf", tmp_path):
        error = case.errors(displaced, case.places[case.vertices_at(rest)])
        figures(name, all=error)
        assert materials == [case.manifest["clients"]["threejs"]]
        assert error.max() <= EXACT + case.filtered + case.ulp / case.range


@pytest.mark.parametrize("options", [EXR], ids=["32"])
def test_gltf_pages(options, baked, tmp_path, request):
    """Two tiles: each page puts all vertices of its faces right, those on the border of the tiles too."""
    case = baked(DUCK, "tiles", "--pages", "udim", *options)
    pages = case.manifest["pages"]["maps"]
    assert [page["tile"] for page in pages] == [1001, 1002]
    name = f"threejs-pages-{request.node.callspec.id}"
    parameters = [f"/files/{case.glb.name}", case.map["lambda"]]
    # The pages that hold a vertex differ by a step of the map at most.
    step = case.manifest["report"]["quantum"] / case.range
    found = np.zeros(len(case.positions), dtype=int)
    for rest, displaced, materials, used in shown(name, case, "loadDisplaced", parameters, "threejs-gltf", tmp_path):
        vertex = case.vertices_at(rest[used])
        np.add.at(found, np.unique(vertex), 1)
        error = case.errors(displaced[used], case.places[vertex])
        figures(name, all=error)
        assert materials == [case.manifest["clients"]["threejs"]]
        assert error.max() <= EXACT + step + case.filtered + case.ulp / case.range
    assert found.min() >= 1 and (found > 1).any(), "all vertices are on a page, and some on both"


@pytest.mark.parametrize("mesh", [DUCK, SPOT], ids=["duck", "spot"])
def test_gltf_morph(mesh, baked, tmp_path):
    case = baked(mesh, "uvs", *EXR)
    name = f"threejs-morph-{mesh.stem}"
    parameters = [f"/files/{case.glb.name}", 1]
    for rest, displaced, *_ in shown(name, case, "loadMorphed", parameters, "threejs-morph", tmp_path):
        error = case.errors(displaced, case.places[case.vertices_at(rest)])
        figures(name, all=error)
        # The offset is rounded to single precision, and so is the sum.
        assert error.max() <= EXACT + case.ulp / case.range
