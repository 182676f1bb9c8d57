"""The map of one mesh in tiles: a bundle that is checked and applied, the heights of a bake of the whole mesh, borders, and work that is
gone on with."""

import json
import subprocess

import numpy as np
import pytest
from PIL import Image

import planish as package
from packaged import command
from planish import dask
from test_large import torus, write_ply


def numbers(text):
    """The indices, from 0, that a text such as "7, 9-11" names."""
    runs = [[int(n) for n in word.split("-")] for word in text.replace(",", " ").split()]
    return np.concatenate([np.arange(run[0] - 1, run[-1]) for run in runs])


def pages(folder, manifest):
    """Of each page the vertices that have a texel there, their heights in model units, and whether they sample the page."""
    entry = manifest["displacement"]
    for page in manifest["pages"]["maps"]:
        texels = np.asarray(Image.open(folder / page["file"]), dtype=np.float64).reshape(page["height"] * page["width"], -1)
        vertices = numbers(page["texels"])
        heights = entry["bias"] + entry["scale"] * texels[: len(vertices)] / (2 ** entry["bits"] - 1)
        yield vertices, heights, np.isin(vertices, numbers(page["vertices"]))


def of_vertices(folder, manifest):
    """Height of each vertex, as the page that it samples has it, and the largest difference of another page from that."""
    heights = np.full((manifest["source"]["vertices"], 1), np.nan)
    for vertices, found, samples in pages(folder, manifest):
        assert np.isnan(heights[vertices[samples]]).all()
        heights[vertices[samples]] = found[samples]
    assert not np.isnan(heights).any()
    differences = [np.abs(heights[vertices] - found) for vertices, found, _ in pages(folder, manifest)]
    return heights[:, 0], max(each.max() for each in differences), sum((~samples).sum() for *_, samples in pages(folder, manifest))


@pytest.mark.parametrize("extension", ["ply", "obj"])
def test_tiles_have_the_heights_of_a_bake_of_the_whole_mesh(extension, planish, client, tmp_path):
    path = tmp_path / f"mesh.{extension}"
    points, faces = torus(120, 80)
    if extension == "ply":
        write_ply(path, points, faces)
    else:
        package.Mesh(points, faces).write(path)
    report = dask.bake_large(path, tmp_path / "tiles", "taubin", client=client, tiles=5)
    assert report["exact"] and len(report["pages"]) == 5
    folder = tmp_path / "tiles"
    expected = {f"mesh.displacement.{tile}.png" for tile in range(5)} | {"mesh.obj", "mesh.mtl", "mesh.planish.json"}
    assert {file.name for file in folder.iterdir()} == expected
    assert {file.name for file in tmp_path.iterdir()} == {path.name, "tiles"}
    manifest = json.loads((folder / "mesh.planish.json").read_text())
    assert (manifest["planish"], manifest["pages"]["by"], manifest["displacement"]["layout"]) == (6, "cut", "vertex")
    assert (manifest["method"]["name"], manifest["normals"]) == ("taubin", "angle")

    heights, difference, copies = of_vertices(folder, manifest)
    # A vertex at a border has the same step on all of its pages.
    assert difference == 0 and copies > 500 and manifest["report"]["seam_gap"] == 0
    command(planish, "bake", path, "-o", tmp_path / "whole", "--method", "taubin", "--layout", "vertex")
    whole = json.loads((tmp_path / "whole" / "mesh.planish.json").read_text())
    entry = whole["displacement"]
    assert {key: manifest["displacement"][key] for key in ("bias", "scale", "origin")} == {key: entry[key] for key in ("bias", "scale", "origin")}
    texels = np.asarray(Image.open(tmp_path / "whole" / entry["file"]), dtype=np.float64).ravel()[: len(heights)]
    exact = entry["bias"] + entry["scale"] * texels / 65535
    assert np.abs(heights - exact).max() <= 0.5 * manifest["report"]["quantum"]
    for figure in ("max_error", "mean_error", "left_out_rms", "quantum"):
        assert manifest["report"][figure] == pytest.approx(whole["report"][figure], rel=1e-3), figure
    for figure in ("turned_deg", "lost_deg"):
        assert manifest["report"]["heights"][figure] == pytest.approx(whole["report"]["heights"][figure], rel=1e-6), figure

    assert command(planish, "check", folder / "mesh.planish.json")["differences"] == []
    for name in ("tiles", "whole"):
        command(planish, "apply", tmp_path / name / "mesh.planish.json", "-o", tmp_path / f"{name}.obj")
    applied = [package.read(tmp_path / f"{name}.obj").vertices for name in ("tiles", "whole")]
    assert np.abs(applied[0] - applied[1]).max() <= manifest["report"]["error_bound"]
    # The carrier has the mesh and its normals, in the order of the file.
    carrier = package.read(folder / "mesh.obj")
    mesh = package.read(path)
    assert np.array_equal(carrier.vertices, mesh.vertices) and np.array_equal(carrier.faces, mesh.faces)


@pytest.mark.parametrize("options", [{"method": "auto", "halo": 20}, {"method": "sun"}, {"method": "taubin", "max_displacement": 0.1}])
def test_other_methods_lead_to_the_denoised_mesh_of_the_bundle(options, planish, client, tmp_path):
    path = tmp_path / "mesh.ply"
    write_ply(path, *torus(90, 60))
    report = dask.bake_large(path, tmp_path / "tiles", client=client, tiles=3, **options)
    manifest = json.loads((tmp_path / "tiles" / "mesh.planish.json").read_text())
    assert (manifest["method"]["name"], manifest["method"]["file"]) == ("target", "mesh.denoised.ply")
    assert command(planish, "check", report["manifest"])["differences"] == []
    dask.denoise_large(path, tmp_path / "denoised.ply", client=client, tiles=3, **options)
    assert (tmp_path / "denoised.ply").read_bytes() == (tmp_path / "tiles" / "mesh.denoised.ply").read_bytes()
    _, difference, copies = of_vertices(tmp_path / "tiles", manifest)
    assert difference == 0 and copies > 100


def test_a_vector_map_leads_to_the_denoised_positions(planish, client, tmp_path):
    path = tmp_path / "mesh.obj"
    package.Mesh(*torus(90, 60)).write(path)
    report = dask.bake_large(path, tmp_path / "out", "bilateral-normals", client=client, tiles=3, map="vector", bits=32, lambda_=0.5)
    manifest = json.loads((tmp_path / "out" / "mesh.planish.json").read_text())
    assert (manifest["method"]["name"], manifest["displacement"]["lambda"]) == ("bilateral-normals", 0.5)
    assert command(planish, "check", report["manifest"])["differences"] == []
    command(planish, "apply", report["manifest"], "-o", tmp_path / "applied.obj", "--lambda", "1")
    whole = package.read(path).denoise("bilateral-normals").vertices
    assert np.abs(package.read(tmp_path / "applied.obj").vertices - whole).max() <= report["report"]["error_bound"] < 1e-6


def test_seams_and_polygons_and_loose_vertices_are_baked(planish, client, tmp_path):
    """Source vertices of one place, a quad, a vertex without faces, and a mesh far from the origin."""
    points, faces = torus(60, 40)
    points = points + [500_000, 4_500_000, 100]
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += [lines[7], "v 500000 4500000 100", "v 500002.5 4500000 100", "v 500003 4500000 100", "v 500003 4500000.5 100", "v 500002.5 4500000.5 100"]
    count = len(points)
    lines += [f"f {count + 1 if v[0] == 7 else v[0] + 1} {v[1] + 1} {v[2] + 1}" for v in faces.tolist()]
    lines += [f"f {count + 3} {count + 4} {count + 5} {count + 6}"]
    path = tmp_path / "mesh.obj"
    path.write_text("\n".join(lines) + "\n")
    report = dask.bake_large(path, tmp_path / "out", "laplacian", client=client, tiles=4, iterations=3)
    assert command(planish, "check", report["manifest"])["differences"] == []
    manifest = json.loads((tmp_path / "out" / "mesh.planish.json").read_text())
    heights, difference, _ = of_vertices(tmp_path / "out", manifest)
    assert difference == 0 and heights[7] == heights[count] and manifest["displacement"]["origin"][0] > 4e5


def test_work_that_was_stopped_is_gone_on_with(client, tmp_path):
    path = tmp_path / "mesh.ply"
    write_ply(path, *torus(90, 60))

    def run(name, progress=None, **options):
        return dask.bake_large(path, tmp_path / name, "taubin", client=client, tiles=6, progress=progress, **options)

    with pytest.raises(package.Interrupted, match="out.tiles"):
        run("out", lambda stage, fraction: stage != "pages" or fraction < 0.3)
    assert not (tmp_path / "out").exists()
    made = {file: file.stat().st_mtime_ns for file in (tmp_path / "out.tiles").glob("tile-*.page")}
    assert len(made) >= 2
    with pytest.raises(package.Interrupted):
        run("out", lambda stage, fraction: stage != "bundle")
    assert all(file.stat().st_mtime_ns == at for file, at in made.items())
    # Pages of another kind are not taken for these.
    with pytest.raises(package.Interrupted):
        run("out", lambda stage, fraction: stage != "bundle", bits=8)
    assert run("out")["tiles_kept"] == 6 and not (tmp_path / "out.tiles").exists()
    run("again")
    for file in (tmp_path / "again").iterdir():
        assert file.read_bytes() == (tmp_path / "out" / file.name).read_bytes()
    # A bake replaces an earlier one, and nothing else.
    run("out", bits=8)
    assert json.loads((tmp_path / "out" / "mesh.planish.json").read_text())["displacement"]["bits"] == 8
    (tmp_path / "again" / "mesh.planish.json").unlink()
    with pytest.raises(package.InputError, match="is not a file of an earlier bake"):
        run("again")


def test_what_is_wrong_is_named(client, tmp_path):
    path = tmp_path / "mesh.obj"
    package.Mesh(*torus(8, 6)).write(path)
    for options, message in [
        ({"map": "tangent"}, '`map` is "scalar" or "vector"'),
        ({"bits": 12}, "`bits` is 8, 16 or 32, not 12"),
        ({"lambda_": 1e9}, "`lambda_` is a number up to 1000000"),
        ({"tiles": 0}, "1 to 400 tiles, not 0"),
    ]:
        with pytest.raises(package.InputError, match=message):
            dask.bake_large(path, tmp_path / "out", "laplacian", client=client, **options)
    assert [file.name for file in tmp_path.iterdir()] == ["mesh.obj"]


def test_a_manifest_whose_pages_lack_a_vertex_is_refused(planish, client, tmp_path):
    path = tmp_path / "mesh.obj"
    package.Mesh(*torus(30, 20)).write(path)
    report = dask.bake_large(path, tmp_path / "out", "laplacian", client=client, tiles=2)
    text = (tmp_path / "out" / "mesh.planish.json").read_text()
    for change, message in [
        (lambda maps: maps[0].update(texels="1"), "samples the page and has no texel there"),
        (lambda maps: maps[0].update(texels="1-9999"), "`texels` names 9999, but there are 600 vertices"),
        (lambda maps: maps[0].update(width=1, height=1), "texels are too few for"),
        (lambda maps: maps[0].update(seam_vertices=[[1, 1]]), "do not go with `cut`"),
    ]:
        manifest = json.loads(text)
        change(manifest["pages"]["maps"])
        manifest["displacement"].update({key: manifest["pages"]["maps"][0][key] for key in ("width", "height")})
        (tmp_path / "out" / "mesh.planish.json").write_text(json.dumps(manifest))
        done = subprocess.run([planish, "check", report["manifest"]], capture_output=True, text=True)
        assert done.returncode == 2 and message in done.stderr, done.stderr
