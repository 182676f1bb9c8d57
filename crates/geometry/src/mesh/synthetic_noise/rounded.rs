//! Rounding of coordinates, which files with few digits, compression and depth images in whole steps bring.
//!
//! Each coordinate goes to the nearest of o + k s, k a whole number, where the step is s = √12 σ ē and the offset o of the grid is
//! random. Rounding errs evenly by up to s/2, so its deviation along every axis is s/√12 = σ ē.

use super::settings::SyntheticNoise;
use super::{STILL, layout_numbers};
use crate::mesh::surface::Surface;
use glam::DVec3;
use rand::RngExt;

/// Displacements to the points of a grid. #V×3, model units
pub(super) fn displacements(surface: &Surface, noise: &SyntheticNoise) -> Vec<DVec3> {
    let step = 12f64.sqrt() * noise.sigma * surface.mean_edge();
    if step <= 0.0 || !step.is_normal() {
        return vec![STILL; surface.positions().len()];
    }
    let mut random = layout_numbers(noise.seed);
    let offset = DVec3::from_array([(); 3].map(|()| random.random::<f64>())) * step;
    // Coordinates are counted from a vertex, so that the grid is as exact far from the origin as near it.
    let origin = surface.positions().first().copied().unwrap_or_default() + offset;
    let to_grid = |p: &DVec3| (((*p - origin) / step).round() * step + origin) - *p;
    surface.positions().iter().map(to_grid).collect()
}
