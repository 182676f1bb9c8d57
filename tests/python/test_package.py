"""The Python package gives the bits of the command line."""

import subprocess

import numpy as np
import pytest
import trimesh

import planish as package
from clients import snippet
from conftest import REPO, reference_meshes
from packaged import DUCK, command, sphere


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
