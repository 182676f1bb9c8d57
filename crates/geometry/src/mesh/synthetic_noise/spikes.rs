//! Spikes: outliers, as wrong matches, dust and reflections leave them.
//!
//! Of the vertices that have a normal, `share`, at least one, is drawn without repetition; each of those moves by `length` mean
//! edges along its normal, outwards or inwards by chance. The others keep their bits.

use super::STILL;
use super::settings::SyntheticNoise;
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Displacements of the spikes. #V×3, model units
pub(super) fn displacements(surface: &Surface, noise: &SyntheticNoise) -> Vec<DVec3> {
    let length = noise.length * surface.mean_edge();
    let normals = normals::vertex_normals(surface, FaceWeight::Angle);
    let mut random = ChaCha8Rng::seed_from_u64(noise.seed);
    let draws: Vec<(u64, bool)> = normals.iter().map(|_| (random.random(), random.random())).collect();
    let mut order: Vec<usize> = (0..normals.len()).filter(|&v| normals[v] != DVec3::ZERO).collect();
    order.sort_by_key(|&v| (draws[v].0, v));
    let mut out = vec![STILL; normals.len()];
    for &v in &order[..count(order.len(), noise.share)] {
        out[v] = normals[v] * if draws[v].1 { length } else { -length };
    }
    out
}

/// Number of spikes among `vertices`.
pub(super) fn count(vertices: usize, share: f64) -> usize {
    let count = (share * vertices as f64).round() as usize;
    if share > 0.0 { count.max(1).min(vertices) } else { 0 }
}
