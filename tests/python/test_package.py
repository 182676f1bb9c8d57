"""The Python package: the bits of the command line, meshes of other packages, errors, progress, threads, and its own words."""

import doctest
import importlib
import json
import os
import pkgutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh

import planish as package
from clients import snippet
from conftest import REPO, reference_meshes

DUCK = REPO / "data" / "duck_noisy.obj"


def command(planish, *args):
    """Runs the command line and returns its report."""
    done = subprocess.run([planish, *args, "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def sphere(subdivisions=3, noise=0.01):
    mesh = trimesh.creation.icosphere(subdivisions)
    random = np.random.default_rng(1)
    return np.array(mesh.vertices + random.normal(0, noise, mesh.vertices.shape)), np.array(mesh.faces)


# --- the same bits


@pytest.mark.parametrize("method", package.methods())
def test_every_method_gives_the_bits_of_the_command_line(method, planish, tmp_path):
    mesh = next(path for path in reference_meshes() if path.stem == "two_scales")
    expected = tmp_path / "expected.obj"
    command(planish, "denoise", mesh, "-o", expected, "--method", method)

    read = package.read(mesh)
    from_file = read.denoise(method)
    from_file.write(tmp_path / "found.obj")
    assert (tmp_path / "found.obj").read_bytes() == expected.read_bytes()

    from_arrays = package.denoise(read.vertices, read.faces, method)
    assert from_arrays.vertices.tobytes() == from_file.vertices.tobytes()
    assert from_arrays.deltas.tobytes() == from_file.deltas.tobytes()
    assert np.abs(from_arrays.deltas).max() > 0
    assert package.read(expected).vertices.tobytes() == from_file.vertices.tobytes()


def test_the_report_is_that_of_the_command_line(planish, tmp_path):
    options = ["--method", "guided-normals", "--iterations", "5", "--fix", "boundary", "--max-displacement", "0.3"]
    report = command(planish, "denoise", DUCK, "-o", tmp_path / "a.obj", *options)
    result = package.read(DUCK).denoise("guided-normals", iterations=5, fix="boundary", max_displacement=0.3)
    written = result.write(tmp_path / "b.obj")
    assert (tmp_path / "a.obj").read_bytes() == (tmp_path / "b.obj").read_bytes()
    ours = {**result.report, **written, "output": report["output"]}
    assert {key: ours[key] for key in report} == report


@pytest.mark.parametrize("extension", ["ply", "stl", "off", "glb"])
def test_files_of_other_programs_come_back_as_from_the_command_line(extension, planish, tmp_path):
    vertices, faces = sphere()
    path = tmp_path / f"mesh.{extension}"
    trimesh.Trimesh(vertices, faces, process=False).export(path)
    command(planish, "denoise", path, "-o", tmp_path / f"a.{extension}", "--method", "taubin")
    package.read(path).denoise("taubin").write(tmp_path / f"b.{extension}")
    assert (tmp_path / f"a.{extension}").read_bytes() == (tmp_path / f"b.{extension}").read_bytes()
    assert (tmp_path / f"a.{extension}").read_bytes() != path.read_bytes()


def test_a_bake_of_a_file_has_the_files_of_the_command_line(planish, tmp_path):
    command(planish, "bake", DUCK, "-o", tmp_path / "a", "--method", "taubin", "--size", "256", "--lambda", "0.5")
    bundle = package.read(DUCK).bake("taubin", folder=tmp_path / "b", size=256, lambda_=0.5)
    assert not (tmp_path / "b").exists()
    bundle.write()
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert names == sorted(path.name for path in (tmp_path / "b").iterdir()) == sorted(bundle.files)
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes() == bundle.files[name]
    with pytest.raises(package.InputError, match="give the folder to `bake`"):
        bundle.write(tmp_path / "c")


def test_a_bake_of_arrays_is_whole(planish, tmp_path):
    duck = package.read(DUCK)
    bundle = package.bake(duck.vertices, duck.faces, uvs=duck.uvs, uv_faces=duck.uv_faces, method="taubin", lambda_=0.7, size=128, name="d")
    for _ in range(2):
        paths = bundle.write(tmp_path)
    assert sorted(paths) == sorted(str(path) for path in tmp_path.iterdir())
    command(planish, "check", tmp_path / "d.planish.json")
    # The same surface gives the same map as the file does.
    folder = tmp_path / "file"
    package.read(DUCK).bake("taubin", folder=folder, lambda_=0.7, size=128).write()
    assert (folder / "duck_noisy.displacement.png").read_bytes() == bundle.files["d.displacement.png"]

    entry = bundle.manifest["displacement"]
    assert bundle.heights.shape == (entry["height"], entry["width"]) and bundle.normal_map.shape == (128, 128, 3)
    assert (bundle.bias, bundle.scale) == (entry["bias"], entry["scale"])
    assert bundle.heights.min() >= bundle.bias and bundle.heights.max() <= bundle.bias + bundle.scale
    # Half way is in the middle.
    noisy, half, denoised = (package.apply(tmp_path / "d.planish.json", lambda_=x).vertices for x in (0, 0.5, 1))
    assert np.abs((noisy + denoised) / 2 - half).max() < 1e-5 * np.ptp(noisy)
    assert np.abs(denoised - noisy).max() > 0.002 * np.ptp(noisy)


def bilinear(image, column, row):
    (i, j), (height, width) = np.floor((column, row)).astype(int), image.shape
    texel = lambda i, j: image[min(max(j, 0), height - 1), min(max(i, 0), width - 1)]
    a, b = column - i, row - j
    top, bottom = ((1 - a) * texel(i, k) + a * texel(i + 1, k) for k in (j, j + 1))
    return (1 - b) * top + b * bottom


def test_tiles_have_pages(tmp_path):
    side = 9
    x, y = (a.ravel().astype(float) for a in np.meshgrid(np.arange(side), np.arange(side)))
    vertices = np.stack([x, y, np.sin(13 * x + 7 * y) / 3], axis=1)
    corner = np.array([i * side + j for i in range(side - 1) for j in range(side - 1)])[:, None]
    faces = corner + np.array([0, 1, side + 1, side])
    uvs = np.stack([x / (side - 1) * 2, 0.05 + 0.1 * y], axis=1)
    bundle = package.bake(vertices, faces, uvs=uvs, method="laplacian", pages="udim", name="t")
    maps = bundle.manifest["pages"]["maps"]
    assert [page["tile"] for page in maps] == [1001, 1002] and list(bundle.pages) == ["1001", "1002"]
    assert [bundle.pages[str(page["tile"])].shape for page in maps] == [(page["height"], page["width"]) for page in maps]
    assert all(normals.shape[2] == 3 for normals in bundle.page_normal_maps.values())
    bundle.write(tmp_path)
    exact = package.bake(vertices, faces, method="laplacian", layout="vertex", bits=32, normals=bundle.manifest["normals"], name="e")
    exact.write(tmp_path)
    paged, one = (package.apply(tmp_path / f"{name}.planish.json").vertices for name in "te")
    assert np.abs(paged - one).max() <= bundle.report["error_bound"] + 1e-6

    # The functions of docs/clients.md lead to the same heights.
    code = {}
    exec(snippet("python-pages"), code)
    places = code["places"](tmp_path / "t.planish.json")
    assert sorted(places) == list(range(len(vertices)))
    for v, (page, place) in places.items():
        image = bundle.pages[str(page["tile"])]
        if not isinstance(place, tuple):
            u, v_up = np.float32(uvs[v if place is None else place]) - np.float32(code["corner"](page))
            place = u * page["width"] - 0.5, (1 - v_up) * page["height"] - 0.5
        assert bilinear(image, *place) == pytest.approx(bilinear(exact.heights, v % exact.heights.shape[1], v // exact.heights.shape[1]), abs=bundle.scale / 65535)


def test_a_bake_leads_to_a_target():
    vertices, faces = sphere()
    target = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    bundle = package.bake(vertices, faces, target=target, map="vector")
    assert bundle.heights.shape[2] == 3
    assert np.abs(bundle.heights).max() == pytest.approx(np.abs(vertices - target).max(), rel=1e-3)


@pytest.mark.parametrize("options", [["--sigma", "0.3"], ["--kind", "camera", "--towards", "1,2,3"], ["--kind", "voxels"]])
def test_noise_is_that_of_the_command_line(options, planish, tmp_path):
    clean = REPO / "data" / "flange_clean.obj"
    words = dict(zip(options[::2], options[1::2]))
    command(planish, "noise", clean, "-o", tmp_path / "a.obj", "--seed", "5", *options)
    settings = {name.lstrip("-"): value for name, value in words.items()}
    noisy = package.read(clean).noise(seed=5, **settings)
    noisy.write(tmp_path / "b.obj")
    assert (tmp_path / "a.obj").read_bytes() == (tmp_path / "b.obj").read_bytes()
    assert (noisy.clean is None) == ("voxels" not in options)


def test_compare_and_info_are_those_of_the_command_line(planish):
    clean = REPO / "data" / "duck_clean.obj"
    expected = command(planish, "compare", clean, DUCK)["results"][0]
    found = package.compare(package.read(clean), package.read(DUCK))
    assert found == {key: value for key, value in expected.items() if key != "file"}
    assert package.info(DUCK) == command(planish, "info", DUCK)
    assert list(package.methods().values()) == command(planish, "methods")


# --- arrays


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


# --- meshes of other packages


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


# --- time


def test_progress_is_told_and_stops_the_work():
    vertices, faces = sphere(5)
    told = []
    package.denoise(vertices, faces, "taubin", iterations=2000, progress=lambda stage, fraction: told.append((stage, fraction)))
    assert {stage for stage, _ in told} & {"denoising", "connecting"}
    assert all(0 <= fraction <= 1 for _, fraction in told)
    with pytest.raises(package.Interrupted):
        package.denoise(vertices, faces, "taubin", iterations=2000, progress=lambda stage, fraction: False)

    def fails(stage, fraction):
        raise KeyError(stage)

    with pytest.raises(KeyError):
        package.denoise(vertices, faces, "taubin", iterations=2000, progress=fails)


def test_ctrl_c_stops_the_work():
    vertices, faces = sphere(5)
    # A process that was started in the background ignores the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.3, os.kill, [os.getpid(), signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(100):
            package.denoise(vertices, faces, "taubin", iterations=2000)
    timer.join()
    signal.signal(signal.SIGINT, before)


def test_other_threads_run_meanwhile():
    """A thread that holds the interpreter would let nobody count."""
    vertices, faces = sphere(5)
    counted, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    results = [None, None]

    def work(i):
        results[i] = package.denoise(vertices, faces, "taubin", iterations=200).vertices

    workers = [threading.Thread(target=work, args=[i]) for i in range(2)]
    before = counted[0]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    during = counted[0] - before
    stop.set()
    thread.join()
    assert during > 5
    assert np.array_equal(*results)


def test_a_forked_process_can_work_as_well():
    script = (
        "import os, planish, numpy as np\n"
        "v = np.random.default_rng(1).random((50, 3)); f = np.arange(48).reshape(-1, 3)\n"
        "planish.denoise(v, f)\n"
        "pid = os.fork()\n"
        "if pid == 0:\n"
        "    planish.denoise(v, f); os._exit(7)\n"
        "print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert done.stdout == "7\n", done.stderr


# --- many meshes


def test_any_number_of_workers_gives_the_files_of_the_command_line(planish, tmp_path):
    import distributed
    from planish import dask

    paths = [path for path in reference_meshes() if path.stem in ("torus", "two_scales", "noisy_grid")]
    bad = tmp_path / "bad.obj"
    bad.write_text("v 0 0 x\n")
    for workers in (1, 2):
        results = dask.denoise_files([*paths, bad], tmp_path / str(workers), "taubin", workers=workers)
        assert [result["ok"] for result in results] == [True, True, True, False]
        assert "line 1" in results[3]["error"]
    # A client of the caller's own.
    with distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster, distributed.Client(cluster) as client:
        results = dask.bake_files(paths, tmp_path / "maps", "taubin", client=client, size=64)
    assert [Path(result["output"]).name for result in results] == [f"{path.stem}-planish" for path in paths]
    for path in paths:
        command(planish, "denoise", path, "-o", tmp_path / "one.obj", "--method", "taubin")
        for workers in ("1", "2"):
            assert (tmp_path / workers / path.name).read_bytes() == (tmp_path / "one.obj").read_bytes()
        folder = tmp_path / "maps" / f"{path.stem}-planish"
        command(planish, "bake", path, "-o", tmp_path / "maps" / "one", "--method", "taubin", "--size", "64")
        for file in folder.iterdir():
            assert file.read_bytes() == (tmp_path / "maps" / "one" / file.name).read_bytes()
    with pytest.raises(package.InputError, match="would have the same result"):
        dask.denoise_files([paths[0], tmp_path / paths[0].name], tmp_path)


# --- the command line in the wheel


def program():
    return Path(sys.executable).with_name("planish")


def test_the_wheel_has_the_command_line(planish, tmp_path):
    for args in (["--version"], ["info", str(DUCK), "--json"], ["denoise", "none.obj", "-o", "a.obj"], ["--nonsense"], []):
        ours, theirs = (subprocess.run([p, *args], capture_output=True, cwd=tmp_path) for p in (planish, program()))
        assert (ours.returncode, ours.stdout, ours.stderr) == (theirs.returncode, theirs.stdout, theirs.stderr)
    module = subprocess.run([sys.executable, "-m", "planish", "--version"], capture_output=True)
    assert module.stdout == subprocess.run([planish, "--version"], capture_output=True).stdout
    command(planish, "denoise", DUCK, "-o", tmp_path / "a.obj", "--method", "taubin")
    command(program(), "denoise", DUCK, "-o", tmp_path / "b.obj", "--method", "taubin")
    assert (tmp_path / "a.obj").read_bytes() == (tmp_path / "b.obj").read_bytes()


def test_ctrl_c_ends_the_command_line_of_the_wheel(tmp_path):
    mesh = tmp_path / "large.obj"
    package.Mesh(*sphere(7)).write(mesh)
    process = subprocess.Popen([program(), "denoise", mesh, "-o", tmp_path / "out.obj"], stderr=subprocess.PIPE, text=True)
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 1 and "interrupted; nothing was written" in errors, errors
    assert [path.name for path in tmp_path.iterdir()] == ["large.obj"]


# --- its own words


def modules():
    return [importlib.import_module(f"planish.{info.name}") for info in pkgutil.iter_modules(package.__path__)]


def test_examples_in_docstrings_are_true():
    found = [doctest.testmod(module) for module in [package, *(m for m in modules() if hasattr(m, "__file__"))]]
    assert sum(result.failed for result in found) == 0
    assert sum(result.attempted for result in found) > 20


def test_every_public_name_is_documented():
    for name in package.__all__:
        thing = getattr(package, name)
        assert thing.__doc__ and len(thing.__doc__) > 15, name
        if isinstance(thing, type):
            for member, value in vars(thing).items():
                assert member.startswith("_") or not callable(value) or value.__doc__, f"{name}.{member}"


def test_types_and_stubs_are_right():
    pytest.importorskip("mypy")
    env = {**os.environ, "MYPY_CACHE_DIR": os.devnull}
    config = ["--config-file", str(REPO / "crates" / "python" / "pyproject.toml")]
    checked = subprocess.run([sys.executable, "-m", "mypy", *config, "-p", "planish"], capture_output=True, text=True, env=env)
    assert checked.returncode == 0, checked.stdout
    stubs = [sys.executable, "-m", "mypy.stubtest", "planish._planish", "--mypy-config-file", config[1]]
    checked = subprocess.run(stubs, capture_output=True, text=True, env=env)
    assert checked.returncode == 0, checked.stdout + checked.stderr


def test_a_plot_shows_where_vertices_moved(tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    vertices, faces = sphere(2)
    axes = package.denoise(vertices, faces).plot()
    axes.figure.savefig(tmp_path / "plot.png")
    assert (tmp_path / "plot.png").stat().st_size > 5000
