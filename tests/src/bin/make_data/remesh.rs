//! Isotropic remeshing of a signed distance field's zero set.
//!
//! Mario Botsch, Leif Kobbelt. A remeshing approach to multiresolution modeling. SGP 2004.
//! Marion Dunyach et al. Adaptive remeshing for real-time mesh deformation. Eurographics 2013:
//! edge lengths follow the curvature, so that small features get the vertices that they need.

use crate::editable::EditableMesh;
use crate::mesh::area_vector;
use crate::sdf;
use glam::DVec3;

/// What edge lengths to aim at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizing {
    pub(crate) min_edge: f64,
    pub(crate) max_edge: f64,
    /// Allowed distance between an edge's middle and the surface.
    pub(crate) chord_error: f64,
    /// Growth of the aimed length per unit of distance.
    pub(crate) grading: f64,
}

/// Rounds of split, collapse, flip and relax; the valences settle well before.
const ROUNDS: usize = 14;

pub(crate) fn remesh(mesh: &mut EditableMesh, field: &impl Fn(DVec3) -> f64, sizing: &Sizing) {
    for _ in 0..ROUNDS {
        let mut target = target_lengths(mesh, field, sizing);
        split_long_edges(mesh, &mut target);
        collapse_short_edges(mesh, &target);
        equalise_valences(mesh);
        for v in mesh.vertices() {
            let relaxed = sdf::project(field, tangential_centroid(mesh, field, v), target[v]);
            move_unless_folding(mesh, v, relaxed);
        }
    }
}

/// Aimed edge length at each vertex. Equation (2) of Dunyach et al., then graded.
fn target_lengths(mesh: &EditableMesh, field: &impl Fn(DVec3) -> f64, sizing: &Sizing) -> Vec<f64> {
    let e = sizing.chord_error;
    let length_at = |v: usize| {
        let curvature = sdf::max_curvature(field, mesh.positions[v], 0.5 * sizing.min_edge);
        let squared = 6.0 * e / curvature.max(1e-9) - 3.0 * e * e;
        squared.max(0.0).sqrt().clamp(sizing.min_edge, sizing.max_edge)
    };
    let mut target = vec![sizing.max_edge; mesh.positions.len()];
    for v in mesh.vertices() {
        target[v] = length_at(v);
    }
    let edges = mesh.edges();
    for _ in 0..8 {
        for &[a, b] in &edges {
            let step = sizing.grading * mesh.positions[a].distance(mesh.positions[b]);
            target[a] = target[a].min(target[b] + step);
            target[b] = target[b].min(target[a] + step);
        }
    }
    target
}

fn split_long_edges(mesh: &mut EditableMesh, target: &mut Vec<f64>) {
    for [a, b] in mesh.edges() {
        let [p, q] = [mesh.positions[a], mesh.positions[b]];
        if p.distance(q) > 4.0 / 3.0 * target[a].min(target[b]) {
            mesh.split([a, b], p.midpoint(q));
            target.push(0.5 * (target[a] + target[b]));
        }
    }
}

fn collapse_short_edges(mesh: &mut EditableMesh, target: &[f64]) {
    for [a, b] in mesh.edges() {
        let [p, q] = [mesh.positions[a], mesh.positions[b]];
        let aim = target[a].min(target[b]);
        if p.distance(q) >= 0.8 * aim || !mesh.can_collapse([a, b]) {
            continue;
        }
        let middle = p.midpoint(q);
        let rim = mesh.neighbours(a).chain(mesh.neighbours(b));
        let stays_short = rim.into_iter().all(|v| mesh.positions[v].distance(middle) < 4.0 / 3.0 * aim.min(target[v]));
        let stays_flat = [a, b].iter().all(|&v| {
            let rest: Vec<_> = mesh.ring(v).filter(|t| !(t.contains(&a) && t.contains(&b))).collect();
            rest.into_iter().all(|triangle| keeps_facing(mesh, triangle, v, middle))
        });
        if stays_short && stays_flat {
            mesh.collapse([a, b], middle);
        }
    }
}

fn equalise_valences(mesh: &mut EditableMesh) {
    for [a, b] in mesh.edges() {
        let Some([c, d]) = mesh.facing(a, b) else { continue };
        let excess = |v: usize, change: isize| (mesh.valence(v) as isize + change - 6).abs();
        let before = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
        let after = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
        if after < before && quadrilateral_is_convex(mesh, [a, b, c, d]) {
            mesh.flip([a, b]);
        }
    }
}

/// Whether both triangles after flipping `ab` to `cd` face the way those before did.
pub(crate) fn quadrilateral_is_convex(mesh: &EditableMesh, [a, b, c, d]: [usize; 4]) -> bool {
    let vector = |t: [usize; 3]| area_vector(t.map(|v| mesh.positions[v])).normalize_or_zero();
    let before = (vector([a, b, c]) + vector([b, a, d])).normalize_or_zero();
    [[a, d, c], [d, b, c]].iter().all(|&t| vector(t).dot(before) > 0.5)
}

/// Area-weighted centroid of the ring, moved back into the tangent plane of `v`.
pub(crate) fn tangential_centroid(mesh: &EditableMesh, field: &impl Fn(DVec3) -> f64, v: usize) -> DVec3 {
    let mut sum = DVec3::ZERO;
    let mut weights = 0.0;
    for triangle in mesh.ring(v) {
        let [a, b, c] = triangle.map(|v| mesh.positions[v]);
        let weight = area_vector([a, b, c]).length();
        sum += weight * (a + b + c) / 3.0;
        weights += weight;
    }
    let p = mesh.positions[v];
    let normal = sdf::gradient(field, p).normalize_or_zero();
    let step = sum / weights - p;
    p + step - normal * step.dot(normal)
}

/// Moves `v`, unless a triangle around it would turn by more than 60° or collapse.
pub(crate) fn move_unless_folding(mesh: &mut EditableMesh, v: usize, place: DVec3) {
    if mesh.ring(v).all(|triangle| keeps_facing(mesh, triangle, v, place)) {
        mesh.positions[v] = place;
    }
}

fn keeps_facing(mesh: &EditableMesh, triangle: [usize; 3], moved: usize, place: DVec3) -> bool {
    let before = triangle.map(|v| mesh.positions[v]);
    let after = triangle.map(|v| if v == moved { place } else { mesh.positions[v] });
    let [before, after] = [before, after].map(|t| area_vector(t).normalize_or_zero());
    // A triangle without area has no direction to keep; anything is better.
    before == DVec3::ZERO || before.dot(after) > 0.5
}
