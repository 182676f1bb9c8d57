"""Meshes of Trimesh, Open3D and PyVista, told apart by their attributes; none of these packages is imported."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import InputError


@dataclass
class Foreign:
    """Arrays of a mesh of another package."""

    mesh: Any
    kind: str
    vertices: Any
    faces: Any
    uvs: Any = None
    uv_faces: Any = None

    @classmethod
    def of(cls, mesh: Any) -> Foreign:
        """Reads positions, faces and texture coordinates."""
        if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
            uvs = getattr(getattr(mesh, "visual", None), "uv", None)
            if uvs is not None and len(uvs) != len(mesh.vertices):
                uvs = None
            return cls(mesh, "trimesh", np.asarray(mesh.vertices), np.asarray(mesh.faces), uvs)
        if hasattr(mesh, "vertices") and hasattr(mesh, "triangles"):
            uvs = np.asarray(mesh.triangle_uvs) if mesh.has_triangle_uvs() else None
            uv_faces = None if uvs is None else np.arange(len(uvs)).reshape(-1, 3)
            return cls(mesh, "open3d", np.asarray(mesh.vertices), np.asarray(mesh.triangles), uvs, uv_faces)
        if hasattr(mesh, "points") and hasattr(mesh, "n_faces_strict"):
            uvs = getattr(mesh, "active_texture_coordinates", None)
            return cls(mesh, "pyvista", np.asarray(mesh.points), _padded(mesh.faces), uvs)
        raise InputError(
            f"a {type(mesh).__name__} is no mesh: give vertices and faces, a planish.Mesh, or a mesh of Trimesh, Open3D"
            " (legacy TriangleMesh) or PyVista (PolyData)"
        )

    def at(self, vertices: NDArray[np.float64]) -> Any:
        """A copy of the mesh with other positions and all else that it has."""
        if self.kind == "trimesh":
            moved = self.mesh.copy()
            moved.vertices = vertices
        elif self.kind == "open3d":
            moved = copy.deepcopy(self.mesh)
            moved.vertices = type(self.mesh.vertices)(vertices)
            if self.mesh.has_triangle_normals():
                moved.compute_triangle_normals()
            if self.mesh.has_vertex_normals():
                moved.compute_vertex_normals()
        else:
            moved = self.mesh.copy()
            moved.points = vertices.astype(self.vertices.dtype)
        return moved


def _padded(faces: NDArray[Any]) -> Any:
    """Faces from one array in which the number of corners precedes each face."""
    faces = np.asarray(faces)
    if faces.size and faces.size % (faces[0] + 1) == 0:
        rows = faces.reshape(-1, faces[0] + 1)
        if (rows[:, 0] == faces[0]).all():
            return rows[:, 1:]
    lists, start = [], 0
    while start < faces.size:
        end = start + 1 + faces[start]
        lists.append(faces[start + 1 : end])
        start = end
    return lists
