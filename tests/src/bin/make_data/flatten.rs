//! Flattens a disk with little stretch.
//!
//! Ligang Liu et al. A local/global approach to mesh parameterization. SGP 2008: as rigid as
//! possible, started from a projection, which is good enough for the patches that
//! [`segment`](crate::segment) makes.

use crate::chart::{Chart, signed_area};
use crate::mesh::{Mesh, area_vector, directed_edges};
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, BTreeSet};

const ROUNDS: usize = 40;
/// Worst ratio, or inverse ratio, of lengths in the flat chart to lengths on the surface.
const MAX_STRETCH: f64 = 1.9;

/// The flat chart of some faces; none if they are no disk or it would fold, overlap or stretch.
pub(crate) fn flatten(mesh: &Mesh, faces: &[usize], group: usize) -> Option<Chart> {
    let mut local_index = BTreeMap::new();
    for v in faces.iter().flat_map(|&f| mesh.triangles[f]) {
        local_index.insert(v, 0);
    }
    for (k, local) in local_index.values_mut().enumerate() {
        *local = k;
    }
    let vertices: Vec<usize> = local_index.keys().copied().collect();
    let triangles: Vec<_> = faces.iter().map(|&f| mesh.triangles[f].map(|v| local_index[&v])).collect();
    let rim = single_boundary(&triangles)?;
    if !is_disk(vertices.len(), triangles.len(), rim.len()) {
        return None;
    }
    let places: Vec<_> = vertices.iter().map(|&v| mesh.positions[v]).collect();
    let shapes: Vec<_> = triangles.iter().map(|t| unfold(t.map(|v| places[v]))).collect();
    let uvs = as_rigid_as_possible(&triangles, &shapes, project(&triangles, &places));
    let chart = Chart { group, vertices, uvs, triangles };
    // All triangles counter-clockwise inside a simple rim: by degree, each point is covered once.
    let is_low_stretch = chart.triangles.iter().zip(&shapes).all(|(&t, &shape)| {
        let flat = chart.corners(t);
        signed_area(flat) > 0.0 && stretch(shape, flat) < MAX_STRETCH
    });
    (is_low_stretch && is_simple_polygon(&chart.uvs, &rim)).then_some(chart)
}

/// The boundary of a triangle set as one loop of vertices, if it is one loop.
fn single_boundary(triangles: &[[usize; 3]]) -> Option<Vec<usize>> {
    let mut open = BTreeSet::new();
    for [a, b] in triangles.iter().flat_map(|&t| directed_edges(t)) {
        if !open.remove(&(b, a)) {
            open.insert((a, b));
        }
    }
    let count = open.len();
    let next: BTreeMap<usize, usize> = open.into_iter().collect();
    let (&start, _) = next.first_key_value()?;
    let mut rim = vec![start];
    let mut v = *next.get(&start)?;
    while v != start && rim.len() <= count {
        rim.push(v);
        v = *next.get(&v)?;
    }
    (rim.len() == count).then_some(rim)
}

/// Euler's formula with E = (3F + rim) / 2.
fn is_disk(vertices: usize, triangles: usize, rim: usize) -> bool {
    2 * vertices + 2 * triangles == 3 * triangles + rim + 2
}

/// Projection onto the plane across the mean normal.
fn project(triangles: &[[usize; 3]], places: &[DVec3]) -> Vec<DVec2> {
    let normal: DVec3 = triangles.iter().map(|t| area_vector(t.map(|v| places[v]))).sum();
    let (u, v) = normal.normalize_or(DVec3::Y).any_orthonormal_pair();
    places.iter().map(|p| DVec2::new(p.dot(u), p.dot(v))).collect()
}

/// A triangle laid into the plane, its first edge along u.
fn unfold([a, b, c]: [DVec3; 3]) -> [DVec2; 3] {
    let u = (b - a).normalize_or_zero();
    let along = (c - a).dot(u);
    [DVec2::ZERO, DVec2::new((b - a).length(), 0.0), DVec2::new(along, (c - a).reject_from(u).length())]
}

/// Cotangents of the angles facing edges 0→1, 1→2, 2→0, kept positive so that the system is
/// positive semi-definite.
fn cotangents([a, b, c]: [DVec2; 3]) -> [f64; 3] {
    let cotangent = |apex: DVec2, p: DVec2, q: DVec2| {
        let (p, q) = (p - apex, q - apex);
        (p.dot(q) / p.perp_dot(q)).max(1e-3)
    };
    [cotangent(c, a, b), cotangent(a, b, c), cotangent(b, c, a)]
}

fn as_rigid_as_possible(triangles: &[[usize; 3]], shapes: &[[DVec2; 3]], mut uvs: Vec<DVec2>) -> Vec<DVec2> {
    let weights: Vec<_> = shapes.iter().map(|&shape| cotangents(shape)).collect();
    for _ in 0..ROUNDS {
        let mut target = vec![DVec2::ZERO; uvs.len()];
        for ((triangle, shape), weights) in triangles.iter().zip(shapes).zip(&weights) {
            // Equation (6): the rotation, as a unit complex number, that fits the triangle best.
            let edges = [0, 1, 2].map(|k| shape[(k + 1) % 3] - shape[k]);
            let mut rotation = DVec2::ZERO;
            for k in 0..3 {
                let flat = uvs[triangle[(k + 1) % 3]] - uvs[triangle[k]];
                rotation += weights[k] * DVec2::new(edges[k].dot(flat), edges[k].perp_dot(flat));
            }
            let rotation = rotation.normalize_or(DVec2::X);
            for k in 0..3 {
                let pull = weights[k] * rotation.rotate(edges[k]);
                target[triangle[k]] -= pull;
                target[triangle[(k + 1) % 3]] += pull;
            }
        }
        solve_laplacian(triangles, &weights, &target, &mut uvs);
    }
    uvs
}

/// Improves `x` towards L x = `b`, L the cotangent Laplacian, by conjugate gradients. The two
/// coordinates share the steps: L acts on both alike.
fn solve_laplacian(triangles: &[[usize; 3]], weights: &[[f64; 3]], b: &[DVec2], x: &mut [DVec2]) {
    let laplacian = |x: &[DVec2]| {
        let mut lx = vec![DVec2::ZERO; x.len()];
        for (triangle, weights) in triangles.iter().zip(weights) {
            for k in 0..3 {
                let (i, j) = (triangle[k], triangle[(k + 1) % 3]);
                let pull = weights[k] * (x[i] - x[j]);
                lx[i] += pull;
                lx[j] -= pull;
            }
        }
        lx
    };
    let dot = |p: &[DVec2], q: &[DVec2]| p.iter().zip(q).map(|(p, q)| p.dot(*q)).sum::<f64>();
    let mut residual: Vec<_> = b.iter().zip(laplacian(x)).map(|(b, lx)| *b - lx).collect();
    let mut direction = residual.clone();
    let mut error = dot(&residual, &residual);
    let goal = 1e-12 * dot(b, b);
    for _ in 0..x.len() {
        if error <= goal {
            break;
        }
        let image = laplacian(&direction);
        let step = error / dot(&direction, &image);
        for i in 0..x.len() {
            x[i] += step * direction[i];
            residual[i] -= step * image[i];
        }
        let previous = std::mem::replace(&mut error, dot(&residual, &residual));
        for (direction, residual) in direction.iter_mut().zip(&residual) {
            *direction = *residual + error / previous * *direction;
        }
    }
}

/// Largest of σ₁ and 1/σ₂, the singular values of the map from `shape` to `flat`.
fn stretch(shape: [DVec2; 3], flat: [DVec2; 3]) -> f64 {
    let (s, t) = (shape[1].x, shape[2]);
    let du = (flat[1] - flat[0]) / s;
    let dv = (flat[2] - flat[0] - du * t.x) / t.y;
    let (sum, product) = (du.length_squared() + dv.length_squared(), du.perp_dot(dv));
    let root = (sum * sum - 4.0 * product * product).max(0.0).sqrt();
    let [large, small] = [0.5 * (sum + root), 0.5 * (sum - root)].map(|x| x.max(0.0).sqrt());
    large.max(1.0 / small)
}

fn is_simple_polygon(uvs: &[DVec2], rim: &[usize]) -> bool {
    let n = rim.len();
    let side = |i: usize| [uvs[rim[i]], uvs[rim[(i + 1) % n]]];
    (0..n).all(|i| {
        let beyond = (i + 2)..(if i == 0 { n - 1 } else { n });
        beyond.into_iter().all(|j| !segments_meet(side(i), side(j)))
    })
}

fn segments_meet([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let turn = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    turn(a, b, c) * turn(a, b, d) <= 0.0 && turn(c, d, a) * turn(c, d, b) <= 0.0
}
