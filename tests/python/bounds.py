"""How far two correct f64 computations of a quantity may differ, and the comparison itself.

Every bound is `REL` = 1e-12 of the quantity's natural scale plus what rounding can do on this mesh:

- Both sides start from the same f64 coordinates, and subtracting two of them rounds to half an ulp of the *difference*.
  So an offset of |x| costs edge vectors, and all that is made from them (normals, cotangents, areas), nothing; it costs
  eps |x| wherever coordinates themselves are added up: means, smoothed positions, the centroid. In map coordinates
  (|x| = 4.5e6, edges of 0.1) that is 1e-9, 1e-8 of an edge.
- `kappa` = longest edge squared / twice the area is how badly conditioned a triangle is: 1.15 if equilateral, length /
  height for a sliver. A cross product has a relative error of eps kappa, and so have normal and area; an arc cosine and
  a cotangent's denominator lose the same.
- Heron's formula, by which libigl gets areas in cotmatrix and massmatrix, subtracts *rounded* lengths whose difference
  is height^2 / length: a relative error of eps kappa^2.
"""

import numpy as np

import reference
from reference import STEP, STEPS, Edges, corner_cotangents, corner_edges, edge_weights, scatter

REL = 1e-12
EPS = np.finfo(float).eps
# Operations in the longest chain that a bound summarises.
CHAIN = 8

EXACT = {
    "vertices",
    "faces",
    "rings",
    "boundary_vertices",
    "boundary_edges",
    "non_manifold_edges",
    "non_manifold_vertices",
}


def tolerances(positions, faces, by_lengths=False):
    """For each quantity a number or an array that broadcasts against it; `by_lengths` allows for Heron's formula."""
    n, edges = len(positions), Edges(faces, len(positions))
    u, v = corner_edges(positions, faces)
    cross = np.cross(u, v)[:, 0]
    twice_area = np.linalg.norm(cross, axis=1)
    longest = (u**2).sum(axis=2).max(axis=1)
    # Without area there is a convention in place of a condition: the zero is exact.
    kappa = np.divide(longest, twice_area, out=np.zeros(len(faces)), where=twice_area > 0)
    rounding = CHAIN * EPS * kappa
    area_rounding = rounding * kappa if by_lengths else rounding
    magnitude = np.abs(positions).max()
    diagonal = np.linalg.norm(np.ptp(positions, axis=0))

    cotangents = np.abs(corner_cotangents(positions, faces))
    weight_bound = REL * (1 + cotangents) + rounding[:, None] + cotangents * area_rounding[:, None]
    weights = np.maximum(edge_weights(corner_cotangents(positions, faces), faces, edges, n), 0)
    weight_bounds = edge_weights(weight_bound, faces, edges, n)
    edge_length = np.linalg.norm(positions[edges.ends[:, 0]] - positions[edges.ends[:, 1]], axis=1)
    longest_at = np.zeros(n)
    np.maximum.at(longest_at, edges.ends, edge_length[:, None])
    sum_rounding = EPS * (edges.valence + 2) * magnitude
    smoothed = {k: t + REL * diagonal for k, t in propagated(np.ones(len(edges.i)), edges, sum_rounding).items()}
    # A weight off by t moves the mean by t / (sum of weights) of the longest edge, and again through that sum.
    total = scatter(edges.i, weights, n)
    loose = scatter(edges.i, weight_bounds, n)
    drift = np.divide(2 * loose * longest_at, total, out=np.zeros(n), where=total > 0)
    by_cotangent = propagated(weights, edges, sum_rounding + drift)
    area = twice_area.sum() / 2
    return {
        "face_normals": (REL + rounding)[:, None],
        "vertex_normals": vertex_normal_bounds(positions, faces, rounding),
        "uniform_laplacian": (REL * longest_at + sum_rounding)[:, None],
        "cotangent_laplacian": reference.laplacian(weight_bounds, edges, n),
        "mass": scatter(faces.ravel(), np.repeat(twice_area / 6 * (REL + area_rounding), 3), n),
        "smoothed_uniform": {k: t[:, None] for k, t in smoothed.items()},
        "smoothed_cotangent": {k: t[:, None] + REL * diagonal for k, t in by_cotangent.items()},
        "mean_edge": REL * edge_length.mean(),
        "area": REL * area + (twice_area * rounding).sum() / 2,
        # The centroid is a sum of n terms; where the surface is open the volume depends on it.
        "volume": area * (REL * diagonal + n * EPS * magnitude),
    }


def propagated(weights, edges, per_step):
    """Errors spread as positions do, one ring a step, and each step adds its own."""
    n = len(per_step)
    total = scatter(edges.i, weights, n)
    share = STEP * weights / np.where(total > 0, total, 1)[edges.i]
    states, bound = {}, np.zeros(n)
    for step in range(1, max(STEPS) + 1):
        bound = np.where(total > 0, (1 - STEP) * bound, bound) + scatter(edges.i, share * bound[edges.j], n) + per_step
        if step in STEPS:
            states[str(step)] = bound
    return states


def vertex_normal_bounds(positions, faces, rounding):
    """Errors of the summands over the length of the sum: where normals cancel, their errors do not."""
    u, v = corner_edges(positions, faces)
    face_normals, bounds = reference.unit(np.cross(u, v)[:, 0]), {}
    for name, weights in reference.corner_weights(positions, faces).items():
        summand = weights * (REL + 2 * rounding[:, None]) + (rounding[:, None] if name == "angle" else 0)
        error = scatter(faces.ravel(), summand.ravel(), len(positions))
        length = np.linalg.norm(reference.normal_sums(face_normals, weights, faces, len(positions)), axis=1)
        bounds[name] = np.divide(error, length, out=np.zeros_like(length), where=length > 0)[:, None]
    return bounds


def differences(actual, expected, bounds, name=""):
    """Sentences on where `actual` departs from `expected`; none if every name in `expected` agrees."""
    if isinstance(expected, dict):
        below = (differences(actual[k], expected[k], bounds.get(k), f"{name}{k} ") for k in expected)
        return [sentence for sentences in below for sentence in sentences]
    if name.strip() in EXACT:
        return [] if plain(actual) == plain(expected) else [f"{name}differ"]
    if name.strip() == "cotangent_laplacian":
        actual, expected, bounds = aligned(actual, expected, bounds)
        # The bounds have the sign of what they belong to: negative on the diagonal.
        bounds = np.abs(bounds)
    actual, expected = np.asarray(actual, dtype=np.longdouble), np.asarray(expected, dtype=np.longdouble)
    if actual.shape != expected.shape:
        return [f"{name}has shape {actual.shape}, not {expected.shape}"]
    # NaN compares false, so this form also finds what is not a number.
    wrong = ~(np.abs(actual - expected) <= bounds)
    if not wrong.any():
        return []
    with np.errstate(divide="ignore", invalid="ignore"):
        excess = np.abs(actual - expected) / bounds
    worst = np.unravel_index(np.nanargmax(np.where(wrong, excess, 0)), excess.shape)
    place = f"[{', '.join(map(str, worst))}]" if worst else ""
    found = f"{name}{place} is {actual[worst]}, not {expected[worst]}"
    return [f"{found}: {excess[worst]:.2g} times the bound; {wrong.sum()} wrong"]


def plain(value):
    """Nested lists of integers, for comparison without numpy's broadcasting."""
    if isinstance(value, (int, np.integer)):
        return int(value)
    return [plain(item) for item in value]


def aligned(*matrices):
    """The values of matrices given as rows [i, j, w], zeros filled in, in one order; what is listed twice is summed."""
    matrices = [np.asarray(matrix, dtype=np.longdouble) for matrix in matrices]
    places, row = np.unique(np.concatenate([m[:, :2] for m in matrices]), axis=0, return_inverse=True)
    rows = np.split(row.ravel(), np.cumsum([len(m) for m in matrices])[:-1])
    return [scatter(r, m[:, 2], len(places)) for r, m in zip(rows, matrices)]
