"""Writes clean training shapes with relief: scales, knurls, bricks, cells, weaves, ridges, pleats, pits, studs, rock, hair, hammered metal,
wood.

    python crates/geometry/training/reliefs.py FOLDER --count 208

Fine relief is what noise is most easily taken for. A wave of it is 3 to 10 edges long, and it is on all of the shape or fades out. Meshes
are grids, remeshed evenly, or decimated. The same seeds give the same files. Needs numpy, scipy and pymeshlab.
"""

import argparse
from pathlib import Path

import numpy as np
import pymeshlab
from scipy.spatial import cKDTree


def fraction(x):
    return x - np.floor(x)


def triangle_wave(x):
    """0 in the middle between whole numbers, 1 at them."""
    return 2 * np.abs(fraction(x) - 0.5)


def centres(places, jitter, random):
    """Points of a honeycomb of width 1 that covers the places (#P×2), moved by up to half the jitter."""
    count = int(places.max()) + 2
    i, j = np.meshgrid(np.arange(-2, count + 3), np.arange(-2, int(count / 0.866) + 5))
    points = np.stack([i + 0.5 * (j % 2), j * 0.866], -1).reshape(-1, 2).astype(float)
    return points + jitter * random.uniform(-0.5, 0.5, points.shape)


def value_noise(places, random):
    """Smooth random heights with knots at whole numbers."""
    count = 257
    knots = random.normal(size=(count, count))
    i = np.floor(places).astype(int)
    f = places - i
    f = f * f * (3 - 2 * f)
    at = lambda a, b: knots[(i[:, 0] + a) % count, (i[:, 1] + b) % count]
    rows = [at(0, b) * (1 - f[:, 0]) + at(1, b) * f[:, 0] for b in (0, 1)]
    return rows[0] * (1 - f[:, 1]) + rows[1] * f[:, 1]


# Reliefs: heights, about one in size, at places (#P×2) in lengths of a wave.


def scales(places, random):
    middle = centres(places, 0, random)
    distance, which = cKDTree(middle).query(places, 7)
    radius = random.uniform(0.75, 1.0)
    along = (places[:, None] - middle[which])[..., 1]
    return np.maximum(np.where(distance < radius, 0.5 - 0.6 * along / radius, -1).max(1), -0.5)


def knurl(places, random):
    a, b = triangle_wave(places[:, 0] + places[:, 1]), triangle_wave(places[:, 0] - places[:, 1])
    return np.minimum(a, b) if random.random() < 0.5 else a * b


def bricks(places, random):
    joint, row = random.uniform(0.06, 0.2), np.floor(places[:, 1])
    along = places[:, 0] / 2 + 0.5 * (row % 2)
    u, v = fraction(along), fraction(places[:, 1])
    inside = np.minimum(np.minimum(u, 1 - u) * 2, np.minimum(v, 1 - v))
    own = random.normal(size=500)[(row * 37 + np.floor(along) * 11).astype(int) % 500]
    return np.clip(inside / joint, 0, 1) * (1 + 0.3 * own)


def cells(places, random):
    first, second = cKDTree(centres(places, random.uniform(0.2, 1.2), random)).query(places, 2)[0].T
    style = random.integers(4)
    if style == 0:
        return 1 - first**2
    if style == 1:
        return np.sqrt(np.maximum(0, 1 - first**2))
    return np.minimum(1, 3 * (second - first)) if style == 2 else -2 * np.maximum(0, 0.4 - first)


def weave(places, random):
    a, b = np.sin(np.pi * places).T
    over, under = np.abs(a), np.abs(b)
    return np.where(a * b > 0, over * (0.6 + 0.4 * under), under * (0.6 + 0.4 * over))


def ridges(places, random, angle=None):
    angle = random.uniform(0, np.pi) if angle is None else angle
    t = places @ np.array([np.cos(angle), np.sin(angle)])
    return [np.abs(np.sin(np.pi * t)), fraction(t), 0.5 + 0.5 * np.sin(2 * np.pi * t), triangle_wave(t)][random.integers(4)]


def pleats(places, random):
    """Ridges along the rows, the columns or the diagonals of a grid."""
    return ridges(places, random, np.pi / 4 * random.integers(4))


def pits(places, random):
    distance, radius = cKDTree(centres(places, 0, random)).query(places)[0], random.uniform(0.25, 0.48)
    return -2 * np.sqrt(np.maximum(0, radius**2 - distance**2))


def studs(places, random):
    distance = cKDTree(centres(places, random.uniform(0, 0.3), random)).query(places)[0] / random.uniform(0.25, 0.48)
    cones, discs, domes = np.maximum(0, 1 - distance), (distance < 1).astype(float), np.sqrt(np.maximum(0, 1 - distance**2))
    return [cones, discs, domes][random.integers(3)]


def rock(places, random):
    smoothness, is_ridged = random.uniform(0.4, 1.1), random.random() < 0.4
    total = np.zeros(len(places))
    for k in range(6):
        octave = value_noise(0.35 * places * 2**k + 7 * k, random)
        total += 2 ** (-smoothness * k) * (1 - np.abs(octave) if is_ridged else octave)
    return 0.5 * total


def hair(places, random):
    bend = np.stack([value_noise(0.3 * places, random) for _ in range(2)], 1) * random.uniform(0.3, 1.2)
    strands = (places + bend) * [1, 0.15]
    return 0.5 * value_noise(strands, random) + 0.5 * np.abs(np.sin(np.pi * strands[:, 0]))


def hammered(places, random):
    return 0.7 * value_noise(0.8 * places, random)


def wood(places, random):
    return fraction(0.7 * places[:, 0] + 0.6 * value_noise(0.25 * places, random))


RELIEFS = [scales, knurl, bricks, cells, weave, ridges, pleats, pits, studs, rock, hair, hammered, wood]


# Shapes: points and normals at parameters in 0..1.


def torus(u, v):
    around, across = 2 * np.pi * u, 2 * np.pi * v
    normals = np.stack([np.cos(across) * np.cos(around), np.cos(across) * np.sin(around), np.sin(across)], 1)
    return np.stack([np.cos(around), np.sin(around), 0 * around], 1) + 0.4 * normals, normals


def vase(u, v):
    around, radius = 2 * np.pi * u, 1 + 0.3 * np.sin(3 * v)
    normals = np.stack([np.cos(around), np.sin(around), 0 * around], 1)
    return normals * radius[:, None] + np.stack([0 * v, 0 * v, 3 * v], 1), normals


def sheet(u, v):
    return np.stack([3 * u, 3 * v, 0.3 * np.sin(3 * u) * np.cos(4 * v)], 1), np.stack([0 * u, 0 * u, 1 + 0 * u], 1)


def ball(u, v):
    around, down = 2 * np.pi * u, np.pi * (0.08 + 0.84 * v)
    normals = np.stack([np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)], 1)
    return normals, normals


# Each with its two lengths, and whether the first and the second parameter close up.
SHAPES = [(torus, 2 * np.pi, 2.5, True, True), (vase, 2 * np.pi, 3.0, True, False), (sheet, 3.0, 3.0, False, False), (ball, 2 * np.pi, 2.6, True, False)]


def grid_faces(columns, rows, closes_u=False, closes_v=False):
    """Triangles (#T×3) of a grid whose vertices are numbered row by row."""
    i, j = np.meshgrid(np.arange(columns - (not closes_u)), np.arange(rows - (not closes_v)))
    i, j = i.ravel(), j.ravel()
    at = lambda a, b: (b % rows) * columns + a % columns
    a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def area(points, faces):
    a, b, c = (points[faces[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def shape(number):
    """Name, points (#V×3) and triangles (#T×3) of a shape."""
    random = np.random.default_rng(number)
    relief = RELIEFS[number % len(RELIEFS)]
    surface, length, width, closes_u, closes_v = SHAPES[random.integers(len(SHAPES))]
    waves = int(np.exp(random.uniform(np.log(6), np.log(40))))
    columns = min(900, max(300, 16 * waves))
    rows = int(columns * width / length)
    u, v = np.meshgrid(np.arange(columns) / (columns - (not closes_u)), np.arange(rows) / (rows - (not closes_v)))
    u, v = u.ravel(), v.ravel()
    height = relief(np.stack([u * waves, v * np.round(waves * width / length)], 1), random)
    wave = length / waves
    # Cloth and sheet metal are folded deeper than other surfaces are carved.
    deepest = 0.8 if relief is pleats else 0.4
    height = (height - np.median(height)) * wave * np.exp(random.uniform(np.log(0.04), np.log(deepest)))
    if random.integers(3) == 0:
        height = height / (1 + np.exp(-8 * (np.sin(2 * np.pi * u) + 0.2)))
    points, normals = surface(u, v)
    points, faces = points + normals * height[:, None], grid_faces(columns, rows, closes_u, closes_v)
    edge = wave / np.exp(random.uniform(np.log(3), np.log(10)))
    whole = area(points, faces)
    # An even triangle has the area √3/4 of its edge squared.
    count = int(np.clip(whole / (0.433 * edge**2), 3000, 24000))
    # The rows of any other mesh do not run along the pleats.
    meshing = "grid" if relief is pleats else ["iso", "dec", "grid"][random.integers(3)]
    if meshing == "grid":
        step = max(1, round(np.sqrt(len(faces) / count)))
        columns_left, rows_left = columns // step, rows // step
        kept = (np.arange(rows_left)[:, None] * step * columns + np.arange(columns_left) * step).ravel()
        points, faces = points[kept], grid_faces(columns_left, rows_left)
    else:
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(points, faces))
        if meshing == "iso":
            length = pymeshlab.PureValue(np.sqrt(whole / count / 0.433))
            meshes.meshing_isotropic_explicit_remeshing(targetlen=length, iterations=5, featuredeg=30)
        else:
            meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=count)
        points, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
    return f"relief_{relief.__name__}_{number:04}_{meshing}", points, faces


def main():
    """Writes the shapes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=208)
    parser.add_argument("--first", type=int, default=0, help="seed of the first shape")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for number in range(options.first, options.first + options.count):
        name, points, faces = shape(number)
        lines = ["v %.7f %.7f %.7f" % tuple(p) for p in points] + ["f %d %d %d" % tuple(f) for f in faces + 1]
        (options.folder / f"{name}.obj").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
