"""One mesh in tiles, on many workers."""

from __future__ import annotations

import hashlib
import json
import os
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _planish
from ._errors import Error, InputError, Interrupted
from ._options import Progress, weights

# Vertices of a tile by default. With the halo of a method that solves for all vertices, one needs about a gigabyte.
_TILE = 250_000
# Bytes of a file for each vertex, about: of two triangles and a vertex with three numbers.
_BYTES = {".ply": 38}
_BYTES_OF_TEXT = 90
# Times that the halo is widened where tiles do not agree.
_WIDENINGS = 3


def tile_count(path: str) -> int:
    """Number of tiles that suits a file."""
    each = _BYTES.get(os.path.splitext(path)[1].lower(), _BYTES_OF_TEXT)
    return min(400, max(1, round(os.path.getsize(path) / each / _TILE)))


def key_of(*parts: Any) -> str:
    """What identifies work by all that its result depends on."""
    text = json.dumps([_planish.version(), *parts], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def digest_of(path: str) -> str:
    """Digest of a file, which is read piece by piece."""
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as file:
            while piece := file.read(1 << 24):
                digest.update(piece)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    return digest.hexdigest()


class Tiles:
    """A mesh in tiles, in a working folder that all workers see."""

    def __init__(self, client: Any, threads: int | None, path: str, folder: str, progress: Progress | None) -> None:
        self.client, self.threads, self.path, self.folder, self.progress = client, threads, path, folder, progress
        self.seconds: dict[str, float] = {}

    def one(self, stage: str, work: str, *arguments: Any) -> Any:
        """Does one thing in a worker."""
        return self.each(stage, work, [arguments])[0]

    def each(self, stage: str, work: str, arguments: list[tuple[Any, ...]]) -> list[Any]:
        """Does the same thing for each of some arguments, in any order; what a worker that died had begun is begun again. ``work`` is the
        name of a function of the native part."""
        from dask.distributed import as_completed

        start = time.perf_counter()
        futures = [self.client.submit(_work, self.threads, work, *each, pure=False) for each in arguments]
        try:
            self._tell(stage, 0.0)
            for done, future in enumerate(as_completed(futures), 1):
                _, error = future.result()
                if error is not None:
                    raise error
                self._tell(stage, done / len(futures))
            results = self.client.gather(futures)
        finally:
            self.client.cancel(futures)
        self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start
        return [result for result, _ in results]

    def _tell(self, stage: str, fraction: float) -> None:
        if self.progress is not None and self.progress(stage, fraction) is False:
            raise Interrupted(f"interrupted; what is done is kept in {self.folder}")


def _work(threads: int | None, work: str, *arguments: Any) -> tuple[Any, Error | None]:
    """Works in a worker. Returns the result or the error, which another worker would find as well."""
    if threads:
        os.environ.setdefault("RAYON_NUM_THREADS", str(threads))
    try:
        return getattr(_planish, work)(*arguments), None
    except Error as error:
        return None, error


@dataclass
class Settings:
    """How a mesh in tiles is denoised; ``method`` is JSON."""

    method: str
    tiles: int | None
    halo: int | None
    weld: str | float
    fix: ArrayLike | None
    mask: ArrayLike | None


@dataclass
class _Merged:
    """What is known when the tiles are put together."""

    # SHA-256 of the mesh file.
    digest: str
    # Name of all that the result depends on, and the last job, as JSON.
    key: str
    job: str
    plan: dict[str, Any]
    facts: dict[str, Any]
    borders: dict[str, Any]
    done: list[dict[str, Any]]
    kept: int


def denoise_tiles(run: Tiles, output: str, settings: Settings) -> dict[str, Any]:
    """Denoises a mesh in tiles and writes it."""
    merged = _merge(run, settings)
    run.one("writing", "tiles_write", run.path, output, run.folder)
    return _report(run, output, merged)


def bake_tiles(run: Tiles, output: str, settings: Settings, options: dict[str, Any]) -> dict[str, Any]:
    """Bakes the map of a mesh in tiles into the folder ``output``; ``options`` are those of the map."""
    merged = _merge(run, settings)
    path, folder = run.path, run.folder
    report = _report(run, output, merged)
    mesh = None
    if not (report["exact"] and merged.facts["own_maps"][options["map"]]):
        # What a check of the map cannot find again becomes a file.
        denoised = os.path.join(folder, "denoised-mesh" + os.path.splitext(path)[1])
        run.one("writing", "tiles_write", path, denoised, folder)
        run.one("writing", "tiles_take_positions", denoised, folder)
        mesh = (denoised, digest_of(denoised))
    job = json.dumps({"key": key_of(merged.key, mesh is None, options), **options})
    indices = range(len(merged.plan["tiles"]))
    run.each("heights", "tile_heights", [(folder, tile, job) for tile in indices])
    run.each("pages", "tile_page", [(folder, tile, job) for tile in indices])
    told = run.one("bundle", "tiles_bundle", path, (folder, output), (merged.job, job), merged.digest, mesh)
    bundle: dict[str, Any] = json.loads(told)
    return report | bundle


def _merge(run: Tiles, settings: Settings) -> _Merged:
    """Denoises a mesh in tiles and puts these together."""
    path, folder = run.path, run.folder
    method, tiles, halo, weld = settings.method, settings.tiles, settings.halo, settings.weld
    digest = digest_of(path)
    count = tile_count(path) if tiles is None else tiles
    key = key_of(digest, count, weld)
    plan = json.loads(run.one("spreading", "tiles_spread", path, folder, key, count, weld))
    told = _weights(folder, plan["vertices"], settings.fix, settings.mask)

    def job(width: int | None, lengths: Any) -> dict[str, Any]:
        of = key_of(key, method, width, digest_of(told) if told else None)
        return {"key": of, "method": json.loads(method), "halo": width, "lengths": lengths, "weights": told}

    facts = json.loads(_planish.tiles_job(json.dumps(job(halo, None))))
    indices = range(len(plan["tiles"]))
    lengths = None
    if facts["needs_lengths"]:
        run.each("measuring", "tile_lengths", [(folder, tile) for tile in indices])
        lengths = json.loads(run.one("measuring", "tiles_measure", folder))
    kept = 0
    for widening in range(_WIDENINGS):
        is_last = widening == _WIDENINGS - 1
        todo = job(halo, lengths)
        kept += sum(os.path.exists(os.path.join(folder, f"tile-{tile:04}.{todo['key']}.json")) for tile in indices)
        text = json.dumps(todo)
        facts = json.loads(_planish.tiles_job(text))
        different = _take_rounds(run, text, facts["rounds"], indices, is_last)
        if different and not is_last:
            halo = 2 * int(facts["halo"])
            continue
        done = run.each("denoising", "tile_denoise", [(folder, tile, text) for tile in indices])
        borders = json.loads(run.one("merging", "tiles_merge", folder, text))
        borders["different"] = max(borders["different"], different)
        if not facts["bounded"] or borders["different"] == 0:
            break
        halo = 2 * int(facts["halo"])
    return _Merged(digest, todo["key"], text, plan, facts, borders, [json.loads(each) for each in done], kept)


def _take_rounds(run: Tiles, job: str, rounds: int, indices: range, to_the_end: bool) -> int:
    """Takes the rounds of a method that measures the whole mesh before each of them; others have none. Returns the number of results in
    which tiles differ. The work ends with the first round that has any, unless it goes ``to_the_end``."""
    if not rounds:
        return 0
    last = _planish.tiles_last_round(run.folder, job)
    while True:
        known = json.loads(last)
        if known["round"] == rounds or (known["different"] and not to_the_end):
            return int(known["different"])
        run.each("denoising", "tile_round", [(run.folder, tile, job, last) for tile in indices])
        last = run.one("measuring", "tiles_end_round", run.folder, job, last)


def _weights(folder: str, vertices: int, fix: ArrayLike | None, mask: ArrayLike | None) -> str | None:
    """A file with a weight for each vertex, of a mask and of vertices that stay."""
    if fix is None and mask is None:
        return None
    told = weights(mask)
    if told is None:
        told = np.ones(vertices, dtype=np.float32)
    elif len(told) != vertices:
        raise InputError(f"`mask` has {len(told)} weights, and the mesh has {vertices} vertices")
    if fix is not None:
        stays = np.asarray(fix)
        stays = np.flatnonzero(stays) if stays.dtype == bool else stays
        if stays.ndim != 1 or (stays.size and stays.dtype.kind not in "iu"):
            raise InputError('`fix` is "boundary", indices (n,) or a mask (#v,) of truth values')
        outside = stays[(stays < 0) | (stays >= vertices)]
        if outside.size:
            raise InputError(f"`fix` names vertex {outside[0]}, and the mesh has {vertices}")
        told = told.copy()
        told[stays.astype(np.int64)] = 0
    path = os.path.join(folder, "weights")
    told.astype("<f4").tofile(path)
    return path


def _report(run: Tiles, output: str, merged: _Merged) -> dict[str, Any]:
    plan, facts, borders, done = merged.plan, merged.facts, merged.borders, merged.done
    sigmas = sorted(tile["sigma"] for tile in done if tile.get("sigma"))
    sigma = sigmas[len(sigmas) // 2] if sigmas else None
    misoriented = sum(tile["misoriented_edges"] for tile in done)
    notes = []
    if misoriented:
        notes.append(f"{misoriented} edges have faces that disagree about the outside; tiles turn them each for itself")
    if facts["bounded"] and borders["different"]:
        notes.append(f"tiles disagree at {borders['different']} vertices, by up to {borders['gap']}; a wider `halo` helps")
    return {
        "mesh": run.path,
        "output": output,
        "method": facts["method"],
        "vertices": plan["vertices"],
        "faces": plan["faces"],
        "tiles": plan["tiles"],
        "tiles_kept": merged.kept,
        "halo": facts["halo"],
        "exact": bool(facts["bounded"] and borders["different"] == 0 and not misoriented),
        "borders": borders
        | {f"{jump}_in_sigma": borders[jump] / sigma if sigma else None for jump in ("jump", "rms_jump")},
        "sigma": sigma,
        "mean_displacement": sum(tile["displacement"] for tile in done) / plan["vertices"],
        "max_displacement": max(tile["max_displacement"] for tile in done),
        "choices": [tile["choice"] for tile in done if "choice" in tile],
        "seconds": run.seconds,
        "notes": notes,
    }


def forget(folder: str) -> None:
    """Removes a working folder, and nothing that is not its own."""
    for name in os.listdir(folder):
        if name.startswith(("tile-", "plan.", "positions", "denoised", "weights", "faces")):
            os.remove(os.path.join(folder, name))
    try:
        os.rmdir(folder)
    except OSError:
        # Somebody else has put something there.
        pass
