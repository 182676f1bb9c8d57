"""The GLSL of docs/clients.md in WebGL 2: positions are those of `planish apply`."""

import pytest

from baked import DUCK, SPOT
from clients import figures, in_browser, numbers, text

# Of the range: the same formula in single precision, where the driver may fuse products with sums.
EXACT = 1e-6
CASES = [
    pytest.param(DUCK, "uvs", ("--bits", "16"), "heightAt(uv)", id="duck-uv-16"),
    pytest.param(SPOT, "uvs", ("--bits", "32"), "heightAt(uv)", id="spot-uv-32"),
    pytest.param(DUCK, "bare", ("--layout", "vertex", "--bits", "32"), "heightOf(gl_VertexID)", id="bare-vertex-32"),
]


@pytest.mark.parametrize("mesh, uvs, options, height", CASES)
def test_glsl(mesh, uvs, options, height, baked, tmp_path, request):
    case = baked(mesh, uvs, *options)
    entry = case.map
    arguments = {
        "height": height,
        "positions": text(case.positions),
        "normals": text(case.normals),
        "uvs": text(case.sampled_at),
        "image": text(case.image),
        "size": [entry["width"], entry["height"]],
        "parameters": {key: entry[key] for key in ("bias", "scale", "lambda")},
    }
    places = numbers(in_browser("glsl.js", arguments, case.folder, tmp_path, code="glsl"))
    error = case.errors(places, case.places)
    figures(f"glsl-{request.node.callspec.id}", all=error)
    assert error.max() <= EXACT + case.ulp / case.range
