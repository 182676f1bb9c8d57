"""PLY, STL, OFF and glTF files that other programs wrote: after `planish denoise` other programs find what they wrote, displaced."""

import json
import subprocess

import numpy as np
import pytest
import trimesh

# Moves every vertex of a closed mesh.
METHOD = ["--method", "taubin", "--iterations", "3"]


def sphere():
    mesh = trimesh.creation.icosphere(3)
    random = np.random.default_rng(1)
    mesh.vertices += random.normal(0, 0.01, mesh.vertices.shape)
    mesh.visual.vertex_colors = random.integers(0, 255, (len(mesh.vertices), 4))
    return mesh


def scene():
    """Two meshes, one of them turned and shown twice."""
    turned = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [4, 5, 6])
    torus = trimesh.creation.torus(1, 0.3)
    torus.vertices += np.random.default_rng(2).normal(0, 0.01, torus.vertices.shape)
    both = trimesh.Scene()
    both.add_geometry(sphere(), node_name="sphere", geom_name="sphere")
    both.add_geometry(torus, node_name="torus", geom_name="torus", transform=turned)
    both.graph.update("again", geometry="torus", matrix=turned @ turned)
    return both


def of_trimesh(make, **options):
    return lambda path: make().export(path, **options)


def of_pymeshlab(**options):
    def write(path):
        pymeshlab = pytest.importorskip("pymeshlab", exc_type=ImportError)
        meshes = pymeshlab.MeshSet(verbose=False)
        mesh = sphere()
        meshes.add_mesh(pymeshlab.Mesh(mesh.vertices, mesh.faces))
        meshes.save_current_mesh(str(path), **options)

    return write


FILES = [
    pytest.param("a.ply", of_trimesh(sphere), id="ply-binary"),
    pytest.param("a.ply", of_trimesh(sphere, encoding="ascii", vertex_normal=True), id="ply-text"),
    pytest.param("a.stl", of_trimesh(sphere), id="stl-binary"),
    pytest.param("a.stl", of_trimesh(sphere, file_type="stl_ascii"), id="stl-text"),
    pytest.param("a.off", of_trimesh(sphere), id="off"),
    pytest.param("a.glb", of_trimesh(sphere), id="glb"),
    pytest.param("scene.glb", of_trimesh(scene), id="glb-scene"),
    pytest.param("m.ply", of_pymeshlab(), id="meshlab-ply-binary"),
    pytest.param("m.ply", of_pymeshlab(binary=False), id="meshlab-ply-text"),
    pytest.param("m.stl", of_pymeshlab(), id="meshlab-stl-binary"),
    pytest.param("m.stl", of_pymeshlab(binary=False), id="meshlab-stl-text"),
    pytest.param("m.off", of_pymeshlab(), id="meshlab-off"),
]


def parts(path):
    """The meshes of a file as trimesh has them, and where it shows which."""
    loaded = trimesh.load_scene(path, process=False)
    if path.suffix != ".glb":
        # The only mesh has the name of the file.
        return {"mesh": next(iter(loaded.geometry.values()))}, {}
    return loaded.geometry, {node: loaded.graph[node] for node in loaded.graph.nodes_geometry}


@pytest.mark.parametrize("name, write", FILES)
def test_only_positions_change(name, write, planish, tmp_path):
    before, after = tmp_path / name, tmp_path / f"denoised-{name}"
    write(before)
    done = subprocess.run(
        [planish, "denoise", before, "-o", after, *METHOD, "--json"], check=True, capture_output=True
    )
    report = json.loads(done.stdout)
    (old, places), (new, new_places) = parts(before), parts(after)
    assert old.keys() == new.keys() and places.keys() == new_places.keys()
    for node, (matrix, mesh) in places.items():
        assert np.array_equal(matrix, new_places[node][0]) and mesh == new_places[node][1]
    largest = 0
    for key, mesh in old.items():
        assert np.array_equal(mesh.faces, new[key].faces)
        if mesh.visual.kind == "vertex":
            assert np.array_equal(mesh.visual.vertex_colors, new[key].visual.vertex_colors)
        largest = max(largest, np.linalg.norm(mesh.vertices - new[key].vertices, axis=1).max())
    assert 0 < report["rounding"] < 1e-6 or report["rounding"] == 0
    # trimesh places the vertices in single precision for glTF.
    assert largest == pytest.approx(report["max_displacement"], abs=1e-5)
    if name.endswith(".stl"):
        mesh = next(iter(new.values()))
        stored = trimesh.load(after, process=False).face_normals
        corners = mesh.triangles
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert np.abs(stored - cross / np.linalg.norm(cross, axis=1, keepdims=True)).max() < 1e-4


@pytest.mark.parametrize("name, write", FILES)
def test_a_bake_keeps_its_word(name, write, planish, tmp_path):
    mesh = tmp_path / name
    write(mesh)
    subprocess.run([planish, "bake", mesh, "-o", tmp_path / "map", *METHOD], check=True, capture_output=True)
    manifest = next((tmp_path / "map").glob("*.planish.json"))
    subprocess.run([planish, "check", manifest], check=True, capture_output=True)


@pytest.mark.parametrize("extension", ["ply", "stl", "off", "glb", "gltf", "obj"])
def test_a_mesh_in_another_format_has_the_same_shape(extension, planish, tmp_path):
    before, after = tmp_path / "a.ply", tmp_path / f"b.{extension}"
    sphere().export(before)
    subprocess.run([planish, "denoise", before, "-o", after, *METHOD], check=True, capture_output=True)
    subprocess.run([planish, "denoise", before, "-o", tmp_path / "b.ply", *METHOD], check=True, capture_output=True)
    expected = trimesh.load(tmp_path / "b.ply", process=False)
    (found,) = trimesh.load_scene(after, process=False).geometry.values()
    assert np.abs(found.triangles - expected.triangles).max() < 1e-6
    # trimesh reads no colours of the vertices of an OFF.
    if extension not in ("stl", "off"):
        # Other formats may have the vertices in another order.
        found, expected = (mesh.visual.vertex_colors[mesh.faces][..., :3] for mesh in (found, expected))
        if extension in ("glb", "gltf"):
            # glTF has them linear; trimesh makes bytes of the numbers as they are.
            encoded = expected / 255
            linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
            assert np.abs(found - 255 * linear).max() <= 1
        else:
            assert np.array_equal(found, expected)


@pytest.mark.parametrize("name, make", [("a.glb", sphere), ("scene.glb", scene)])
def test_the_carrier_of_a_glb_keeps_its_document(name, make, planish, tmp_path):
    """Its last morph target leads to where `planish apply` puts the vertices, in the numbers of the meshes."""
    from test_gltf import accessor, read

    mesh, applied = tmp_path / name, tmp_path / f"applied-{name}"
    make().export(mesh)
    subprocess.run([planish, "bake", mesh, "-o", tmp_path / "map", *METHOD], check=True, capture_output=True)
    manifest = next((tmp_path / "map").glob("*.planish.json"))
    subprocess.run([planish, "apply", manifest, "-o", applied], check=True, capture_output=True)
    (old, _), (carrier, carried), (moved, displaced) = (read(p) for p in (mesh, tmp_path / "map" / name, applied))
    for part in ("nodes", "scenes", "scene", "asset"):
        assert carrier.get(part) == old.get(part)
    assert len(carrier["meshes"]) == len(old["meshes"])
    scale = json.loads(manifest.read_text())["displacement"]["scale"]
    for was, is_now, expected in zip(old["meshes"], carrier["meshes"], moved["meshes"]):
        assert is_now["extras"]["targetNames"] == ["denoised"] and is_now["weights"] == [1.0]
        for a, b, c in zip(was["primitives"], is_now["primitives"], expected["primitives"]):
            assert a["attributes"].items() - {("NORMAL", a["attributes"].get("NORMAL"))} <= b["attributes"].items()
            assert a["indices"] == b["indices"]
            start, change = (accessor(carrier, carried, i) for i in (b["attributes"]["POSITION"], b["targets"][-1]["POSITION"]))
            end = accessor(moved, displaced, c["attributes"]["POSITION"])
            # Half a quantum of 16 bits, and single precision.
            assert np.abs(start + change - end).max() < scale / 2**16 + 16 * 2.0**-23
            assert np.linalg.norm(change, axis=1).max() > scale / 4
