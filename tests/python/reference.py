"""The quantities of a triangle mesh from their definitions, in numpy's extended precision.

Extended precision takes the reference's own rounding out of every comparison: what is left is what the other side
lost. (Where the platform has no wider float than f64 this still works, to f64's accuracy.) Nothing here is fast.
"""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

STEPS = (1, 10)
STEP = 0.5


class Edges:
    """Distinct undirected edges (a < b, sorted), how many faces use each, and the same as directed pairs i -> j."""

    def __init__(self, faces, vertices):
        halves = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        self.ends, self.uses = np.unique(halves, axis=0, return_counts=True)
        both = np.concatenate([self.ends, self.ends[:, ::-1]])
        self.i, self.j = both[np.lexsort((both[:, 1], both[:, 0]))].T
        self.valence = np.bincount(self.i, minlength=vertices)

    @property
    def boundary(self):
        return self.ends[self.uses == 1]

    @property
    def non_manifold(self):
        return self.ends[self.uses > 2]


def scatter(indices, values, rows):
    """Sums values into rows; np.bincount would fall back to f64."""
    total = np.zeros((rows, *values.shape[1:]), dtype=values.dtype)
    np.add.at(total, indices, values)
    return total


def unit(vectors):
    """Unit vectors; zero where there is no direction."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)


def corner_edges(positions, faces):
    """From each corner (m x 3 x 3) to the next and to the one after it."""
    corners = positions[faces]
    return np.roll(corners, -1, axis=1) - corners, np.roll(corners, -2, axis=1) - corners


def rings(edges, vertices):
    return np.split(edges.j, np.cumsum(edges.valence)[:-1]) if vertices else []


def non_manifold_vertices(faces, edges, vertices):
    """Vertices whose faces, joined along edges at the vertex, are not one fan, and ends of edges with three faces."""
    # One node per (vertex, neighbour); a face joins the two of its edges that leave the vertex.
    node = {pair: k for k, pair in enumerate(zip(edges.i.tolist(), edges.j.tolist()))}
    corners = [(f[k], f[(k + 1) % 3], f[(k + 2) % 3]) for f in faces.tolist() for k in range(3)]
    links = np.array([(node[v, a], node[v, b]) for v, a, b in corners]).reshape(-1, 2)
    graph = coo_matrix((np.ones(len(links)), links.T), shape=(len(node), len(node)))
    _, fan = connected_components(graph, directed=False)
    fans_at = np.bincount(np.unique(np.stack([edges.i, fan]), axis=1)[0], minlength=vertices)
    return np.union1d(np.flatnonzero(fans_at > 1), edges.non_manifold)


def corner_cotangents(positions, faces):
    """m x 3; zero in a face without area, which has no angles worth the name."""
    u, v = corner_edges(positions, faces)
    twice_area = np.linalg.norm(np.cross(u, v), axis=2)
    dot = (u * v).sum(axis=2)
    return np.divide(dot, twice_area, out=np.zeros_like(dot), where=twice_area > 0)


def edge_weights(corner_values, faces, edges, vertices):
    """Half the sum of what lies opposite, for each directed pair of `edges`: the w_ij of the cotangent Laplacian."""
    opposite = np.stack([np.roll(faces, -1, axis=1), np.roll(faces, -2, axis=1)], axis=-1).reshape(-1, 2)
    key = np.concatenate([opposite, opposite[:, ::-1]]) @ [vertices, 1]
    place = np.searchsorted(edges.i * vertices + edges.j, key)
    return scatter(place, np.tile(corner_values.ravel(), 2) / 2, len(edges.i))


def laplacian(weights, edges, vertices):
    """Weights off the diagonal, minus their row sums on it: rows of [i, j, w], sorted."""
    diagonal = np.flatnonzero(edges.valence)
    i, j = np.concatenate([edges.i, diagonal]), np.concatenate([edges.j, diagonal])
    w = np.concatenate([weights, -scatter(edges.i, weights, vertices)[diagonal]])
    order = np.lexsort((j, i))
    return np.stack([i.astype(w.dtype), j.astype(w.dtype), w], axis=1)[order]


def smoothed(positions, weights, edges):
    """`STEPS` simultaneous steps towards the weighted mean of the neighbours; boundary and weightless vertices stay."""
    total = scatter(edges.i, weights, len(positions))
    moves = total > 0
    moves[edges.boundary.ravel()] = False
    share = weights / np.where(total > 0, total, 1)[edges.i]
    result, states = positions, {}
    for step in range(1, max(STEPS) + 1):
        pull = scatter(edges.i, share[:, None] * (result[edges.j] - result[edges.i]), len(positions))
        result = result + STEP * pull * moves[:, None]
        if step in STEPS:
            states[str(step)] = result
    return states


def corner_weights(positions, faces):
    """What a face's normal counts at each of its corners (m x 3), by the name of the weighting."""
    u, v = corner_edges(positions, faces)
    twice_area = np.linalg.norm(np.cross(u, v), axis=2)
    angles = np.arctan2(twice_area, (u * v).sum(axis=2))
    return {"uniform": np.ones_like(angles), "area": twice_area / 2, "angle": angles}


def normal_sums(face_normals, weights, faces, vertices):
    """n x 3, not normalised."""
    weighted = weights[:, :, None] * face_normals[:, None]
    return scatter(faces.ravel(), weighted.reshape(-1, 3), vertices)


def quantities(positions, faces):
    """Everything the planish binary `quantities` prints, as arrays under the same names."""
    p, n = positions.astype(np.longdouble), len(positions)
    edges = Edges(faces, n)
    u, v = corner_edges(p, faces)
    cross = np.cross(u, v)[:, 0]
    face_normals, areas = unit(cross), np.linalg.norm(cross, axis=1) / 2
    weightings = corner_weights(p, faces)
    uniform = np.ones(len(edges.i), dtype=np.longdouble)
    delta = scatter(edges.i, p[edges.j] - p[edges.i], n) / np.maximum(edges.valence, 1)[:, None]
    cotangent = edge_weights(corner_cotangents(p, faces), faces, edges, n)
    # Vertices that no face uses take no part.
    centred = p - p[np.unique(faces)].mean(axis=0)
    a, b, c = np.moveaxis(centred[faces], 1, 0)
    return {
        "vertices": n,
        "faces": len(faces),
        "rings": rings(edges, n),
        "boundary_vertices": np.unique(edges.boundary),
        "boundary_edges": edges.boundary,
        "non_manifold_edges": edges.non_manifold,
        "non_manifold_vertices": non_manifold_vertices(faces, edges, n),
        "face_normals": face_normals,
        "vertex_normals": {k: unit(normal_sums(face_normals, w, faces, n)) for k, w in weightings.items()},
        "uniform_laplacian": delta,
        "cotangent_laplacian": laplacian(cotangent, edges, n),
        "mass": scatter(faces.ravel(), np.repeat(areas / 3, 3), n),
        "smoothed_uniform": smoothed(p, uniform, edges),
        "smoothed_cotangent": smoothed(p, np.maximum(cotangent, 0), edges),
        "mean_edge": np.linalg.norm(p[edges.ends[:, 0]] - p[edges.ends[:, 1]], axis=1).mean(),
        "area": areas.sum(),
        "volume": (a * np.cross(b, c)).sum() / 6,
    }
