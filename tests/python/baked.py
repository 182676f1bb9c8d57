"""Baked meshes for the client tests: what was written, and where `planish apply` puts the vertices."""

import functools
import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

import obj
from conftest import REPO, external

DUCK = REPO / "data" / "duck_noisy.obj"
SPOT = external("spot_n0.2_noisy.obj")


@dataclass
class Bake:
    """The files that `planish bake` wrote, and what they say."""

    folder: Path
    name: str
    manifest: dict
    # Of the source, #V x 3.
    positions: np.ndarray
    # Displaced with the manifest's lambda, #V x 3.
    places: np.ndarray
    # Of the carrier's triangles, polygons as fans: index of `v` and of `vt`, in the order of the file. #C x 2.
    corners: np.ndarray
    # Of the carrier, #VT x 2.
    uvs: np.ndarray
    # Of the carrier, #V x 3.
    normals: np.ndarray

    @property
    def map(self):
        return self.manifest["displacement"]

    @property
    def carrier(self):
        return self.folder / self.manifest["carrier"]["obj"]

    @property
    def range(self):
        """R: what the map can hold, model units."""
        return self.map["scale"]

    @property
    def ulp(self):
        """What a client in single precision may lose by rounding once: a unit in the last place."""
        return float(np.spacing(np.float32(np.abs(self.positions).max())))

    @property
    def filtered(self):
        """What linear filtering may add, share of the range: texture coordinates times the size are rounded to single
        precision, and neighbouring texels may be a range apart."""
        images = self.manifest.get("pages", {"maps": [self.map]})["maps"]
        side = max(max(image["width"], image["height"]) for image in images)
        return 0 if self.map["layout"] == "vertex" else 2 * side * 2**-24

    def errors(self, actual, expected):
        """Distance along the worst axis, share of the range."""
        return np.abs(actual - expected).max(axis=1) / self.range

    @functools.cached_property
    def texels(self):
        """Index of the `vt` that each vertex samples at, #V; -1 without one."""
        result = np.full(len(self.positions), -1)
        result[self.corners[::-1, 0]] = self.corners[::-1, 1]
        for vertex, uv in self.manifest.get("dominant_uv", {"seam_vertices": []})["seam_vertices"]:
            result[vertex - 1] = uv - 1
        return result

    @functools.cached_property
    def seam(self):
        """Whether each vertex has several texture coordinates, #V."""
        pairs = np.unique(self.corners, axis=0)
        return np.bincount(pairs[:, 0], minlength=len(self.positions)) > 1

    @functools.cached_property
    def sampled_at(self):
        """The texture coordinate, v up, that each vertex samples at (#V x 2), in single precision."""
        if self.map["layout"] == "uv":
            places = self.uvs[self.texels].astype("f4") - np.float32(self.map.get("tile", [0, 0]))
            vertices, column, row = np.array(self.manifest.get("private_texels", []), dtype=int).reshape(-1, 3).T
            places[vertices - 1] = self.centres(column, row)
            return places
        row, column = np.divmod(np.arange(len(self.positions)), self.map["width"])
        return self.centres(column, row)

    def centres(self, column, row):
        """Texture coordinates of the centres of texels, v up (n x 2), in single precision."""
        size = self.map["width"], self.map["height"]
        return np.stack([(column + 0.5) / size[0], 1 - (row + 0.5) / size[1]], axis=1).astype("f4")

    @property
    def private(self):
        """Whether each vertex has a private texel, #V."""
        result = np.zeros(len(self.positions), dtype=bool)
        result[[vertex - 1 for vertex, _, _ in self.manifest.get("private_texels", [])]] = True
        return result

    @functools.cached_property
    def image(self):
        """The texels as a shader gets them, row 0 on top, in single precision."""
        return read_image(self.folder / self.map["file"])

    @functools.cached_property
    def bilinear(self):
        """Heights at the vertices from their definition, #V; only the place where to sample is rounded to single
        precision."""
        size = np.array([self.map["width"], self.map["height"]])
        uv = self.sampled_at * np.float32([1, -1]) + np.float32([0, 1])
        place = uv * size.astype("f4") - np.float32(0.5)
        low = np.floor(place)
        weight = (place - low).astype(float)
        (x0, y0), (x1, y1) = (np.clip(low + step, 0, size - 1).astype(int).T for step in (0, 1))
        texels = self.image.astype(float)
        top, bottom = ((1 - weight[:, 0]) * texels[y, x0] + weight[:, 0] * texels[y, x1] for y in (y0, y1))
        return self.map["bias"] + self.map["scale"] * ((1 - weight[:, 1]) * top + weight[:, 1] * bottom)

    def vertices_at(self, places):
        """Index of a source vertex at each of these places (n x 3, rounded to single precision); all that lie at the
        same one are displaced alike."""
        rounded = self.positions.astype("f4")
        index = {p.tobytes(): i for i, p in enumerate(rounded)}
        return np.array([index[p.tobytes()] for p in np.ascontiguousarray(places, dtype="f4")])

    @property
    def glb(self):
        return self.folder / self.manifest["carrier"]["glb"]


def read_image(path):
    """Texels of an image, whole numbers as shares of the largest, in single precision: rows x columns, x 3 if in colour."""
    if path.suffix == ".exr":
        channels = OpenEXR.File(str(path)).channels()
        texels = (channels.get("Y") or channels["RGB"]).pixels
    else:
        with Image.open(path) as image:
            texels = np.asarray(image)
    if texels.dtype.kind == "f":
        return texels.astype("f4")
    return texels.astype("f4") / np.float32(np.iinfo(texels.dtype).max)


def fans(polygons):
    """Corners of the triangles that each polygon is cut into, from its first corner."""
    return [f[k] for f in polygons for i in range(1, len(f) - 1) for k in (0, i, i + 1)]


def read_corners(path):
    """Index of `v` and of `vt` of the triangles' corners (#C x 2), and the texture coordinates (#VT x 2)."""
    uvs, polygons = [], []
    for line in path.read_text(encoding="utf-8").splitlines():
        key, *words = line.split() or [""]
        if key == "vt":
            uvs.append([float(word) for word in words[:2]])
        elif key == "f":
            polygons.append([[int(part or 0) - 1 for part in (word + "/0").split("/")[:2]] for word in words])
    return np.array(fans(polygons)), np.array(uvs).reshape(-1, 2)


def read_normals(path):
    """The `vn` lines, n x 3."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return np.array([line.split()[1:4] for line in lines if line.startswith("vn ")], dtype=float)


def without_uvs(path, folder):
    """A copy of a mesh that has lost its texture coordinates, and with them the use of its materials."""
    copy = folder / f"bare_{path.name}"
    with open(copy, "w", encoding="utf-8") as out:
        for line in path.read_text(encoding="utf-8").splitlines():
            key, *words = line.split() or [""]
            if key == "f":
                line = " ".join(["f", *(word.split("/")[0] for word in words)])
            if key not in ("vt", "vn", "mtllib", "usemtl"):
                print(line, file=out)
    return copy


def folded(path, folder):
    """A copy of a mesh whose texture coordinates are folded along the middle, so that charts lie upon others."""
    return with_u(path, folder / f"folded_{path.name}", lambda u: abs(u - 0.5))


def tiles(path, folder):
    """A copy of a mesh whose texture coordinates are stretched over two UDIM tiles; faces lie across their border."""
    return with_u(path, folder / f"tiles_{path.name}", lambda u: 2 * u)


def beside(path, folder):
    """A copy of a mesh whose texture coordinates lie one tile farther."""
    return with_u(path, folder / f"beside_{path.name}", lambda u: u + 1)


def with_u(path, copy, change):
    """Writes a copy of a mesh with other first texture coordinates."""
    with open(copy, "w", encoding="utf-8") as out:
        for line in path.read_text(encoding="utf-8").splitlines():
            key, *words = line.split() or [""]
            if key == "vt":
                line = f"vt {change(float(words[0]))} {words[1]}"
            print(line, file=out)
    return copy


def bake(planish, mesh, folder, *options):
    """Bakes a mesh into a folder and applies the map. Its own texture coordinates are used, whatever they can hold, unless
    another layout is asked for."""
    if "--layout" not in options:
        options = (*options, "--layout", "uv")
    done = subprocess.run([planish, "bake", mesh, "-o", folder, *options], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.planish.json")
    manifest = json.loads(path.read_text(encoding="utf-8"))
    subprocess.run([planish, "apply", path, "-o", folder / "applied.obj"], check=True, capture_output=True)
    carrier = folder / manifest["carrier"]["obj"]
    corners, uvs = read_corners(carrier)
    return Bake(
        folder=folder,
        name=path.name.removesuffix(".planish.json"),
        manifest=manifest,
        positions=obj.read(mesh)[0],
        places=obj.read(folder / "applied.obj")[0],
        corners=corners,
        uvs=uvs,
        normals=read_normals(carrier),
    )
