//! White noise whose deviation differs from vertex to vertex: dᵢ = σᵢ gᵢ uᵢ, with the same gᵢ and uᵢ as white noise of that seed.
//!
//! - Fade: σᵢ = 2 tᵢ σ ē, where tᵢ runs from 0 to 1 along a direction a: tᵢ = (⟨pᵢ, a⟩ − min) / (max − min).
//! - Partial: σᵢ = σ ē where ⟨qᵢ, a⟩ + 0.1 sin(2π ⟨qᵢ, b⟩ + φ) is above a threshold, else 0. Here qᵢ = (pᵢ − centre) / radius,
//!   b is across a, φ is random, and the threshold makes the noisy vertices own `share` of the area.
//! - Local: σᵢ = σ eᵢ, where eᵢ is the mean length of the edges at vertex i.

use super::settings::SyntheticNoise;
use super::white::{Noise, with_deviations};
use super::{STILL, layout_numbers, sphere_around};
use crate::mesh::jagged::Index;
use crate::mesh::laplacian;
use crate::mesh::surface::Surface;
use glam::DVec3;
use rand::RngExt;
use std::f64::consts::TAU;

/// Amplitude of the waves of the line between the noisy and the clean part, in radii: enough that the line follows no row of
/// faces.
const WAVE: f64 = 0.1;

/// Displacements of noise that grows along a direction. #V×3, model units
pub(super) fn fade(surface: &Surface, noise: &SyntheticNoise) -> Vec<DVec3> {
    let along = noise.unit_towards();
    let used = (0..).zip(surface.positions()).filter(|(v, _)| !surface.topology().is_isolated(*v));
    let start = [f64::INFINITY, f64::NEG_INFINITY];
    let [low, high] = used.map(|(_, p)| p.dot(along)).fold(start, |[low, high], s| [low.min(s), high.max(s)]);
    let edge = surface.mean_edge();
    displacements(surface, noise, |v| {
        let t = ((surface.positions()[v].dot(along) - low) / (high - low)).clamp(0.0, 1.0);
        // A mesh without extent in this direction has no end that differs from the other.
        let t = if t.is_nan() { 0.5 } else { t };
        2.0 * t * noise.sigma * edge
    })
}

/// Displacements of noise on one part of the surface. #V×3, model units
pub(super) fn partial(surface: &Surface, noise: &SyntheticNoise) -> Vec<DVec3> {
    let Some((centre, radius)) = sphere_around(surface) else { return vec![STILL; surface.positions().len()] };
    let along = noise.unit_towards();
    let across = along.any_orthonormal_vector();
    let phase = layout_numbers(noise.seed ^ 1).random::<f64>() * TAU;
    let score = |p: &DVec3| {
        let q = (*p - centre) / radius;
        q.dot(along) + WAVE * (TAU * q.dot(across) + phase).sin()
    };
    let scores: Vec<f64> = surface.positions().iter().map(score).collect();
    let is_noisy = highest_share(&scores, &laplacian::mass(surface), noise.share);
    let deviation = noise.sigma * surface.mean_edge();
    displacements(surface, noise, |v| if is_noisy[v] { deviation } else { 0.0 })
}

/// Marks the vertices with the highest scores that own a share of the area.
fn highest_share(scores: &[f64], areas: &[f64], share: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..scores.len()).collect();
    order.sort_by(|&a, &b| scores[b].total_cmp(&scores[a]).then(a.cmp(&b)));
    let wanted = share * areas.iter().sum::<f64>();
    let mut marks = vec![false; scores.len()];
    let mut sum = 0.0;
    for v in order {
        // The vertex in whose cell the threshold lies counts if more than half of it is needed.
        marks[v] = sum + areas[v] / 2.0 < wanted;
        sum += areas[v];
    }
    marks
}

/// Displacements of noise in lengths of the edges at each vertex. #V×3, model units
pub(super) fn local(surface: &Surface, noise: &SyntheticNoise) -> Vec<DVec3> {
    displacements(surface, noise, |v| noise.sigma * mean_edge_at(surface, v as Index))
}

/// Mean length of the edges at a vertex, model units; 0 without edges.
pub(super) fn mean_edge_at(surface: &Surface, vertex: Index) -> f64 {
    let at = |v: Index| surface.positions()[v as usize];
    let ring = surface.topology().rings().get(vertex);
    ring.iter().map(|&n| at(n).distance(at(vertex))).sum::<f64>() / ring.len().max(1) as f64
}

/// Displacements of white noise with the given deviations (model units); vertices without deviation keep their bits.
fn displacements(surface: &Surface, noise: &SyntheticNoise, deviation: impl Fn(usize) -> f64) -> Vec<DVec3> {
    let white = Noise { sigma: noise.sigma, direction: noise.direction, share: 1.0, seed: noise.seed };
    let all = with_deviations(surface, &white, deviation);
    all.into_iter().map(|d| if d == DVec3::ZERO { STILL } else { d }).collect()
}
