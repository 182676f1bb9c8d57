"""Arrays as the native part reads them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import InputError

Floats = NDArray[np.float64]
Indices = NDArray[np.int64] | NDArray[np.uint32] | NDArray[np.int32]
Corners = int | NDArray[np.int64]

_INDEX_TYPES = (np.int64, np.uint32, np.int32)


def floats(array: ArrayLike, name: str, columns: int) -> Floats:
    """Rows of numbers: the array itself if it is contiguous and of 64 bits, else a copy that is."""
    try:
        found = np.ascontiguousarray(array, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"`{name}` is no array of numbers: {error}") from None
    if found.ndim != 2 or found.shape[1] != columns:
        raise InputError(f"`{name}` has the shape {found.shape} and needs (n, {columns})")
    return found


def polygons(faces: Any, name: str) -> tuple[Indices, Corners]:
    """Indices face after face, and the number of corners of all faces or of each."""
    if not isinstance(faces, np.ndarray):
        try:
            faces = np.asarray(faces)
        except ValueError:
            # Lists of different lengths.
            return _uneven(faces, name)
        if faces.dtype == object:
            return _uneven(faces, name)
    if faces.ndim != 2:
        raise InputError(f"`{name}` has the shape {faces.shape} and needs (n, corners), or be a list of lists")
    return _indices(faces, name).reshape(-1), int(faces.shape[1])


def _uneven(faces: Any, name: str) -> tuple[Indices, Corners]:
    rows = [_indices(np.asarray(face).reshape(-1), f"{name}[{i}]") for i, face in enumerate(faces)]
    counts = np.array([len(row) for row in rows], dtype=np.int64)
    return np.concatenate([row.astype(np.int64) for row in rows]), counts


def _indices(array: NDArray[Any], name: str) -> Indices:
    """Whole numbers of a type that the native part reads."""
    if array.dtype.kind not in "iu":
        if array.size == 0:
            return np.empty(array.shape, dtype=np.int64)
        raise InputError(f"`{name}` has the type {array.dtype} and needs whole numbers")
    if array.dtype not in _INDEX_TYPES:
        array = array.astype(np.int64)
    return np.ascontiguousarray(array)


def faces_of(indices: NDArray[np.int64], counts: NDArray[np.int64]) -> NDArray[np.int64] | list[NDArray[np.int64]]:
    """One row for each face if all have as many corners, else one array for each."""
    if len(counts) and (counts == counts[0]).all():
        return indices.reshape(len(counts), counts[0])
    return np.split(indices, np.cumsum(counts)[:-1])
