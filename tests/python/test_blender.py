"""Blender: its Displace modifier and the shape key of the .glb put every vertex where `planish apply` does, and it bakes the same ambient
occlusion."""

import numpy as np
import pytest
from PIL import Image

from baked import DUCK, SPOT
from clients import SCRIPTS, execute, figures, program, snippet

# Of the range: Blender computes the angle-weighted normals itself, from single precision.
NORMALS = 5e-5
# Those of the carrier it keeps as two angles of 16 bits.
CUSTOM_NORMALS = 1e-3


def evaluated(code, call, file, tmp_path):
    """Positions at rest and evaluated of what a snippet makes of a file, n x 3 each."""
    blender = program("blender")
    (tmp_path / "code.py").write_text(snippet(code), encoding="utf-8")
    out = tmp_path / "positions.f32"
    script = [blender, "-b", "--factory-startup", "--python", SCRIPTS / "blender.py", "--"]
    execute([*script, tmp_path / "code.py", call, file, out])
    return np.fromfile(out, dtype="<f4").reshape(2, -1, 3).astype(float)


CASES = [
    pytest.param(DUCK, "uvs", ("--bits", "16"), id="duck-uv-16"),
    pytest.param(DUCK, "uvs", ("--bits", "32", "--lambda", "0.5"), id="duck-uv-half"),
    pytest.param(DUCK, "beside", ("--bits", "32"), id="duck-beside-32"),
    pytest.param(SPOT, "uvs", ("--bits", "32"), id="spot-uv-32"),
    pytest.param(DUCK, "uvs", ("--layout", "vertex", "--bits", "32"), id="duck-vertex-32"),
    pytest.param(DUCK, "bare", ("--layout", "vertex", "--bits", "16"), id="bare-vertex-16"),
    pytest.param(DUCK, "folded", ("--layout", "auto", "--bits", "32"), id="folded-private-32"),
    pytest.param(DUCK, "uvs", ("--normals", "angle", "--bits", "32"), id="duck-angle"),
    pytest.param(DUCK, "uvs", ("--normals", "denoised", "--bits", "32"), id="duck-denoised"),
    pytest.param(DUCK, "uvs", ("--normals", "leaning", "--bits", "32"), id="duck-leaning"),
    pytest.param(DUCK, "uvs", ("--normals", "area", "--bits", "32"), id="duck-area"),
    pytest.param(DUCK, "uvs", ("--map", "vector", "--bits", "32"), id="duck-vector-uv"),
    pytest.param(DUCK, "uvs", ("--map", "vector", "--layout", "vertex", "--bits", "16"), id="duck-vector-vertex"),
]


@pytest.mark.parametrize("mesh, uvs, options", CASES)
def test_displace_modifier(mesh, uvs, options, baked, tmp_path, request):
    case = baked(mesh, uvs, *options)
    (manifest,) = case.folder.glob("*.planish.json")
    rest, displaced = evaluated("blender-displace", "import_displaced", manifest, tmp_path)
    assert np.array_equal(rest, case.positions.astype("f4")), "the order of the vertices is lost"

    error = case.errors(displaced, case.places)
    custom = case.manifest["clients"]["blender"]["direction"] == "CUSTOM_NORMAL"
    bound = (CUSTOM_NORMALS if custom else NORMALS) + case.filtered
    figures(f"blender-{request.node.callspec.id}", all=error, away_from_seams=error[~case.seam])
    assert case.private.any() == (uvs == "folded")
    single = ~case.seam | case.private
    assert error[single].max() <= bound
    # At seams Blender samples at the texture coordinate of whichever corner comes first, from which the bake sees to a quantum.
    quantum = case.manifest["report"]["quantum"] / case.range
    if uvs != "folded":
        # Upon other charts, the other corners of a vertex cannot all be given its height.
        assert error[~single].max(initial=0) <= bound + quantum


@pytest.mark.parametrize(
    "mesh, uvs, options",
    [(DUCK, "uvs", ()), (SPOT, "uvs", ()), (DUCK, "tiles", ("--pages", "udim"))],
    ids=["duck", "spot", "duck-pages"],
)
def test_shape_key(mesh, uvs, options, baked, tmp_path, request):
    case = baked(mesh, uvs, "--bits", "32", *options)
    assert ("pages" in case.manifest) == (uvs == "tiles")
    rest, displaced = (
        # Blender turns y up into z up: (x, y, z) becomes (x, -z, y).
        np.stack([p[:, 0], p[:, 2], -p[:, 1]], axis=1)
        for p in evaluated("blender-morph", "import_morphed", case.glb, tmp_path)
    )
    error = case.errors(displaced, case.places[case.vertices_at(rest)])
    figures(f"blender-morph-{request.node.callspec.id}", all=error)
    # The offset is rounded to single precision, and so is the sum; the heights of a map of pages agree to a step.
    step = case.manifest["report"]["quantum"] / case.range if options else 0
    assert error.max() <= 2e-6 + step + case.ulp / case.range


def test_ambient_occlusion(baked, tmp_path):
    """Blender lights faces, planish blends normals across gentle edges, and both cast rays at random: the same within a few grey levels."""
    size = 256
    case = baked(DUCK, "uvs", "--method", "taubin", "--ao", "--ao-rays", "512", "--size", str(size))
    image = Image.open(case.folder / case.manifest["occlusion"]["file"]).convert("L")
    ours = np.asarray(image, dtype=float) / 255
    blender = program("blender")
    out = tmp_path / "ao.f32"
    script = [blender, "-b", "--factory-startup", "--python", SCRIPTS / "blender_ao.py", "--"]
    execute([*script, case.folder / "applied.obj", str(size), "512", out])
    theirs, covered = np.moveaxis(np.fromfile(out, dtype="<f4").reshape(size, size, 2).astype(float), 2, 0)
    assert ours.shape == theirs.shape and covered.mean() > 0.4
    off = (ours - theirs)[covered == 1]
    figures("blender-ao", all=np.abs(off), average=np.abs(off).mean()[None], of_means=np.abs(off.mean())[None])
    assert theirs[covered == 1].std() > 0.05, "there is something to see"
    assert abs(off.mean()) < 0.005
    assert np.abs(off).mean() < 0.02
    assert np.quantile(np.abs(off), 0.99) < 0.1
