"""Pictures of results, with matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def plot_heights(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64], deltas: NDArray[np.float64], ax: Any
) -> Any:
    """Draws a surface coloured by how far each vertex moved along its normal."""
    import matplotlib.pyplot as plt
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    heights = (deltas[triangles].mean(axis=1) * normals).sum(axis=1)
    limit = float(np.quantile(np.abs(heights), 0.99)) or 1.0
    colours = ScalarMappable(Normalize(-limit, limit), "RdBu_r")
    if ax is None:
        ax = plt.figure(figsize=(7, 6)).add_subplot(projection="3d")
    # Faces that look away from a light behind the viewer are darker.
    shade = 0.6 + 0.4 * np.abs(normals @ (np.array([1.0, -1.0, 1.5]) / np.sqrt(4.25)))
    faces = np.asarray(colours.to_rgba(heights)) * np.column_stack([shade, shade, shade, np.ones_like(shade)])
    ax.add_collection3d(Poly3DCollection(corners, facecolors=faces, linewidths=0))
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    for axis, (a, b) in zip("xyz", zip(low, high)):
        getattr(ax, f"set_{axis}lim")(a, b)
    ax.set_box_aspect(np.maximum(high - low, 1e-9 * (high - low).max()))
    ax.set_axis_off()
    bar = ax.figure.colorbar(colours, ax=ax, shrink=0.6)
    bar.set_label("noise along the normal, model units")
    return ax
