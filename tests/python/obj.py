"""The little of OBJ that the cross-checks need: positions and faces, in the file's order, nothing merged."""

from pathlib import Path

import numpy as np


def read(path):
    """Positions (n x 3) and polygons (lists of 0-based vertex indices)."""
    positions, polygons = [], []
    for line in Path(path).read_text(encoding="utf-8", errors="replace").splitlines():
        key, *words = line.split("#", 1)[0].split() or [""]
        if key == "v":
            positions.append([float(word) for word in words[:3]])
        elif key == "f":
            indices = [int(word.split("/", 1)[0]) for word in words]
            polygons.append([i - 1 if i > 0 else len(positions) + i for i in indices])
    return np.array(positions, dtype=float).reshape(-1, 3), polygons


def read_triangles(path):
    """Positions (n x 3) and faces (m x 3); a polygon is an error, since its triangulation would be a guess."""
    positions, polygons = read(path)
    if any(len(polygon) != 3 for polygon in polygons):
        raise ValueError(f"{path} has faces that are no triangles")
    return positions, np.array(polygons, dtype=np.int64).reshape(-1, 3)


def write_triangles(path, comment, positions, faces):
    """Writes a mesh whose coordinates read back bit for bit."""
    lines = [f"# {comment}"]
    lines += ["v " + " ".join(repr(float(x)) for x in position) for position in positions]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
