//! Noise that is correlated between neighbours.
//!
//! White noise g is diffused by n lazy umbrella steps, x ← ½ x + ½ (mean of the neighbours of x), and scaled to variance 1: this is
//! the field c. A step spreads by a quarter of a squared edge in each of two directions, so the correlation of c at a distance of r
//! edges is about exp(−r²/n); it falls to 1/e at √n edges, so n is the square of the correlation length. The displacement is
//! dᵢ = σ ē (√(1 − w²) cᵢ + w g′ᵢ) nᵢ, where g′ is white noise, which sensors add on top, and w = 0.15.

use super::settings::SyntheticNoise;
use crate::mesh::jagged::Index;
use crate::mesh::normals::{self, FaceWeight};
use crate::mesh::surface::Surface;
use crate::mesh::topology::Topology;
use glam::DVec3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

/// Deviation of the white part, in σ: about what the last digit of a depth sensor adds.
pub(super) const WHITE_PART: f64 = 0.15;

/// Displacements of correlated noise. #V×3, model units
pub(super) fn displacements(surface: &Surface, noise: &SyntheticNoise) -> Vec<DVec3> {
    let length = noise.sigma * surface.mean_edge();
    let normals = normals::vertex_normals(surface, FaceWeight::Angle);
    let mut random = ChaCha8Rng::seed_from_u64(noise.seed);
    let smooth = field(surface.topology(), noise.correlation, &mut random);
    let smooth_part = (1.0 - WHITE_PART * WHITE_PART).sqrt();
    let height = |c: f64, g: f64| length * (smooth_part * c + WHITE_PART * g);
    let white = StandardNormal.sample_iter(random);
    smooth.iter().zip(white).zip(normals).map(|((c, g), n)| n * height(*c, g)).collect()
}

/// Gaussian field with variance 1, whose correlation falls to 1/e over a `length` in edges. Vertices without neighbours have
/// independent values. #V
pub(super) fn field(topology: &Topology, length: f64, random: &mut ChaCha8Rng) -> Vec<f64> {
    let white = StandardNormal.sample_iter(random).take(topology.vertex_count()).collect();
    let mut field = diffused(topology, white, (length * length).round() as usize);
    let is_alone = |v: usize| topology.rings().get(v as Index).is_empty();
    let joined: Vec<usize> = (0..field.len()).filter(|&v| !is_alone(v)).collect();
    let variance = joined.iter().map(|&v| field[v] * field[v]).sum::<f64>() / joined.len() as f64;
    if variance > 0.0 {
        joined.iter().for_each(|&v| field[v] /= variance.sqrt());
    }
    field
}

/// Values after a number of lazy umbrella steps. #V
pub(super) fn diffused(topology: &Topology, mut values: Vec<f64>, steps: usize) -> Vec<f64> {
    for _ in 0..steps {
        let step = |v: usize| {
            let ring = topology.rings().get(v as Index);
            let sum = ring.iter().map(|&n| values[n as usize]).sum::<f64>();
            if ring.is_empty() { values[v] } else { (values[v] + sum / ring.len() as f64) / 2.0 }
        };
        values = (0..values.len()).into_par_iter().map(step).collect();
    }
    values
}
