"""Meshes from files or arrays, and the functions of the package."""

from __future__ import annotations

import json
from os import PathLike, fspath
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _planish
from ._arrays import faces_of, floats, polygons
from ._errors import InputError
from ._foreign import Foreign
from ._options import Progress, command_line, method_options, weights
from ._results import Bundle, Denoised, Displaced, Moved, Noisy

PathLikeStr = str | PathLike[str]


class Mesh:
    """A mesh that was read from a file, or made of arrays.

    ``vertices`` (#v×3, model units), ``faces`` (#f×k indices, counter-clockwise seen from outside, or a list of lists), and if you
    like ``uvs`` (#vt×2, v up) with ``uv_faces``, the index of a texture coordinate for each corner of the faces; without it each
    vertex has its own. ``weld`` says which vertices are one: "exact" (equal coordinates), "none", or a distance in model units.

    >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> mesh.faces
    array([[0, 1, 2]])
    >>> mesh.info()["area"]
    0.5

    Raises :class:`InputError` if an array has another shape, is empty, has a value that is not finite, or an index that names
    nothing; the error names the array and the index.
    """

    def __init__(
        self,
        vertices: ArrayLike,
        faces: Any,
        *,
        uvs: ArrayLike | None = None,
        uv_faces: Any = None,
        weld: str | float = "exact",
    ) -> None:
        indices, corners = polygons(faces, "faces")
        uv_indices = None
        if uv_faces is not None:
            if uvs is None:
                raise InputError("`uv_faces` needs `uvs`")
            uv_indices, uv_corners = polygons(uv_faces, "uv_faces")
            if np.shape(uv_corners) != np.shape(corners) or np.any(np.asarray(uv_corners) != np.asarray(corners)):
                raise InputError("`uv_faces` needs as many corners in each face as `faces`")
        pairs = None if uvs is None else floats(uvs, "uvs", 2)
        points = floats(vertices, "vertices", 3)
        self.native = _planish.Mesh.from_arrays(points, indices, corners, weld, pairs, uv_indices)

    @classmethod
    def _of(cls, native: _planish.Mesh) -> Mesh:
        mesh = cls.__new__(cls)
        mesh.native = native
        return mesh

    @property
    def path(self) -> str | None:
        """Path of the file; None for a mesh that was made of arrays."""
        path = self.native.path
        return None if path is None else str(path)

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Positions of the vertices, in the order of the file (#v×3, model units)."""
        return self.native.vertices

    @property
    def faces(self) -> NDArray[np.int64] | list[NDArray[np.int64]]:
        """Vertices of each face: an array (#f×k) if all faces have k corners, else one array for each face."""
        return faces_of(*self.native.faces)

    @property
    def uvs(self) -> NDArray[np.float64]:
        """Texture coordinates (#vt×2, v up); empty without any."""
        return self.native.uvs

    @property
    def uv_faces(self) -> NDArray[np.int64] | list[NDArray[np.int64]]:
        """Texture coordinate of each corner, in the form of :attr:`faces`; -1 where a corner has none."""
        return faces_of(self.native.uv_indices, self.native.faces[1])

    def denoise(
        self,
        method: str = "auto",
        *,
        preset: str = "default",
        fix: str | ArrayLike | None = None,
        max_displacement: float | None = None,
        preserve_volume: bool = False,
        mask: ArrayLike | None = None,
        direction: str | ArrayLike | None = None,
        progress: Progress | None = None,
        **parameters: Any,
    ) -> Denoised:
        """Denoises the mesh; see :func:`planish.denoise`."""
        options = method_options(method, preset, fix, max_displacement, preserve_volume, direction, parameters)
        return Denoised(lambda: self.native, *self.native.denoise(options, weights(mask), progress))

    def bake(
        self,
        method: str = "auto",
        *,
        folder: PathLikeStr | None = None,
        target: ArrayLike | None = None,
        name: str = "mesh",
        preset: str = "default",
        fix: str | ArrayLike | None = None,
        max_displacement: float | None = None,
        preserve_volume: bool = False,
        mask: ArrayLike | None = None,
        direction: str | ArrayLike | None = None,
        lambda_: float = 1.0,
        normals: str | None = None,
        map: str | None = None,
        space: str | None = None,
        layout: str | None = None,
        pages: str | None = None,
        tolerance: float | None = None,
        size: int | None = None,
        max_size: int | None = None,
        interpolation: str | None = None,
        texels: str | None = None,
        bits: int | None = None,
        format: str | None = None,
        normal_convention: str | None = None,
        no_glb: bool = False,
        progress: Progress | None = None,
        **parameters: Any,
    ) -> Bundle:
        """Bakes a displacement map; see :func:`planish.bake`."""
        method_json = method_options(method, preset, fix, max_displacement, preserve_volume, direction, parameters)
        options = command_line(
            {
                "lambda": float(lambda_),
                "normals": normals,
                "map": map,
                "space": space,
                "layout": layout,
                "pages": pages,
                "tolerance": tolerance,
                "size": size,
                "max_size": max_size,
                "interpolation": interpolation,
                "texels": texels,
                "bits": bits,
                "format": format,
                "normal_convention": normal_convention,
                "no_glb": no_glb,
            }
        )
        goal = None if target is None else floats(target, "target", 3)
        place = None if folder is None else fspath(folder)
        return Bundle(self.native.bake(options, method_json, name, place, goal, weights(mask), progress))

    def noise(self, sigma: float | None = None, kind: str | None = None, *, seed: int = 1, **settings: Any) -> Noisy:
        """Adds synthetic noise; see :func:`planish.noise`."""
        options = command_line({"sigma": sigma, "kind": kind or "white", "seed": seed, **settings})
        made, report = self.native.noise(options)
        if isinstance(made, np.ndarray):
            return Noisy(self.native, made, None, report)
        noisy, clean = made
        return Noisy(noisy, noisy.vertices, Moved(lambda: clean, clean.vertices, None), report)

    def info(self) -> dict[str, Any]:
        """Content and defects of the mesh, as ``planish info --json`` prints them."""
        return json.loads(self.native.info())  # type: ignore[no-any-return]

    def write(self, path: PathLikeStr) -> dict[str, Any]:
        """Writes the mesh to a file, in the format of its extension; see :meth:`planish.Denoised.write`."""
        return json.loads(self.native.write(fspath(path)))  # type: ignore[no-any-return]

    def __repr__(self) -> str:
        return f"<planish.Mesh: {len(self.vertices)} vertices, {self.path or 'arrays'}>"


def as_mesh(
    mesh: Any, faces: Any = None, uvs: ArrayLike | None = None, uv_faces: Any = None, weld: str | float = "exact"
) -> Mesh:
    """A mesh of what a caller gives: a Mesh, vertices with faces, or a mesh of another package."""
    if isinstance(mesh, Mesh):
        if faces is not None or uvs is not None:
            raise InputError("a planish.Mesh has its own faces and texture coordinates")
        return mesh
    if faces is None:
        foreign = Foreign.of(mesh)
        mesh, faces = foreign.vertices, foreign.faces
        if uvs is None:
            uvs, uv_faces = foreign.uvs, foreign.uv_faces
    return Mesh(mesh, faces, uvs=uvs, uv_faces=uv_faces, weld=weld)


def read(
    path: PathLikeStr, *, weld: str | float = "exact", trust: bool = False, progress: Progress | None = None
) -> Mesh:
    """Reads a mesh from an OBJ, PLY, STL, OFF or glTF file, compressed by gzip or xz or not.

    ``weld`` says which vertices are one: "exact" (equal coordinates), "none", or a distance in model units. With ``trust``, files
    that the mesh names are read wherever they are, not only in its own folder and below.

    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp(), "tent.obj")
    >>> _ = path.write_text("v 0 0 0 # a corner\\nv 2 0 0\\nv 2 2 0\\nv 0 2 0\\nv 1 1 1\\nf 1 2 5\\nf 2 3 5\\nf 3 4 5\\nf 4 1 5\\n")
    >>> tent = read(path)
    >>> result = tent.denoise("laplacian", iterations=1, step=1.0)
    >>> result.vertices[4]
    array([1., 1., 0.])
    >>> _ = result.write(path.with_name("flat.obj"))
    >>> print(path.with_name("flat.obj").read_text()[:18])
    v 0 0 0 # a corner

    Raises :class:`InputError` if the file is no mesh; the error names the file and the line.
    """
    return Mesh._of(_planish.Mesh.read(fspath(path), weld, trust, progress))


def denoise(
    mesh: Any,
    faces: Any = None,
    method: str = "auto",
    *,
    preset: str = "default",
    fix: str | ArrayLike | None = None,
    max_displacement: float | None = None,
    preserve_volume: bool = False,
    mask: ArrayLike | None = None,
    direction: str | ArrayLike | None = None,
    weld: str | float = "exact",
    progress: Progress | None = None,
    **parameters: Any,
) -> Denoised:
    """Removes noise from a mesh.

    ``mesh`` are the positions of vertices (#v×3, model units) with ``faces`` (#f×k indices, counter-clockwise seen from outside, or a
    list of lists), or alone a :class:`planish.Mesh` or a mesh of Trimesh, Open3D or PyVista. Positions in a contiguous array of
    float64 are not copied; do not change them meanwhile.

    ``method`` is a name of :func:`planish.methods`; "auto" measures the noise and needs no parameters. ``parameters`` are those of
    the method, with underscores for hyphens, and ``preset="paper"`` starts from the settings of its authors.

    ``fix`` are vertices that stay, bit for bit: "boundary", indices (n,) or a mask (#v,). ``max_displacement`` is the largest
    displacement of a vertex, in mean edge lengths. ``preserve_volume`` restores the enclosed volume. ``mask`` has a weight for each
    vertex (#v,), 0 to 1 in steps of 1/255, by which its displacement is multiplied. ``direction`` is the direction along which vertices
    move: three numbers, or ``"ray:x,y,z"`` for the rays from a point. ``weld`` says which vertices are one: "exact" (equal coordinates),
    "none", or a distance in model units.

    ``progress`` is called with the name of a stage and the fraction of it that is done, 0 to 1; if it returns False the work stops.
    Ctrl-C stops it as well. Other threads of Python run meanwhile.

    Returns a :class:`Denoised`. The same input gives the same bits, and the command line gives them too.

    >>> import numpy as np
    >>> x, y = np.meshgrid(np.arange(20.0), np.arange(20.0))
    >>> rough = np.random.default_rng(1).normal(0, 0.1, x.shape)
    >>> vertices = np.column_stack([x.ravel(), y.ravel(), rough.ravel()])
    >>> corner = (np.arange(19)[:, None] * 20 + np.arange(19)).ravel()
    >>> faces = np.concatenate([corner[:, None] + [0, 1, 21], corner[:, None] + [0, 21, 20]])
    >>> result = denoise(vertices, faces)
    >>> bool(result.vertices[:, 2].std() < 0.5 * rough.std())
    True
    >>> result.choice["kind"]
    'independent'

    Raises :class:`InputError` if the arrays are no mesh, or a setting is out of its range, and :class:`Interrupted` if ``progress``
    returned False.
    """
    if isinstance(mesh, Mesh):
        if faces is not None or weld != "exact":
            raise InputError("a planish.Mesh has its own faces and is welded; give vertices and faces, or the mesh alone")
        return mesh.denoise(
            method,
            preset=preset,
            fix=fix,
            max_displacement=max_displacement,
            preserve_volume=preserve_volume,
            mask=mask,
            direction=direction,
            progress=progress,
            **parameters,
        )
    foreign = Foreign.of(mesh) if faces is None else None
    if foreign:
        mesh, faces = foreign.vertices, foreign.faces
    points = floats(mesh, "vertices", 3)
    indices, corners = polygons(faces, "faces")
    options = method_options(method, preset, fix, max_displacement, preserve_volume, direction, parameters)
    vertices, deltas, report = _planish.denoise(points, indices, corners, options, weld, weights(mask), progress)

    def source() -> _planish.Mesh:
        return _planish.Mesh.from_arrays(points, indices, corners, weld)

    return Denoised(source, vertices, deltas, report, foreign.at if foreign else None)


def bake(
    mesh: Any,
    faces: Any = None,
    *,
    uvs: ArrayLike | None = None,
    uv_faces: Any = None,
    weld: str | float = "exact",
    method: str = "auto",
    lambda_: float = 1.0,
    **options: Any,
) -> Bundle:
    """Bakes the noise of a mesh into a displacement map, which takes it off again at any strength λ.

    ``mesh`` and ``faces`` are as for :func:`planish.denoise`. ``uvs`` are texture coordinates (#vt×2, v up) and ``uv_faces`` the index
    of one for each corner (in the form of ``faces``); without ``uv_faces`` each vertex has its own, and without ``uvs`` each vertex gets
    a texel of its own.

    ``options`` are the parameters of the method, those of :func:`planish.denoise` (``preset``, ``fix``, ``max_displacement``,
    ``preserve_volume``, ``mask``, ``direction``, ``progress``), and those of ``planish bake`` with underscores: ``size``, ``max_size``, ``layout``, ``pages``, ``normals``,
    ``map``, ``space``, ``tolerance``, ``interpolation``, ``texels``, ``bits``, ``format``, ``normal_convention``, ``no_glb``.
    ``target`` (#v×3, model units) is the result of any other denoiser, to which the map leads instead. ``name`` is how the names
    of the files begin; a mesh from a file has its own, and needs ``folder`` if the files shall not lie in ./NAME-planish.

    Returns a :class:`Bundle`.

    >>> from planish import Mesh
    >>> tent = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 1]]
    >>> faces = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    >>> bundle = bake(tent, faces, method="laplacian", iterations=1, step=1.0)
    >>> bundle.heights.shape
    (4, 4)
    >>> round(float(bundle.heights.max()), 6)
    1.0
    >>> list(bundle.files)[-1]
    'mesh.planish.json'

    Raises :class:`InputError` if the arrays are no mesh, an option is out of its range, or heights do not fit single precision.
    """
    whole = as_mesh(mesh, faces, uvs, uv_faces, weld)
    return whole.bake(method, lambda_=lambda_, **options)


def noise(
    mesh: Any, faces: Any = None, *, sigma: float | None = None, kind: str | None = None, seed: int = 1, **settings: Any
) -> Noisy:
    """Adds synthetic noise to a clean mesh, for tests and experiments.

    ``mesh`` and ``faces`` are as for :func:`planish.denoise`. ``sigma`` is the standard deviation in mean edge lengths; without
    it the kind has its usual one. ``kind`` and ``settings`` are those of ``planish noise`` with underscores. The same seed gives the
    same noise.

    >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> noisy = noise(square, [[0, 1, 2], [0, 2, 3]], sigma=0.1, seed=7)
    >>> noisy.report["settings"]["sigma"]
    0.1

    Raises :class:`InputError` if the kind does not have a setting, or does not go with the mesh.
    """
    return as_mesh(mesh, faces).noise(sigma, kind, seed=seed, **settings)


def compare(clean: Any, result: Any, faces: Any = None) -> dict[str, Any]:
    """Measures a result against the clean mesh.

    ``clean`` and ``result`` are meshes, or positions (#v×3, model units) that share ``faces``. Returns the measures of ``planish compare
    --json``: ``Ea_deg`` is the mean angle between corresponding face normals in degrees, and distances (``d_mean_el``, …) are in
    mean edge lengths of the clean mesh.

    >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> bent = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1]]
    >>> round(compare(square, bent, [[0, 1, 2], [0, 2, 3]])["Ea_deg"], 3)
    27.368

    Raises :class:`InputError` if the meshes have different vertices or faces.
    """
    whole = as_mesh(clean, faces)
    other = as_mesh(result, faces)
    return json.loads(other.native.compared(whole.native))  # type: ignore[no-any-return]


def info(mesh: Any, faces: Any = None) -> dict[str, Any]:
    """Content and defects of a mesh, or of the file of a path, as ``planish info --json`` prints them.

    >>> info([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])["defects"]["boundary_edges"]
    3
    """
    if faces is None and isinstance(mesh, (str, PathLike)):
        return read(mesh).info()
    return as_mesh(mesh, faces).info()


def apply(
    manifest: PathLikeStr, *, mesh: PathLikeStr | None = None, lambda_: float | None = None, trust: bool = False
) -> Displaced:
    """Displaces a mesh by its map, as the vertex shader would.

    ``manifest`` is the file NAME.planish.json of a bake. ``mesh`` is the mesh that was baked or its carrier; without it the carrier
    beside the manifest is taken. ``lambda_`` is the strength: 0 is noisy, 1 is denoised; without it the manifest says. With
    ``trust`` files that the manifest names are read from anywhere.

    >>> import pathlib, tempfile
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> tent = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 1]]
    >>> faces = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    >>> _ = bake(tent, faces, method="laplacian", iterations=1, step=1.0).write(folder)
    >>> apply(folder / "mesh.planish.json", lambda_=0.5).vertices[4].round(4)
    array([1. , 1. , 0.5])

    Raises :class:`InputError` if a file is missing, or is not the one that was written with the manifest.
    """
    path = None if mesh is None else fspath(mesh)
    return Displaced(*_planish.apply(fspath(manifest), path, lambda_, trust))


def methods() -> dict[str, dict[str, Any]]:
    """All denoising methods by their names, each with its ``summary``, ``reference`` and ``parameters``: name, kind, range, default,
    unit and help.

    >>> [p["name"] for p in methods()["taubin"]["parameters"]][:2]
    ['iterations', 'step']
    """
    return {method["name"]: method for method in json.loads(_planish.methods())}
