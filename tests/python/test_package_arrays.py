"""Arrays and meshes of other packages in the Python package, and what is wrong with them."""

import numpy as np
import pytest
import trimesh

import planish as package
from packaged import DUCK, command, sphere


def test_arrays_of_other_types_and_orders_give_the_same_bits():
    vertices, faces = sphere(2)
    expected = package.denoise(vertices, faces, "taubin").vertices
    for f in (faces.astype(np.int32), faces.astype(np.uint32), faces.astype(np.uint8), faces.tolist(), np.asfortranarray(faces)):
        assert np.array_equal(package.denoise(vertices, f, "taubin").vertices, expected)
    for v in (np.asfortranarray(vertices), vertices.tolist(), np.repeat(vertices, 2, axis=0)[::2]):
        assert np.array_equal(package.denoise(v, faces, "taubin").vertices, expected)
    single = package.denoise(vertices.astype("f4"), faces, "taubin")
    assert single.vertices.dtype == np.float64 and np.abs(single.vertices - expected).max() < 1e-6


def test_arrays_are_not_changed_and_need_not_be_writable():
    vertices, faces = sphere(2)
    before = vertices.copy()
    vertices.setflags(write=False)
    faces.setflags(write=False)
    result = package.denoise(vertices, faces)
    assert np.array_equal(vertices, before)
    assert np.abs(result.vertices + result.deltas - before).max() < 1e-15


def test_polygons_of_any_number_of_corners(tmp_path, planish):
    path = tmp_path / "mixed.obj"
    path.write_text("v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 4 3 2 1\n")
    mesh = package.read(path)
    assert [len(face) for face in mesh.faces] == [3, 3, 3, 3, 4]
    found = package.denoise(mesh.vertices, mesh.faces, "laplacian").vertices
    assert np.array_equal(found, mesh.denoise("laplacian").vertices)
    quads = package.denoise([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1]], [[0, 1, 2, 3]], "laplacian", fix=[0])
    assert quads.report["faces"] == 1 and quads.report["limits"]["fixed_vertices"] == 1


def test_vertices_that_stay():
    vertices, faces = sphere(2)
    mask = vertices[:, 2] > 0
    for fix in (mask, np.flatnonzero(mask), np.flatnonzero(mask).tolist()):
        result = package.denoise(vertices, faces, "taubin", fix=fix)
        assert np.array_equal(result.vertices[mask], vertices[mask])
        assert not np.any(np.all(result.vertices[~mask] == vertices[~mask], axis=1))


ERRORS = [
    (lambda v, f: (v[:, :2], f), {}, r"`vertices` has the shape \(162, 2\) and needs \(n, 3\)"),
    (lambda v, f: (v, f[:, 0]), {}, r"`faces` has the shape \(320,\)"),
    (lambda v, f: (v, f[:, :2]), {}, r"`faces\[0\]` has 2 corners and needs at least three"),
    (lambda v, f: (v, f[:0]), {}, "`faces` is empty"),
    (lambda v, f: (v, f + 100), {}, r"`faces\[\d+\]` names element \d+ of `vertices`, which has 162"),
    (lambda v, f: (v, f - 1), {}, r"`faces\[\d+\]` names element -1 of `vertices`"),
    (lambda v, f: (v, f.astype(float)), {}, "`faces` has the type float64 and needs whole numbers"),
    (lambda v, f: (np.where(np.arange(162)[:, None] == 7, np.nan, v), f), {}, r"`vertices\[7\]` is not finite"),
    (lambda v, f: (v * 1e60, f), {}, r"`vertices\[\d+\]`: a coordinate is too large"),
    (lambda v, f: ([["a", "b", "c"]], f), {}, "`vertices` is no array of numbers"),
    (lambda v, f: (v, [[0, 0, 1]]), {}, "no face has three different vertices"),
    (lambda v, f: (v, f), {"method": "magic"}, "there is no method `magic`"),
    (lambda v, f: (v, f), {"radius": 3}, "auto has no setting `radius`; it has"),
    (lambda v, f: (v, f), {"method": "taubin", "iterations": -1}, "setting `iterations` of taubin: -1 is not a whole number"),
    (lambda v, f: (v, f), {"method": "taubin", "step": np.nan}, "a setting is infinite or not a number"),
    (lambda v, f: (v, f), {"fix": [200]}, "`fix`: .*201"),
    (lambda v, f: (v, f), {"fix": [-1]}, r"`fix\[0\]` is negative"),
    (lambda v, f: (v, f), {"max_displacement": -1.0}, "`max_displacement` is a number between 0 and"),
    (lambda v, f: (v, f), {"mask": [0.5]}, "`mask` has 1 weights, and the mesh has 162 vertices"),
    (lambda v, f: (v, f), {"mask": np.full(162, 1.5)}, r"`mask\[0\]` is 1.5, and weights are from 0 to 1"),
    (lambda v, f: (v, f), {"mask": np.ones((162, 2))}, r"`mask` has the shape \(162, 2\) and needs"),
    (lambda v, f: (v, f), {"direction": "up"}, "`direction`: `up` is no direction"),
    (lambda v, f: (v, f), {"direction": [0, 0, 0]}, "`direction`: .* is no direction"),
    (lambda v, f: (v, f), {"direction": [0, np.inf, 0]}, "`direction` is three numbers"),
    (lambda v, f: (v, f), {"weld": "near"}, "`weld` is \"exact\", \"none\" or a distance"),
    (lambda v, f: (v, f), {"weld": 5.0}, "more than a hundredth of the mesh"),
    (lambda v, f: (v, f), {"preset": "best"}, "`preset` is \"default\" or \"paper\", not \"best\""),
]


@pytest.mark.parametrize("arrays, options, message", ERRORS)
def test_what_is_wrong_is_named(arrays, options, message):
    with pytest.raises(package.InputError, match=message) as caught:
        package.denoise(*arrays(*sphere(2)), **options)
    assert isinstance(caught.value, ValueError) and "\n" not in str(caught.value)


def test_what_is_wrong_with_files_is_named(tmp_path):
    bad = tmp_path / "bad.obj"
    bad.write_text("v 0 0 0\nv 1 0 0\nv 0 x 0\nf 1 2 3\n")
    with pytest.raises(package.InputError, match=r"bad.obj: line 3"):
        package.read(bad)
    with pytest.raises(package.InputError, match="none.obj"):
        package.read(tmp_path / "none.obj")
    mesh = package.read(DUCK)
    with pytest.raises(package.InputError, match="is an input"):
        mesh.denoise("laplacian").write(DUCK)
    with pytest.raises(package.InputError, match="a size is"):
        mesh.bake(size="big")
    with pytest.raises(package.InputError, match="--length goes with --kind spikes"):
        mesh.noise(0.1, length=3)
    vertices, faces = sphere(1)
    with pytest.raises(package.InputError, match="`uvs` has 2 rows and needs 42"):
        package.bake(vertices, faces, uvs=[[0, 0], [1, 1]])
    with pytest.raises(package.InputError, match=r"`uv_faces\[0\]` names element"):
        package.bake(vertices, faces, uvs=[[0, 0], [1, 1]], uv_faces=faces + 2)
    with pytest.raises(package.InputError, match="is no name of a file"):
        package.bake(vertices, faces, name="a/b")


def test_weights_say_how_far_vertices_go():
    vertices, faces = sphere(2)
    free = package.denoise(vertices, faces, "taubin")
    weights = np.linspace(0, 1, len(vertices))
    result = package.denoise(vertices, faces, "taubin", mask=weights)
    assert np.abs(result.deltas - free.deltas * (np.round(weights * 255) / 255)[:, None]).max() < 1e-12
    assert np.array_equal(result.vertices[0], vertices[0]) and np.array_equal(result.vertices[-1], free.vertices[-1])
    assert result.report["limits"]["weighted_vertices"] == len(vertices) - 1
    mesh = package.Mesh(vertices, faces)
    assert mesh.denoise("taubin", mask=weights).vertices.tobytes() == result.vertices.tobytes()
    bundle = mesh.bake("taubin", mask=weights.tolist(), map="vector")
    # The map holds 16 bits of the largest displacement.
    target = mesh.bake("taubin", target=result.vertices, map="vector")
    assert np.abs(bundle.heights - target.heights).max() < 1e-6 and bundle.manifest["method"]["limits"]["mask"]["from"] == "array"


def test_weights_are_those_of_the_command_line(planish, tmp_path):
    """Colours as single-precision weights: the mask `colour:red` and the same array."""
    vertices, faces = sphere(2)
    red = np.random.default_rng(3).integers(0, 256, len(vertices)).astype("u1")
    path = tmp_path / "mesh.ply"
    trimesh.Trimesh(vertices, faces, vertex_colors=np.stack([red] * 3 + [red * 0 + 255], 1), process=False).export(path)
    command(planish, "denoise", path, "-o", tmp_path / "a.ply", "--method", "taubin", "--mask", "colour:red")
    package.read(path).denoise("taubin", mask=(red / 255).astype("f4")).write(tmp_path / "b.ply")
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes() != path.read_bytes()


@pytest.mark.parametrize("text, direction", [("0.5,0,1", (0.5, 0, 1)), ("ray:0,0,3", "ray:0,0,3")])
def test_directions_are_those_of_the_command_line(text, direction, planish, tmp_path):
    command(planish, "denoise", DUCK, "-o", tmp_path / "a.obj", "--method", "taubin", "--direction", text)
    package.read(DUCK).denoise("taubin", direction=direction).write(tmp_path / "b.obj")
    assert (tmp_path / "a.obj").read_bytes() == (tmp_path / "b.obj").read_bytes()




def test_a_trimesh_is_given_back_with_all_that_it_has():
    vertices, faces = sphere(2)
    colours = np.random.default_rng(2).integers(0, 255, (len(vertices), 4))
    mesh = trimesh.Trimesh(vertices, faces, vertex_colors=colours, process=False)
    result = package.denoise(mesh, method="taubin")
    assert isinstance(result.mesh, trimesh.Trimesh) and result.mesh is not mesh
    assert np.array_equal(result.mesh.vertices, package.denoise(vertices, faces, "taubin").vertices)
    assert np.array_equal(result.mesh.visual.vertex_colors, mesh.visual.vertex_colors)
    assert np.array_equal(mesh.vertices, vertices)
    assert package.denoise(vertices, faces, "taubin").mesh is None
    uvs = np.random.default_rng(3).random((len(vertices), 2))
    mesh.visual = trimesh.visual.TextureVisuals(uv=uvs)
    assert np.array_equal(package.bake(mesh, method="taubin", size=64, layout="uv").heights.shape, (64, 64))


def test_a_pyvista_mesh_is_given_back():
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.Sphere()
    mesh.point_data["name"] = np.arange(mesh.n_points)
    result = package.denoise(mesh, method="taubin")
    assert isinstance(result.mesh, pyvista.PolyData) and result.mesh.points.dtype == mesh.points.dtype
    assert np.abs(result.mesh.points - mesh.points).max() > 0
    assert np.array_equal(result.mesh.point_data["name"], mesh.point_data["name"])
    assert result.report["faces"] == mesh.n_faces_strict


def test_an_open3d_mesh_is_given_back():
    open3d = pytest.importorskip("open3d", exc_type=ImportError)
    mesh = open3d.geometry.TriangleMesh.create_torus()
    mesh.compute_vertex_normals()
    result = package.denoise(mesh, method="taubin")
    assert isinstance(result.mesh, open3d.geometry.TriangleMesh)
    assert np.array_equal(np.asarray(result.mesh.vertices), result.vertices)
    assert np.abs(result.vertices - np.asarray(mesh.vertices)).max() > 0


def test_what_is_no_mesh_is_refused():
    with pytest.raises(package.InputError, match="a dict is no mesh"):
        package.denoise({})
