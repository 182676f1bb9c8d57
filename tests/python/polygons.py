"""What planish makes of a file's positions and polygons before it computes: welding, and faces it leaves out."""

import numpy as np


def welded(positions, polygons):
    """The vertex of each position; equal positions are one vertex, and 0.0 equals -0.0."""
    # np.unique compares numbers, except that it may tell zeros apart by their sign: adding 0.0 clears it.
    _, vertex = np.unique(positions + 0.0, axis=0, return_inverse=True)
    vertex = vertex.ravel()
    return vertex, [[int(vertex[i]) for i in polygon] for polygon in polygons]


def tidied(polygons):
    """Without corners that repeat the one before, faces that keep fewer than three different ones, and second layers of a face."""
    seen, kept = set(), []
    for polygon in polygons:
        face = [v for k, v in enumerate(polygon) if v != polygon[k - 1]]
        layer = tuple(sorted(face))
        if len(set(face)) >= 3 and layer not in seen:
            seen.add(layer)
            kept.append(face)
    return kept
