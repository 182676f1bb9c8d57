"""Many meshes, or a very large one, on many processes or machines, by Dask (``pip install planish[dask]``).

Without a ``client`` the processes are started here and end with the work; with ``Client(address)`` the same work runs on a cluster,
where all machines see the same files.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from os import PathLike, fspath
from typing import Any

from numpy.typing import ArrayLike

from . import _planish
from ._errors import Error, InputError
from ._large import Settings, Tiles, bake_tiles, denoise_tiles, forget
from ._mesh import read
from ._options import Progress, method_options

PathLikeStr = str | PathLike[str]


def denoise_files(
    paths: Iterable[PathLikeStr],
    output: PathLikeStr,
    method: str = "auto",
    *,
    client: Any = None,
    workers: int | None = None,
    update_normals: bool = False,
    weld: str | float = "exact",
    trust: bool = False,
    **options: Any,
) -> list[dict[str, Any]]:
    """Denoises mesh files into the folder ``output``, each under its name, whole or not at all.

    ``options`` are those of :func:`planish.denoise`, ``update_normals`` that of :meth:`planish.Denoised.write`, ``weld`` and ``trust``
    those of :func:`planish.read`. ``client`` is a ``dask.distributed.Client``; without one, ``workers`` processes are started (by
    default one for each processor).

    Returns one dictionary for each path, in their order: ``mesh``, ``ok``, ``seconds``, and the report or the ``error``. A mesh that
    fails costs no other. A worker that dies is replaced, and its meshes are done again.

    Raises :class:`planish.InputError` if two paths have the same name.
    """
    jobs = [(path, os.path.join(fspath(output), os.path.basename(path))) for path in (fspath(path) for path in paths)]
    return _run(_denoise, jobs, client, workers, (method, options, update_normals, weld, trust))


def bake_files(
    paths: Iterable[PathLikeStr],
    output: PathLikeStr,
    method: str = "auto",
    *,
    client: Any = None,
    workers: int | None = None,
    weld: str | float = "exact",
    trust: bool = False,
    **options: Any,
) -> list[dict[str, Any]]:
    """Bakes the displacement maps of mesh files, each into a folder NAME-planish in the folder ``output``.

    ``options`` are those of :func:`planish.bake`; all else is as for :func:`denoise_files`.
    """
    jobs = [(path, os.path.join(fspath(output), f"{_stem(path)}-planish")) for path in (fspath(path) for path in paths)]
    return _run(_bake, jobs, client, workers, (method, options, weld, trust))


def denoise_large(
    path: PathLikeStr,
    output: PathLikeStr,
    method: str = "auto",
    *,
    client: Any = None,
    workers: int | None = None,
    memory_limit: str | int | None = "auto",
    tiles: int | None = None,
    halo: int | None = None,
    folder: PathLikeStr | None = None,
    weld: str = "exact",
    preset: str = "default",
    fix: str | ArrayLike | None = None,
    mask: ArrayLike | None = None,
    direction: str | ArrayLike | None = None,
    max_displacement: float | None = None,
    progress: Progress | None = None,
    **parameters: Any,
) -> dict[str, Any]:
    """Denoises one mesh that is larger than the memory of a worker, in tiles, and writes it to the file ``output``.

    The file is an OBJ or a binary PLY. It is read twice, piece by piece, and all of its bytes stay but the numbers of moved vertices.
    ``tiles`` is the number of tiles; by default each has about 250,000 vertices. Each is denoised with a halo of ``halo`` rings around it, by
    default as wide as suits the method.

    The methods laplacian, taubin, hc, sun and bilateral-normals look so many rings far and no farther. The halo is that wide, and the result
    is that of :func:`planish.denoise` bit for bit. So is that of guided-normals without limits, whose rounds all tiles take together. All
    other methods solve for the whole mesh or measure it. Their tiles overlap, and in the overlap one result goes over into the other.

    ``client`` is a ``dask.distributed.Client`` whose workers see the same files; without one, ``workers`` processes are started, each with
    ``memory_limit`` as of ``LocalCluster``. ``folder`` holds what lies between the steps, by default ``output`` with .tiles behind it.
    It stays there if the work is stopped, the same call goes on from it, and it is removed when the work is done. A worker that dies is replaced.

    ``weld`` is "exact" or "none". ``preset``, ``fix``, ``mask``, ``direction``, ``max_displacement`` and ``parameters`` are those of
    :func:`planish.denoise`. ``progress`` is told the stage and the fraction of it that is done; if it returns False, the work stops.

    Returns a report: ``exact`` (whether it is that of the whole mesh bit for bit), ``borders`` with the agreement of tiles where two of them have the
    same vertices (``gap``: largest distance between their results, ``jump``: largest step that is left of it between neighbours,
    ``rms_jump``: root of the mean square of these steps, model units, and ``jump_in_sigma`` and ``rms_jump_in_sigma``: the same in
    standard deviations of the noise, for "auto"), ``tiles`` (vertices of each), ``tiles_kept`` (done before
    this call), ``mean_displacement``, ``max_displacement`` (model units), and ``seconds`` of each stage.

    Raises :class:`planish.InputError` if the file is no mesh or of another format, :class:`planish.Interrupted` if ``progress`` returned
    False.
    """
    path, output = fspath(path), fspath(output)
    words, fixed = (fix, None) if isinstance(fix, str) else (None, fix)
    options = method_options(method, preset, words, max_displacement, False, direction, parameters)
    settings = Settings(options, tiles, halo, weld, fixed, mask)
    _planish.tiles_check(path, output)

    def work(run: Tiles) -> dict[str, Any]:
        return denoise_tiles(run, os.path.abspath(output), settings)

    return _in_tiles(work, path, folder if folder is not None else f"{output}.tiles", client, workers, memory_limit, progress)


def bake_large(
    path: PathLikeStr,
    output: PathLikeStr,
    method: str = "auto",
    *,
    client: Any = None,
    workers: int | None = None,
    memory_limit: str | int | None = "auto",
    tiles: int | None = None,
    halo: int | None = None,
    folder: PathLikeStr | None = None,
    weld: str = "exact",
    map: str = "scalar",
    bits: int = 16,
    lambda_: float = 1.0,
    preset: str = "default",
    fix: str | ArrayLike | None = None,
    mask: ArrayLike | None = None,
    direction: str | ArrayLike | None = None,
    max_displacement: float | None = None,
    progress: Progress | None = None,
    **parameters: Any,
) -> dict[str, Any]:
    """Bakes the displacement map of one mesh that is larger than the memory of a worker into the folder ``output``.

    The mesh is denoised in tiles, as :func:`denoise_large` does it. The map has a page for each tile: an image with one texel for each
    vertex of the tile and for the other vertices of its faces. All pages have one bias and scale, so that a vertex has the same step
    in each of them, and tiles that are drawn side by side meet without a crack. The texture coordinates of the mesh are not used. The
    manifest names all pages, ``planish check`` and ``planish apply`` read it, and the carrier is an OBJ with positions,
    normals and faces alone.

    ``map`` is "scalar" for heights along the angle-weighted normals of the mesh, or "vector" for whole displacements. ``bits`` is 8, 16
    (PNG) or 32 (EXR). ``lambda_`` is the strength for client programs. Where a bake of the whole mesh would not come to the same
    displacements, the denoised mesh becomes a file of the bundle, NAME.denoised, which the map leads to.

    All else is as for :func:`denoise_large`. Returns its report with ``manifest`` (path), ``pages`` (names of the images),
    ``displacement`` and ``report`` as the manifest has them; ``seam_gap`` is the largest distance between the places of a vertex in
    two pages.

    Raises :class:`planish.InputError` if the file is no mesh or of another format, :class:`planish.Interrupted` if ``progress`` returned
    False.
    """
    path, output = fspath(path), fspath(output)
    words, fixed = (fix, None) if isinstance(fix, str) else (None, fix)
    options = method_options(method, preset, words, max_displacement, False, direction, parameters)
    settings = Settings(options, tiles, halo, weld, fixed, mask)
    of_map = {"map": map, "bits": int(bits), "lambda": float(lambda_)}
    _planish.tiles_check_map(path, output, json.dumps({"key": "", **of_map}))

    def work(run: Tiles) -> dict[str, Any]:
        return bake_tiles(run, os.path.abspath(output), settings, of_map)

    own = folder if folder is not None else f"{output.rstrip(os.sep)}.tiles"
    return _in_tiles(work, path, own, client, workers, memory_limit, progress)


def _in_tiles(
    work: Callable[[Tiles], dict[str, Any]],
    path: str,
    folder: PathLikeStr,
    client: Any,
    workers: int | None,
    memory_limit: str | int | None,
    progress: Progress | None,
) -> dict[str, Any]:
    """Works on a mesh in tiles in a working folder, which is removed when the work is done."""
    own = fspath(folder)
    is_new = not os.path.exists(own)
    os.makedirs(own, exist_ok=True)
    with _client(client, workers, memory_limit) as (active, threads):
        run = Tiles(active, threads, os.path.abspath(path), os.path.abspath(own), progress)
        try:
            report = work(run)
        except InputError:
            # Earlier work is kept.
            if is_new:
                forget(own)
            raise
    forget(own)
    return report


def _stem(path: str) -> str:
    """Name without the extension of the mesh and that of a compression."""
    name = os.path.basename(path)
    for compression in (".gz", ".xz"):
        name = name.removesuffix(compression)
    return os.path.splitext(name)[0]


def _run(
    work: Any, jobs: list[tuple[str, str]], client: Any, workers: int | None, arguments: tuple[Any, ...]
) -> list[dict[str, Any]]:
    results: dict[str, str] = {}
    for path, result in jobs:
        if results.setdefault(result, path) != path:
            raise InputError(f"{path} would have the same result as {results[result]}: {result}")
    with _client(client, workers) as (active, threads):
        # Results depend on nothing but the arguments; what a worker that died had written is written again.
        futures = active.map(
            _timed, *zip(*[(work, path, result, threads, arguments) for path, result in jobs]), pure=False, retries=1
        )
        return list(active.gather(futures))


@contextmanager
def _client(
    client: Any, workers: int | None, memory_limit: str | int | None = "auto"
) -> Iterator[tuple[Any, int | None]]:
    """A client, and the number of threads that each of its workers should have; None if that is its own affair."""
    if client is not None:
        yield client, None
        return
    from dask.distributed import Client, LocalCluster

    processors = os.cpu_count() or 1
    count = workers or processors
    cluster = LocalCluster(
        n_workers=count, threads_per_worker=1, dashboard_address=None, memory_limit=memory_limit
    )
    with cluster, Client(cluster) as own:
        yield own, max(1, processors // count)


def _timed(work: Any, path: str, result: str, threads: int | None, arguments: tuple[Any, ...]) -> dict[str, Any]:
    """Works on one mesh in a worker."""
    if threads:
        os.environ.setdefault("RAYON_NUM_THREADS", str(threads))
    start = time.perf_counter()
    line: dict[str, Any] = {"mesh": path, "ok": True}
    try:
        line |= work(path, result, *arguments)
    except Error as error:
        line |= {"ok": False, "error": str(error)}
    return line | {"seconds": time.perf_counter() - start}


def _denoise(
    path: str, result: str, method: str, options: dict[str, Any], update_normals: bool, weld: str | float, trust: bool
) -> dict[str, Any]:
    denoised = read(path, weld=weld, trust=trust).denoise(method, **options)
    return denoised.report | denoised.write(result, update_normals=update_normals)


def _bake(
    path: str, result: str, method: str, options: dict[str, Any], weld: str | float, trust: bool
) -> dict[str, Any]:
    bundle = read(path, weld=weld, trust=trust).bake(method, folder=result, **options)
    bundle.write()
    return {
        "output": result,
        "choice": bundle.choice,
        "displacement": bundle.manifest["displacement"],
        "report": bundle.report,
        "notes": bundle.notes,
    }
