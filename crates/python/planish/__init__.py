"""planish removes noise from scanned meshes without touching anything else.

>>> import numpy as np
>>> import planish
>>> tent = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 1]], dtype=float)
>>> faces = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
>>> result = planish.denoise(tent, faces, method="laplacian", iterations=1, step=1.0)
>>> result.vertices[4]
array([1., 1., 0.])
>>> result.deltas[4]
array([0., 0., 1.])

docs/python.md is a guide. Lengths are in the units of the mesh, arrays of positions have one row (x, y, z) for each vertex, and
the same input gives the same bits, as on the command line.
"""

from . import _planish
from ._errors import Error, InputError, InternalError, Interrupted
from ._mesh import Mesh, apply, bake, compare, denoise, info, methods, noise, read
from ._results import Bundle, Denoised, Displaced, Moved, Noisy

__version__: str = _planish.version()

__all__ = [
    "Bundle",
    "Denoised",
    "Displaced",
    "Error",
    "InputError",
    "InternalError",
    "Interrupted",
    "Mesh",
    "Moved",
    "Noisy",
    "apply",
    "bake",
    "compare",
    "denoise",
    "info",
    "methods",
    "noise",
    "read",
]
