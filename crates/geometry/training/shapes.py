"""Writes clean training shapes of our own: smooth coarse solids, pleats and ribs, tubes, blobs and terrain, as OBJ.

    python crates/geometry/training/shapes.py FOLDER --count 120

The same count gives the same files. Needs numpy.
"""

import argparse
from pathlib import Path

import numpy as np


def icosphere(subdivisions):
    """Unit sphere (#V×3) and its triangles (#T×3)."""
    t = (1 + 5**0.5) / 2
    points = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t), (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8)]
    faces += [(3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    points, faces = np.array(points, float), np.array(faces)
    for _ in range(subdivisions):
        edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        edges, places = np.unique(edges, axis=0, return_inverse=True)
        a, b, c = (places.reshape(-1).reshape(3, -1) + len(points))
        points = np.concatenate([points, points[edges].mean(1)])
        x, y, z = faces.T
        faces = np.concatenate([np.stack(k, 1) for k in [(x, a, c), (y, b, a), (z, c, b), (a, b, c)]])
    return points / np.linalg.norm(points, axis=1, keepdims=True), faces


def grid(rows, columns, closed, random):
    """Parameters (#V×2, in 0..1) and triangles of a grid; the columns close up if `closed`. Diagonals go one way, or either."""
    u = np.arange(columns) / (columns if closed else columns - 1)
    v = np.arange(rows) / (rows - 1)
    parameters = np.stack(np.meshgrid(u, v), -1).reshape(-1, 2)
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns if closed else columns - 1), indexing="ij")
    i, j = i.ravel(), j.ravel()
    a, b = i * columns + j, i * columns + (j + 1) % columns
    c, d = b + columns, a + columns
    one = np.stack([a, b, c, a, c, d], 1).reshape(-1, 2, 3)
    other = np.stack([a, b, d, b, c, d], 1).reshape(-1, 2, 3)
    if random.random() < 0.5:
        which = np.zeros(len(a), bool)
    else:
        which = random.random(len(a)) < 0.5
    faces = np.where(which[:, None, None], other, one).reshape(-1, 3)
    amount = random.choice([0.0, 0.15, 0.3])
    inner = ((parameters[:, 1] > 0) & (parameters[:, 1] < 1))[:, None]
    step = np.array([1 / columns, 1 / rows])
    parameters = parameters + inner * amount * step * random.uniform(-1, 1, parameters.shape) * [1, 1]
    if not closed:
        edge = (parameters[:, 0] < 0.5 / columns) | (parameters[:, 0] > 1 - 0.5 / columns)
        parameters[edge, 0] = np.round(parameters[edge, 0])
    return parameters, faces


def waves(x, count, octave, random):
    """Sum of random sines of points, about one in size; each octave is `octave` times as strong as the one before."""
    total = np.zeros(len(x))
    for k in range(count):
        direction = random.normal(size=x.shape[1])
        total += octave**k * np.sin(2**k * (x @ direction) * 2 + random.uniform(0, 7))
    return total / (octave ** np.arange(count)).sum()


def superquadric(random):
    """Rounded boxes, ellipsoids, spheres, double cones."""
    points, faces = icosphere(random.integers(2, 5))
    if random.random() < 0.6:
        # Uneven triangles on the same sphere.
        points = points + random.normal(0, 0.12, points.shape) * np.sqrt(4 * np.pi / len(points))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    power = random.choice([2.0, 2.0, random.uniform(1.1, 8.0)])
    radius = (np.abs(points) ** power).sum(1) ** (-1 / power)
    return points * radius[:, None] * np.exp(random.uniform(-0.7, 0.7, 3)), faces


def blob(random):
    """Spheres with bumps of some octaves."""
    points, faces = icosphere(random.integers(3, 5))
    points = points + random.normal(0, 0.1, points.shape) * np.sqrt(4 * np.pi / len(points))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    height = random.uniform(0.1, 0.5) * waves(points, random.integers(1, 5), random.uniform(0.3, 0.6), random)
    return points * (1 + height)[:, None] * np.exp(random.uniform(-0.5, 0.5, 3)), faces


def turned(random):
    """Vessels and shades: a profile around an axis, round, or with ribs or pleats that may wind."""
    columns, rows = random.integers(24, 120), random.integers(12, 60)
    parameters, faces = grid(rows, columns, True, random)
    angle, height = 2 * np.pi * parameters[:, 0], parameters[:, 1]
    radius = 1 + 0.4 * waves(height[:, None] * 3, 2, 0.4, random)
    ribs = random.integers(3, max(4, columns // 6)) if random.random() < 0.7 else 0
    depth, winding = random.uniform(0.02, 0.2), random.choice([0.0, random.uniform(-3, 3)])
    wave = np.cos(ribs * angle + winding * height)
    if random.random() < 0.3:
        wave = 2 / np.pi * np.arcsin(wave)
    radius = radius * (1 + (depth * min(1, 8 / max(ribs, 1)) * wave if ribs else 0))
    length = random.uniform(0.7, 3)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), length * height], 1), faces


def tube(random):
    """Closed tubes around a winding line, round or flat, even or with swellings."""
    columns, rows = random.integers(8, 28), random.integers(60, 160)
    parameters, faces = grid(rows + 1, columns, True, random)
    # The last row is the first one.
    faces = np.where(faces >= rows * columns, faces - rows * columns, faces)
    parameters = parameters[: rows * columns]
    angle, along = 2 * np.pi * parameters[:, 0], 2 * np.pi * parameters[:, 1]
    p, q = random.integers(1, 4), random.integers(0, 4)

    def line(t):
        ring = 2 + random_bend * np.cos(q * t)
        return np.stack([ring * np.cos(p * t), ring * np.sin(p * t), random_bend * np.sin(q * t)], 1)

    random_bend = random.uniform(0.2, 0.8)
    centre, ahead = line(along), line(along + 1e-3) - line(along - 1e-3)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.cross(ahead, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, ahead)
    size = random.uniform(0.1, 0.3) * (1 + 0.3 * np.sin(random.integers(0, 12) * along))
    flat = random.uniform(0.5, 1.0)
    return centre + side * (size * np.cos(angle))[:, None] + up * (flat * size * np.sin(angle))[:, None], faces


def terrain(random):
    """Height fields: hills, ripples, folded sheets."""
    columns, rows = random.integers(30, 75), random.integers(30, 75)
    parameters, faces = grid(rows, columns, False, random)
    plane = parameters * [columns, rows] / max(columns, rows) * 4
    height = waves(plane, random.integers(1, 6), random.uniform(0.3, 0.65), random)
    style = random.integers(3)
    if style == 1:
        height = np.abs(height)
    if style == 2:
        height = 0.3 * height + 0.5 * np.sin(plane @ random.normal(size=2) * random.uniform(1, 5))
    return np.column_stack([plane, random.uniform(0.2, 1.2) * height]), faces


FAMILIES = [superquadric, blob, turned, tube, terrain]


def main():
    """Writes the shapes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=120)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for number in range(options.count):
        family = FAMILIES[number % len(FAMILIES)]
        points, faces = family(np.random.default_rng(number))
        lines = ["v %.6f %.6f %.6f" % tuple(p) for p in points] + ["f %d %d %d" % tuple(f) for f in faces + 1]
        (options.folder / f"own_{family.__name__}_{number:03}.obj").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
