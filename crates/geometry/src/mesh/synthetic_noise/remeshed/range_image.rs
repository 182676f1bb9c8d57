//! A simulated depth camera: the image that it sees, with its errors, as a mesh.
//!
//! - The surface is seen by a pinhole camera, whose pixels at the centre of the mesh are `step` ē wide.
//! - Edges are fattened by a pixel where the depth jumps.
//! - Neighbouring pixels are joined by triangles, unless the depth jumps by more than five widths of a pixel.
//! - The depth z errs by σ ē (z/m)² c, where m is the mean depth and c a field with variance 1, which is correlated over
//!   `correlation` pixels.
//! - The disparity, 1/z, is rounded to whole steps with a random offset; a step is σ ē at the mean depth.
//!
//! The clean mesh has the depths before the last two. A pixel that was fattened is not moved back by it: no method that moves
//! vertices along their normals could do that.

use super::depth_image::{Camera, DepthImage};
use super::{RemeshError, Remeshed, pair, step};
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::mesh::synthetic_noise::correlated;
use crate::mesh::synthetic_noise::settings::SyntheticNoise;
use crate::mesh::topology::Topology;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Smallest jump of the depth between neighbouring pixels, in widths of a pixel: surfaces that are seen at more than 79° have it.
pub(super) const JUMP: f64 = 5.0;

/// Mesh of a noisy range image and its clean counterpart.
pub(super) fn remeshed(surface: &Surface, noise: &SyntheticNoise) -> Result<Remeshed, RemeshError> {
    let camera = Camera::new(surface, noise.unit_towards(), noise.distance, step(surface, noise)?)?;
    let image = DepthImage::of(surface, camera)?.fattened(JUMP);
    let mut random = ChaCha8Rng::seed_from_u64(noise.seed);
    let noisy = noisy_image(&image, noise, noise.sigma * surface.mean_edge(), &mut random)?;
    let points = |image: &DepthImage| -> Vec<DVec3> {
        (0..image.depths.len()).map(|k| camera.point(image.pixel(k), image.depths[k])).collect()
    };
    pair(&points(&image), &points(&noisy), &image.triangles(JUMP))
}

/// Returns an image with noise of a deviation (model units) at the mean depth. Pixels that no triangle uses are empty.
pub(super) fn noisy_image(
    image: &DepthImage,
    noise: &SyntheticNoise,
    deviation: f64,
    random: &mut ChaCha8Rng,
) -> Result<DepthImage, RemeshError> {
    let faces: Ragged<Index> = image.triangles(JUMP).iter().map(|t| t.to_vec()).collect();
    if faces.is_empty() {
        return Err(RemeshError::Nothing);
    }
    let mut used = vec![false; image.depths.len()];
    faces.items().iter().for_each(|&k| used[k as usize] = true);
    let topology = Topology::new(image.depths.len(), faces);
    let field = correlated::field(&topology, noise.correlation, random);
    let seen = || image.depths.iter().zip(&used).filter(|(_, used)| **used).map(|(depth, _)| depth);
    let mean = seen().sum::<f64>() / seen().count() as f64;
    let offset: f64 = random.random();
    let measured = |k: usize| {
        let depth = image.depths[k];
        let erring = depth + deviation * (depth / mean).powi(2) * field[k];
        in_steps(erring, deviation / (mean * mean), offset)
    };
    let depth = |k: usize| if used[k] { measured(k) } else { f64::INFINITY };
    Ok(image.with_depths((0..used.len()).map(depth).collect()))
}

/// Depth whose disparity is the nearest whole number of steps plus an offset; the depth itself if there is no step, or none in front
/// of the camera.
fn in_steps(depth: f64, step: f64, offset: f64) -> f64 {
    let disparity = ((1.0 / depth) / step - offset).round() + offset;
    let rounded = 1.0 / (disparity * step);
    if disparity > 0.0 && rounded.is_finite() { rounded } else { depth }
}
