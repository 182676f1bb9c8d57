"""The .glb: valid, and what a reader of its own finds in it is what the manifest and `planish apply` say."""

import json
import struct

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from baked import DUCK, SPOT
from clients import SCRIPTS, execute, package, program

FLOAT = 2.0**-23
COMPONENTS = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
CASES = [
    pytest.param(DUCK, "uvs", ("--bits", "16"), id="duck-uv-16"),
    pytest.param(SPOT, "uvs", ("--bits", "32"), id="spot-uv-32"),
    pytest.param(DUCK, "uvs", ("--layout", "vertex", "--bits", "8"), id="duck-vertex-8"),
    pytest.param(DUCK, "uvs", ("--layout", "vertex", "--bits", "32"), id="duck-vertex-32"),
    pytest.param(DUCK, "bare", ("--layout", "vertex", "--bits", "32"), id="bare-vertex-32"),
    pytest.param(DUCK, "folded", ("--layout", "auto", "--bits", "16"), id="folded-private-16"),
]


def read(path):
    """The JSON chunk and the binary chunk."""
    data = path.read_bytes()
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    (size,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def view(document, binary, index):
    entry = document["bufferViews"][index]
    start = entry.get("byteOffset", 0)
    return binary[start : start + entry["byteLength"]]


def accessor(document, binary, index):
    """The numbers of a tightly packed accessor, n x components."""
    entry = document["accessors"][index]
    assert not {"sparse", "normalized"} & entry.keys()
    assert "byteStride" not in document["bufferViews"][entry["bufferView"]]
    width, kind = WIDTHS[entry["type"]], COMPONENTS[entry["componentType"]]
    data = view(document, binary, entry["bufferView"])[entry.get("byteOffset", 0) :]
    return np.frombuffer(data, dtype=kind, count=width * entry["count"]).reshape(-1, width)


@pytest.mark.parametrize("mesh, uvs, options", CASES)
def test_validator(mesh, uvs, options, baked):
    """Khronos' own. Of the map in the extras it says that nothing in glTF uses it, as information."""
    node = program("node")
    package("gltf-validator")
    case = baked(mesh, uvs, *options)
    issues = json.loads(execute([node, SCRIPTS / "validate.mjs", case.glb]))["issues"]
    told = [message for message in issues["messages"] if message["severity"] < 2]
    assert told == []
    assert {message["code"] for message in issues["messages"]} <= {"UNUSED_OBJECT"}


@pytest.mark.parametrize("mesh, uvs, options", CASES)
def test_contents(mesh, uvs, options, baked):
    case = baked(mesh, uvs, *options)
    document, binary = read(case.glb)
    (mesh,) = document["meshes"]
    assert mesh["extras"]["targetNames"] == ["denoised"]
    assert mesh["weights"] == [case.map["lambda"]]
    triangles = []
    for primitive in mesh["primitives"]:
        attributes = {name: accessor(document, binary, i) for name, i in primitive["attributes"].items()}
        vertex = case.vertices_at(attributes["POSITION"])
        assert np.array_equal(attributes["NORMAL"], case.normals[vertex].astype("f4"))
        # v points down; turning it may round once more.
        expected = case.sampled_at[vertex].astype(float) * [1, -1] + [0, 1]
        if case.map["layout"] == "uv":
            assert np.abs(attributes["TEXCOORD_1"] - expected).max() <= FLOAT
        else:
            size = np.array([case.map["width"], case.map["height"]])
            column, row = np.floor(attributes["TEXCOORD_1"] * size).astype(int).T
            assert np.array_equal((attributes["TEXCOORD_1"] * size) % 1, np.full((len(vertex), 2), 0.5))
            assert np.array_equal(case.positions[row * size[0] + column], case.positions[vertex])
        (target,) = primitive["targets"]
        moved = attributes["POSITION"].astype(float) + accessor(document, binary, target["POSITION"])
        # The target holds the denoised surface itself, from which the map is off by what the report says.
        bound = case.map["lambda"] * case.manifest["report"]["error_bound"] + case.ulp
        assert case.errors(moved, case.places[vertex]).max() <= bound / case.range
        corners = accessor(document, binary, primitive["indices"]).ravel()
        triangles.append(np.hstack([attributes["POSITION"], attributes["TEXCOORD_0"]])[corners].astype(float))

        entry = document["materials"][primitive["material"]]["extras"]["planish"]["displacement"]
        named = ("bias", "scale", "lambda", "layout", "bits")
        assert {key: entry[key] for key in named} == {key: case.map[key] for key in named}
        assert entry["texCoord"] == 1
        if "texture" in entry:
            image = document["images"][document["textures"][entry["texture"]]["source"]]
            file = view(document, binary, image["bufferView"])
        else:
            file = view(document, binary, entry["bufferView"])
        assert file == (case.folder / case.map["file"]).read_bytes()

    # Every corner of every triangle of the carrier, with the user's texture coordinates.
    vertex, uv = case.corners.T
    expected = np.hstack([case.positions[vertex], case.uvs[uv] * [1, -1] + [0, 1]])
    actual = np.concatenate(triangles)
    assert actual.shape == expected.shape
    for these, those in ((actual, expected), (expected, actual)):
        apart, _ = cKDTree(these).query(those, p=np.inf)
        assert apart.max() <= max(case.ulp, FLOAT)


@pytest.mark.parametrize("mesh, uvs, options", CASES[:3])
def test_trimesh(mesh, uvs, options, baked):
    case = baked(mesh, uvs, *options)
    scene = trimesh.load_scene(case.glb, process=False)
    faces = sum(len(part.faces) for part in scene.geometry.values())
    assert faces == len(case.corners) // 3
    for part in scene.geometry.values():
        assert part.visual.uv.shape == (len(part.vertices), 2)
        case.vertices_at(part.vertices)
