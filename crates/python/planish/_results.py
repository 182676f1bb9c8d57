"""Results of the functions of this package."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cached_property
from os import PathLike, fspath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _planish
from ._arrays import faces_of
from ._plot import plot_heights

PathLikeStr = str | PathLike[str]


class Moved:
    """A mesh whose vertices have other positions than in its file or its arrays."""

    def __init__(self, source: Any, vertices: NDArray[np.float64], mesh: Any) -> None:
        self._source = source
        self.vertices: NDArray[np.float64] = vertices
        """Positions of the vertices, in the order in which they were given (#v×3, model units)."""
        self._mesh = mesh

    @property
    def _native(self) -> _planish.Mesh:
        return self._source()  # type: ignore[no-any-return]

    @cached_property
    def mesh(self) -> Any:
        """The mesh with these positions, of the kind that was given: a copy of the Trimesh, Open3D or PyVista mesh with all else
        that it has, or None if arrays or a :class:`planish.Mesh` were given."""
        return self._mesh(self.vertices) if self._mesh else None

    def write(self, path: PathLikeStr, *, update_normals: bool = False) -> dict[str, Any]:
        """Writes the mesh to a file, whole or not at all.

        In the format of the file that it came from, all bytes but the numbers of moved vertices stay. Another format is chosen
        by the extension: .obj, .ply, .stl, .off, .glb or .gltf, with .gz behind it if you like.

        With ``update_normals`` the normals of the file follow the new shape; hard edges stay hard.

        Returns ``output`` (path), ``rounding`` (largest distance between a position here and in the file, model units), ``lost``
        (what the format has no place for) and ``notes``.

        Raises :class:`InputError` if ``path`` is the file that the mesh was read from, or cannot be written.
        """
        written = self._native.write(fspath(path), self.vertices, update_normals)
        return json.loads(written)  # type: ignore[no-any-return]


class Denoised(Moved):
    """A denoised mesh: its vertices, how far each one moved, and the report."""

    def __init__(
        self,
        source: Any,
        vertices: NDArray[np.float64],
        deltas: NDArray[np.float64],
        report: str,
        mesh: Any = None,
    ) -> None:
        super().__init__(source, vertices, mesh)
        self.deltas: NDArray[np.float64] = deltas
        """Displacements δ from the denoised positions to the given ones: ``given = vertices + deltas`` up to rounding
        (#v×3, model units)."""
        self.report: dict[str, Any] = json.loads(report)
        """Figures as ``planish denoise --json`` prints them: ``method`` with every setting, ``mean_edge``,
        ``mean_displacement``, ``max_displacement`` (model units), ``limits``, and ``notes`` on what is odd."""

    @property
    def choice(self) -> dict[str, Any] | None:
        """Noise that the method ``auto`` measured (``sigma``, in mean edge lengths around each vertex) and the shares of the
        candidates that it mixed; None for other methods."""
        return self.report.get("choice")

    def plot(self, ax: Any = None) -> Any:
        """Draws the denoised surface, coloured by how far the noise had lifted it along its normals: red outside, blue inside
        (model units). Needs matplotlib (``pip install planish[plot]``). Returns the axes."""
        native = self._native
        indices, counts = native.faces
        starts = np.cumsum(counts) - counts
        fans = [(s, s + k, s + k + 1) for s, n in zip(starts, counts) for k in range(1, n - 1)]
        return plot_heights(self.vertices, indices[np.array(fans)], self.deltas, ax)

    def __repr__(self) -> str:
        return f"<planish.Denoised: {len(self.vertices)} vertices, {self.report['method']['name']}>"


class Noisy(Moved):
    """A mesh with synthetic noise."""

    def __init__(
        self,
        native: _planish.Mesh,
        vertices: NDArray[np.float64],
        clean: Moved | None,
        report: str,
        mesh: Any = None,
    ) -> None:
        super().__init__(lambda: native, vertices, mesh)
        self.faces = faces_of(*native.faces)
        """Faces of the noisy mesh, in the form of :attr:`Mesh.faces`."""
        self.clean: Moved | None = clean
        """Clean counterpart with the same faces, for kinds of noise that make a mesh of their own; else None."""
        self.report: dict[str, Any] = json.loads(report)
        """``kind``, ``seed`` and ``settings`` of the noise."""


class Displaced(Moved):
    """A mesh that was displaced by its map."""

    def __init__(self, native: _planish.Mesh, vertices: NDArray[np.float64], strength: float) -> None:
        super().__init__(lambda: native, vertices, None)
        self.lambda_: float = strength
        """Strength λ: 0 is the noisy mesh, 1 the denoised one."""


class Bundle:
    """A displacement map with its carrier, in memory."""

    def __init__(self, native: _planish.Bundle) -> None:
        self._native = native
        self.manifest: dict[str, Any] = json.loads(native.manifest)
        """Content of NAME.planish.json."""

    @property
    def report(self) -> dict[str, Any]:
        """Errors of the map, measured on the written files (model units)."""
        return self.manifest["report"]  # type: ignore[no-any-return]

    @property
    def choice(self) -> dict[str, Any] | None:
        """Choice of the method ``auto``; None for other methods."""
        return self.manifest.get("choice")

    @property
    def notes(self) -> list[str]:
        """Warnings about a bake that succeeded, one sentence each."""
        return self._native.notes

    @property
    def bias(self) -> float:
        """Height at texel 0, model units."""
        return float(self.manifest["displacement"]["bias"])

    @property
    def scale(self) -> float:
        """Height at texel 1 minus that at texel 0, model units."""
        return float(self.manifest["displacement"]["scale"])

    @cached_property
    def heights(self) -> NDArray[np.float64]:
        """Heights bias + scale · texel as the file has them (H×W, model units, row 0 on top); vectors are H×W×3.

        With pages these are the heights of the first one; :attr:`pages` has all of them.
        """
        return self._native.heights()

    @cached_property
    def pages(self) -> Mapping[str, NDArray[np.float64]]:
        """Heights of each page, in the form of :attr:`heights`, by its tile or material; empty if the map has one image."""
        return {name: self._native.heights(page) for page, name in enumerate(self._page_names())}

    @cached_property
    def page_normal_maps(self) -> Mapping[str, NDArray[np.uint8] | None]:
        """Normal map of each page, in the form of :attr:`normal_map`, by its tile or material; empty if the map has one image."""
        return {name: self._native.normal_map(page) for page, name in enumerate(self._page_names())}

    def _page_names(self) -> list[str]:
        maps = self.manifest.get("pages", {}).get("maps", [])
        return [str(page["tile"]) if "tile" in page else page["material"] for page in maps]

    @cached_property
    def normal_map(self) -> NDArray[np.uint8] | None:
        """Normal map in tangent space (H×W×3, 0 to 255, row 0 on top); None if the mesh has no texture coordinates for one."""
        return self._native.normal_map()

    @cached_property
    def files(self) -> Mapping[str, bytes]:
        """Content of each file by its name; the manifest is the last."""
        return {name: self._native.file(name) for name in self._native.names}

    def write(self, folder: PathLikeStr | None = None) -> list[str]:
        """Writes all files or none, and returns their paths.

        For a mesh from a file, names in the files are relative to the folder that was given to ``bake``, and ``folder`` can be
        left out. A folder of an earlier bake of this name is updated; other files in it are never overwritten.

        Raises :class:`InputError` if the folder is another one, or cannot be written to.
        """
        return [str(path) for path in self._native.write(None if folder is None else fspath(folder))]

    def __repr__(self) -> str:
        entry = self.manifest["displacement"]
        return f"<planish.Bundle: {entry['width']} × {entry['height']}, {', '.join(self._native.names)}>"
