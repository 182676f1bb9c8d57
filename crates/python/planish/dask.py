"""Many meshes on many processes or machines, by Dask (``pip install planish[dask]``).

Without a ``client`` the processes are started here and end with the work; with ``Client(address)`` the same work runs on a cluster,
where all machines see the same files.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from os import PathLike, fspath
from typing import Any

from ._errors import Error, InputError
from ._mesh import read

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
def _client(client: Any, workers: int | None) -> Iterator[tuple[Any, int | None]]:
    """A client, and the number of threads that each of its workers should have; None if that is its own affair."""
    if client is not None:
        yield client, None
        return
    from dask.distributed import Client, LocalCluster

    processors = os.cpu_count() or 1
    count = workers or processors
    with LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as own:
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
