//! Noise of a camera: errors along the rays from its eye.
//!
//! The eye is at e = m + D R a, where m and R are the centre and radius of the sphere around the bounding box, a a direction and D
//! the distance. Vertex i has the unit ray rᵢ from e to pᵢ and the depth zᵢ = ⟨e − pᵢ, a⟩. Triangulation errs by the square of the
//! depth: dᵢ = σ ē (zᵢ² / s) cᵢ rᵢ, where s is the root mean square of the zᵢ² and c a field with variance 1 that is correlated
//! over few edges. Every vertex is disturbed, whether the eye sees it or not.

use super::correlated;
use super::settings::SyntheticNoise;
use super::{STILL, sphere_around};
use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use glam::DVec3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Position of the eye; `None` for a mesh without extent.
pub(super) fn eye(surface: &Surface, noise: &SyntheticNoise) -> Option<DVec3> {
    let (centre, radius) = sphere_around(surface)?;
    Some(centre + noise.unit_towards() * (noise.distance.max(SyntheticNoise::NEAREST) * radius))
}

/// Displacements along the rays. #V×3, model units
pub(super) fn displacements(surface: &Surface, noise: &SyntheticNoise) -> Vec<DVec3> {
    let count = surface.positions().len();
    let Some(eye) = eye(surface, noise) else { return vec![STILL; count] };
    let axis = noise.unit_towards();
    let growth: Vec<f64> = surface.positions().iter().map(|p| (eye - *p).dot(axis).powi(2)).collect();
    let used: Vec<usize> = (0..count).filter(|&v| !surface.topology().is_isolated(v as Index)).collect();
    let mean = (used.iter().map(|&v| growth[v] * growth[v]).sum::<f64>() / used.len() as f64).sqrt();
    let mut random = ChaCha8Rng::seed_from_u64(noise.seed);
    let field = correlated::field(surface.topology(), noise.correlation, &mut random);
    let scale = noise.sigma * surface.mean_edge() / mean;
    let along_ray = |((p, a), c): ((&DVec3, f64), f64)| (*p - eye).normalize_or_zero() * (scale * a * c);
    surface.positions().iter().zip(growth).zip(field).map(along_ray).collect()
}
