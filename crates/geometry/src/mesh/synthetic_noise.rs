//! Synthetic noise of the kinds that meshes meet in practice, for tests and experiments.
//!
//! A kind of noise moves vertex i from pᵢ to pᵢ + dᵢ. Below, ē is the mean edge length of the mesh, σ the deviation that was
//! asked for in mean edge lengths, nᵢ the vertex normal, and gᵢ are independent Gaussian numbers with variance 1.
//!
//! | kind | displacement dᵢ |
//! | --- | --- |
//! | white | σ ē gᵢ nᵢ |
//! | impulsive | σ ē gᵢ nᵢ with probability `share`, else 0 |
//! | correlated | σ ē (√(1 − w²) cᵢ + w gᵢ) nᵢ, where c is white noise diffused over the mesh, and w = 0.15 |
//! | rounded | pᵢ to the nearest point of a grid of step √12 σ ē, which has a random offset |
//! | camera | σ ē aᵢ cᵢ rᵢ along the ray rᵢ from an eye, where aᵢ grows with the square of the depth |
//! | fade | 2 tᵢ σ ē gᵢ nᵢ, where tᵢ grows from 0 to 1 along a direction |
//! | partial | σ ē gᵢ nᵢ on one side of a wavy line, else 0 |
//! | local | σ eᵢ gᵢ nᵢ, where eᵢ is the mean length of the edges of vertex i |
//! | spikes | ± `length` ē nᵢ at few vertices, else 0 |
//!
//! Three kinds make a mesh with vertices of its own, and give its clean counterpart with it: a range image, which one depth camera
//! sees, a fusion of depth images from all sides, and the surface of voxels.
//!
//! The files of this module have the formulas of each family. All kinds are deterministic: the same mesh, settings and seed
//! give the same bits.
//!
//! ```
//! use planish_geometry::mesh::{shapes, synthetic_noise::{self, Direction, Noise}};
//!
//! // Noise along the normals of a sheet in the plane z = 0, a fifth of an edge large.
//! let sheet = shapes::grid(40);
//! let noise = Noise { sigma: 0.2, direction: Direction::Normal, share: 1.0, seed: 1 };
//! let moved = synthetic_noise::displacements(&sheet, &noise);
//! let deviation = (moved.iter().map(|d| d.z * d.z).sum::<f64>() / moved.len() as f64).sqrt();
//! assert!((deviation / sheet.mean_edge() - 0.2).abs() < 0.02);
//! assert_eq!(moved, synthetic_noise::displacements(&sheet, &noise));
//! ```

mod camera;
mod correlated;
mod remeshed;
mod rounded;
mod settings;
mod spikes;
#[cfg(test)]
mod tests;
mod uneven;
mod white;

pub use remeshed::{Cells, RemeshError, Remeshed};
pub use settings::{NoiseSetting, SyntheticKind, SyntheticNoise};
pub use white::{Direction, Noise, displacements, noisy};

use crate::mesh::surface::Surface;
use glam::DVec3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Displacement that leaves a position as it is, bit for bit: −0 is the neutral element of addition, because −0 + 0 is 0.
const STILL: DVec3 = DVec3::splat(-0.0);

/// Result of adding noise to a surface.
#[derive(Clone, Debug)]
pub enum Disturbed {
    /// The noise moves the vertices: displacements dᵢ, which are to be added to the positions; zero where nothing moves. #V×3,
    /// model units
    Moved(Vec<DVec3>),
    /// The noise comes with a mesh of its own.
    Remeshed(Box<Remeshed>),
}

/// Disturbs a surface with noise of any kind. Kinds that keep the connectivity never fail.
pub fn disturb(surface: &Surface, noise: &SyntheticNoise) -> Result<Disturbed, RemeshError> {
    match remeshed::remeshed(surface, noise) {
        Some(pair) => pair.map(|pair| Disturbed::Remeshed(Box::new(pair))),
        None => Ok(Disturbed::Moved(moved(surface, noise))),
    }
}

/// Displacements of a kind that keeps the connectivity; none for the others. #V×3, model units
fn moved(surface: &Surface, noise: &SyntheticNoise) -> Vec<DVec3> {
    let white = |share| Noise { sigma: noise.sigma, direction: noise.direction, share, seed: noise.seed };
    match noise.kind {
        SyntheticKind::White => displacements(surface, &white(1.0)),
        SyntheticKind::Impulsive => displacements(surface, &white(noise.share)),
        SyntheticKind::Correlated => correlated::displacements(surface, noise),
        SyntheticKind::Rounded => rounded::displacements(surface, noise),
        SyntheticKind::Camera => camera::displacements(surface, noise),
        SyntheticKind::Fade => uneven::fade(surface, noise),
        SyntheticKind::Partial => uneven::partial(surface, noise),
        SyntheticKind::Local => uneven::local(surface, noise),
        SyntheticKind::Spikes => spikes::displacements(surface, noise),
        SyntheticKind::RangeImage | SyntheticKind::Fusion | SyntheticKind::Voxels => {
            vec![STILL; surface.positions().len()]
        }
    }
}

/// Random numbers of a seed that are independent of those that displace vertices: for directions and offsets, so that giving a
/// direction does not change the other draws.
fn layout_numbers(seed: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(1);
    random
}

/// Centre of the bounding box and half its diagonal; `None` for a mesh without faces or without extent.
fn sphere_around(surface: &Surface) -> Option<(DVec3, f64)> {
    let [low, high] = surface.bounds();
    let radius = low.distance(high) / 2.0;
    (radius.is_finite() && radius > 0.0).then(|| (low.midpoint(high), radius))
}
