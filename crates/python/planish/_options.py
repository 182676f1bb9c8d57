"""Keyword arguments as the options that the native part and the command line read."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import InputError

Progress = Callable[[str, float], object]
"""Callable that is told the stage and the fraction of it that is done, 0 to 1; if it returns False, the work stops."""


def method_options(
    method: str,
    preset: str,
    fix: str | ArrayLike | None,
    max_displacement: float | None,
    preserve_volume: bool,
    direction: str | ArrayLike | None,
    parameters: dict[str, Any],
) -> str:
    """A method with its settings and limits, as JSON."""
    options = {
        "method": method,
        "preset": preset,
        "parameters": parameters,
        "fix": _mask(fix),
        "max_displacement": max_displacement,
        "preserve_volume": bool(preserve_volume),
        "direction": _direction(direction),
    }
    try:
        return json.dumps(options, default=_plain, allow_nan=False)
    except InputError:
        raise
    except ValueError:
        raise InputError("a setting is infinite or not a number") from None


def _plain(value: Any) -> Any:
    """Numbers of NumPy as those of Python."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise InputError(f"a setting is a {type(value).__name__}, and needs to be a number, a word or a list of words")


def _direction(direction: str | ArrayLike | None) -> str | None:
    """A direction as the command line writes it."""
    if direction is None or isinstance(direction, str):
        return direction
    try:
        axis = np.asarray(direction, dtype=np.float64)
    except (TypeError, ValueError):
        axis = np.empty(0)
    if axis.shape != (3,) or not np.isfinite(axis).all():
        raise InputError('`direction` is three numbers, or a text such as "0,0,1" or "ray:0,0,0"')
    return ",".join(repr(float(x)) for x in axis)


def weights(mask: ArrayLike | None) -> NDArray[np.float32] | None:
    """Weights of the vertices, 0 to 1."""
    if mask is None:
        return None
    try:
        array = np.ascontiguousarray(mask, dtype=np.float32)
    except (TypeError, ValueError) as error:
        raise InputError(f"`mask` is no array of numbers: {error}") from None
    if array.ndim != 1:
        raise InputError(f"`mask` has the shape {array.shape} and needs (#v,), one weight for each vertex")
    wrong = np.flatnonzero(~((array >= 0) & (array <= 1)))
    if len(wrong):
        raise InputError(f"`mask[{wrong[0]}]` is {array[wrong[0]]}, and weights are from 0 to 1")
    return array


def _mask(fix: str | ArrayLike | None) -> str | None:
    """Vertices that stay, as text that counts them from 1."""
    if fix is None:
        return None
    if isinstance(fix, str):
        if fix != "boundary":
            raise InputError(f'`fix` is "boundary", indices or a mask, not {fix!r}')
        return fix
    array = np.asarray(fix)
    if array.dtype == bool:
        array = np.flatnonzero(array)
    if array.size == 0:
        return None
    if array.ndim != 1 or array.dtype.kind not in "iu":
        raise InputError('`fix` is "boundary", indices (n,) or a mask (#v,) of truth values')
    if array.min() < 0:
        raise InputError(f"`fix[{int(array.argmin())}]` is negative")
    return " ".join(str(int(index) + 1) for index in np.unique(array))


def command_line(options: dict[str, Any]) -> list[str]:
    """Options of the command line for keyword arguments; None leaves one at its default, and True is a flag."""
    words = []
    for name, value in options.items():
        name = "--" + name.rstrip("_").replace("_", "-")
        if value is True:
            words.append(name)
        elif isinstance(value, (list, tuple, np.ndarray)):
            words.append(f"{name}={','.join(_text(x) for x in value)}")
        elif value is not None and value is not False:
            words.append(f"{name}={_text(value)}")
    return words


def _text(value: Any) -> str:
    """Shortest text that reads back to the value."""
    return repr(float(value)) if isinstance(value, (float, np.floating)) else str(value)
