"""The same quantities from libigl and from trimesh, brought to planish's conventions.

Each returns a dictionary with the names of `reference.quantities`, without those the library cannot give. Where a
library means something else by a word, the translation stands here with its reason; README.md lists them all.
"""

import igl
import numpy as np
import trimesh
from scipy.sparse import csc_matrix, diags

import reference
from reference import STEP, STEPS


def sorted_edges(edges):
    """Each a < b, in order."""
    edges = np.sort(np.asarray(edges, dtype=np.int64).reshape(-1, 2), axis=1)
    return edges[np.lexsort(edges.T[::-1])]


def enlarged(matrix, n):
    """libigl sizes what it makes from faces alone by the highest index in them; trailing vertices get empty rows."""
    matrix = csc_matrix(matrix, dtype=float)
    matrix.resize((n, n))
    return matrix


def smoothed(positions, weights, fixed):
    """scipy's matrix products take the place of the smoothing that libigl leaves to its user."""
    total = np.asarray(weights.sum(axis=1)).ravel()
    moves = (total > 0) & ~fixed
    step = STEP * diags(moves / np.where(total > 0, total, 1)) @ (weights - diags(total))
    states, result = {}, positions
    for count in range(1, max(STEPS) + 1):
        result = result + step @ result
        if count in STEPS:
            states[str(count)] = result
    return states


def from_igl(positions, faces):
    n = len(positions)
    adjacency = enlarged(igl.adjacency_matrix(faces), n)
    isolated = adjacency.getnnz(axis=1) == 0
    boundary = sorted_edges(igl.boundary_facets(faces)[0])
    fixed = np.isin(np.arange(n), boundary)
    _, _, edges, _, is_manifold = igl.is_edge_manifold(faces)
    non_manifold = sorted_edges(edges[~is_manifold])
    one_fan = np.concatenate([igl.is_vertex_manifold(faces), np.zeros(n, dtype=bool)])[:n]
    solid = has_area(positions, faces)
    # Without the third argument the normal of a face without area is whatever the memory held.
    face_normals = igl.per_face_normals(positions, faces, np.zeros(3))
    weighting = {
        "uniform": igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_UNIFORM,
        "area": igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_AREA,
        "angle": igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_ANGLE,
    }
    normals = {k: igl.per_vertex_normals(positions, faces, w, face_normals) for k, w in weighting.items()}
    for normal in normals.values():
        # 0/0 where no face at the vertex has an area.
        normal[~np.isin(np.arange(n), faces[solid])] = 0
    valence = np.asarray(adjacency.sum(axis=1))
    # cotmatrix gives infinities and NaN for faces without area; planish leaves such faces out.
    cotangent = igl.cotmatrix(positions, faces[solid])
    entries = cotangent.tocoo()
    off_diagonal = cotangent - diags(cotangent.diagonal())
    centred = positions - positions[np.unique(faces)].mean(axis=0)
    return {
        "rings": [np.sort(ring) for ring in igl.adjacency_list(faces)] + [[]] * (n - faces.max() - 1),
        "boundary_vertices": np.unique(boundary),
        "boundary_edges": boundary,
        "non_manifold_edges": non_manifold,
        # libigl asks for exactly one fan, whatever its edges; planish also lists the ends of non-manifold edges and
        # has nothing against a vertex without faces.
        "non_manifold_vertices": np.union1d(np.flatnonzero(~one_fan & ~isolated), non_manifold),
        "face_normals": face_normals,
        "vertex_normals": normals,
        "uniform_laplacian": (adjacency @ positions / np.maximum(valence, 1) - positions) * ~isolated[:, None],
        "cotangent_laplacian": np.stack([entries.row, entries.col, entries.data], axis=1),
        "mass": enlarged(igl.massmatrix(positions, faces, igl.MASSMATRIX_TYPE_BARYCENTRIC), n).diagonal(),
        "smoothed_uniform": smoothed(positions, adjacency, fixed),
        "smoothed_cotangent": smoothed(positions, off_diagonal.maximum(0), fixed),
        "mean_edge": igl.avg_edge_length(positions, faces),
        "area": igl.doublearea(positions, faces).sum() / 2,
        "volume": igl.centroid(centred, faces)[1],
    }


def has_area(positions, faces):
    a, b, c = np.moveaxis(positions[faces], 1, 0)
    return np.cross(b - a, c - a).any(axis=1)


def from_trimesh(positions, faces):
    n = len(positions)
    mesh = trimesh.Trimesh(positions, faces, process=False)
    edges, uses = np.unique(mesh.edges_sorted, axis=0, return_counts=True)
    boundary, non_manifold = edges[uses == 1], edges[uses > 2]
    result = {
        "rings": [np.sort(ring) for ring in mesh.vertex_neighbors],
        "boundary_vertices": np.unique(boundary),
        "boundary_edges": boundary,
        "non_manifold_edges": non_manifold,
        "face_normals": mesh.face_normals,
        "vertex_normals": {"angle": mesh.vertex_normals},
        "mass": mesh.faces_sparse @ mesh.area_faces / 3,
        "mean_edge": mesh.edges_unique_length.mean(),
        "area": mesh.area,
    }
    # The flux of (x, 0, 0), which is a volume only where the surface is closed.
    if mesh.is_volume:
        # About the centroid, as moments about the origin lose digits far from it.
        result["volume"] = trimesh.Trimesh(positions - positions[np.unique(faces)].mean(axis=0), faces, process=False).volume
    # Its Laplacian walks each face's edges in one direction, so that a neighbour is seen twice, or from one side
    # only, unless every edge away from the boundary has two faces that walk it in opposite directions.
    if mesh.is_winding_consistent and not len(non_manifold) and len(np.unique(faces)) == n:
        result["smoothed_uniform"] = {}
        operator = trimesh.smoothing.laplacian_calculation(mesh, pinned_vertices=np.unique(boundary))
        for count in STEPS:
            moved = mesh.copy()
            trimesh.smoothing.filter_laplacian(moved, STEP, count, volume_constraint=False, laplacian_operator=operator)
            result["smoothed_uniform"][str(count)] = np.asarray(moved.vertices)
    return result


PEERS = {"numpy": reference.quantities, "igl": from_igl, "trimesh": from_trimesh}
