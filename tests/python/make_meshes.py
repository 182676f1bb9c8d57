#!/usr/bin/env python3
"""Makes the meshes of tests/reference: small, each with one thing that geometry code gets wrong.

The committed files are what counts; a test holds them to this script up to the last digits, in which trigonometric
functions differ between platforms.
"""

from pathlib import Path

import numpy as np
import trimesh

import obj

REFERENCE = Path(__file__).resolve().parents[1] / "reference"


def grid(columns, rows):
    """Unit grid in the plane z = 0 whose diagonals alternate, so that valences differ."""
    x, y = np.meshgrid(np.arange(columns, dtype=float), np.arange(rows, dtype=float))
    positions = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    faces = []
    for j in range(rows - 1):
        for i in range(columns - 1):
            a = j * columns + i
            b, c, d = a + 1, a + 1 + columns, a + columns
            faces += [(a, b, c), (a, c, d)] if (i + j) % 2 == 0 else [(a, b, d), (b, c, d)]
    return positions, np.array(faces)


def sphere(subdivisions):
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    return np.array(mesh.vertices), np.array(mesh.faces)


def joined(*parts):
    """The parts as one mesh; positions that are equal become one vertex, in order of first use."""
    offsets = np.cumsum([0] + [len(positions) for positions, _ in parts])
    positions = np.concatenate([positions for positions, _ in parts])
    faces = np.concatenate([faces + offset for (_, faces), offset in zip(parts, offsets)])
    _, first, group = np.unique(positions, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return positions[first[order]], rank[group.ravel()][faces]


def dented_sphere(rng):
    """icosphere with two bumps, a dent and noise"""
    positions, faces = sphere(2)
    radius = np.ones(len(positions))
    for centre, height in ([(0, 0, 1), 0.3], [(1, 0, 0), 0.2], [(0, -1, 0), -0.25]):
        radius += height * np.exp(-8 * ((positions - centre) ** 2).sum(axis=1))
    return positions * radius[:, None] + rng.normal(0, 0.02, positions.shape), faces


def noisy_grid(rng):
    """open grid with noise in every direction"""
    positions, faces = grid(12, 11)
    return positions + rng.normal(0, 0.12, positions.shape), faces


def saddle_with_hole(rng):
    """saddle with two boundary loops"""
    positions, faces = grid(13, 13)
    positions = (positions - [6, 6, 0]) / 6
    faces = faces[np.linalg.norm(positions[faces].mean(axis=1), axis=1) > 0.35]
    used, faces = np.unique(faces, return_inverse=True)
    positions = positions[used] + rng.normal(0, 0.01, (len(used), 3))
    positions[:, 2] += 0.5 * (positions[:, 0] ** 2 - positions[:, 1] ** 2)
    return positions, faces.reshape(-1, 3)


def torus(rng):
    """noisy torus, genus 1"""
    around, across = 16, 9
    i, j = np.divmod(np.arange(around * across), across)
    u, v = 2 * np.pi * i / around, 2 * np.pi * j / across
    ring = 2 + 0.7 * np.cos(v)
    positions = np.stack([ring * np.cos(u), ring * np.sin(u), 0.7 * np.sin(v)], axis=1)
    right, up = (i + 1) % around * across, (j + 1) % across
    a, b, c, d = i * across + j, right + j, right + up, i * across + up
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return positions + rng.normal(0, 0.03, positions.shape), faces


def cube(_):
    """subdivided cube: sharp edges, right angles (zero cotangents), coordinates without rounding"""
    flat, faces = grid(5, 5)
    x, y, one = flat[:, 0] / 4, flat[:, 1] / 4, np.ones(25)
    sides = []
    for axis in range(3):
        top = np.roll(np.stack([x, y, one], axis=1), axis, axis=1)
        bottom = np.roll(np.stack([x, y, one - 1], axis=1), axis, axis=1)
        sides += [(top, faces), (bottom, faces[:, ::-1])]
    return joined(*sides)


def three_sheets(rng):
    """three sheets that meet in one edge path: edges with three faces"""
    flat, faces = grid(6, 5)
    sheets = []
    for angle in (0.0, 1.9, 3.9):
        noisy = flat + rng.normal(0, 0.08, flat.shape) * (flat[:, 1:2] > 0)
        x, y, z = noisy.T
        turned = np.stack([x, np.cos(angle) * y - np.sin(angle) * z, np.sin(angle) * y + np.cos(angle) * z], axis=1)
        sheets.append((np.where(flat[:, 1:2] > 0, turned, flat), faces))
    return joined(*sheets)


def bow_tie(rng):
    """two closed fans that share their apex and nothing else: a non-manifold vertex on manifold edges"""

    def cone(sides, direction):
        turn = 2 * np.pi * np.arange(sides) / sides
        circle = np.stack([np.cos(turn), np.sin(turn), np.full(sides, 0.8)], axis=1)
        rings = [circle * scale + rng.normal(0, 0.03, circle.shape) for scale in (1.0, 2.0)]
        a, b = 1 + np.arange(sides), 1 + (np.arange(sides) + 1) % sides
        faces = [(0 * a, a, b), (a, a + sides, b + sides), (a, b + sides, b)]
        positions = np.concatenate([np.zeros((1, 3)), *rings])
        return np.roll(positions, direction, axis=1), np.concatenate([np.stack(f, axis=1) for f in faces])

    return joined(cone(6, 0), cone(5, 1))


def isolated_vertices(rng):
    """vertices without faces: the first, one in the middle, the last"""
    positions, faces = grid(7, 6)
    positions = positions + rng.normal(0, 0.1, positions.shape)
    lone = [[9.5, -3.25, 1.5], [2.5, 2.5, 4.0], [-1.75, 8.0, 0.5]]
    positions = np.concatenate([lone[:1], positions[:20], lone[1:2], positions[20:], lone[2:]])
    return positions, faces + 1 + (faces >= 20)


def far_from_origin(rng):
    """patch in map coordinates, metres"""
    positions, faces = grid(10, 10)
    positions = positions * 0.1 + rng.normal(0, 0.012, positions.shape)
    return positions + [500000.123, 4500000.456, 250.789], faces


def slivers(rng):
    """flattened and sheared grid: obtuse angles, negative cotangents, aspect ratios up to about a hundred"""
    positions, faces = grid(11, 11)
    positions = positions + rng.normal(0, 0.1, positions.shape)
    shear = np.array([[1, 0.7, 0.3], [0, 0.06, 0], [0, 0, 0.05]])
    return positions @ shear.T, faces


def two_scales(rng):
    """two components a thousandfold apart in size"""
    large, faces = sphere(2)
    small, small_faces = sphere(1)
    large = large + rng.normal(0, 0.02, large.shape)
    small = (small + rng.normal(0, 0.04, small.shape)) * 1e-3 + [3, 1, -0.5]
    return joined((large, faces), (small, small_faces))


def flipped_face(rng):
    """closed surface with one face turned inside out"""
    positions, faces = sphere(1)
    faces[17] = faces[17][::-1]
    return positions + rng.normal(0, 0.03, positions.shape), faces


def degenerate_face(_):
    """T-junction closed by a face of area exactly zero, as decimators leave them"""
    positions = np.array([[0, 0, 0], [2, 0, 0], [1, 0, 0], [1, 2, 0.5], [1.25, -2, 0.25]])
    return positions, np.array([[0, 1, 3], [1, 0, 2], [0, 4, 2], [2, 4, 1]])


MESHES = [
    dented_sphere, noisy_grid, saddle_with_hole, torus, cube, three_sheets, bow_tie, isolated_vertices,
    far_from_origin, slivers, two_scales, flipped_face, degenerate_face,
]  # fmt: skip


def make(function):
    """Positions and faces; every mesh has a seed of its own, so that adding one changes no other."""
    return function(np.random.default_rng(sum(function.__name__.encode())))


if __name__ == "__main__":
    for function in MESHES:
        obj.write_triangles(REFERENCE / f"{function.__name__}.obj", function.__doc__, *make(function))
