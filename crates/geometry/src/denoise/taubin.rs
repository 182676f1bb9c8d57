//! Taubin smoothing: Laplacian smoothing that does not shrink.
//!
//! Gabriel Taubin. A signal processing approach to fair surface design. SIGGRAPH 1995.
//!
//! One iteration is a step towards the mean of the neighbours, x ← x + λ L x, and one away from it, x ← x + μ L x. With
//! μ < −λ < 0 the second undoes the shrinking of the first for all frequencies k below the pass band 1/λ + 1/μ.

use super::EdgeWeights;
use super::boundary::{BOUNDARY, Boundary};
use super::laplacian::{STEP, Smoother, WEIGHTS};
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::parameters::Parameter;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::Taubin`](super::Denoiser::Taubin).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Taubin {
    /// Pairs of steps.
    pub iterations: u32,
    /// λ, the step that smooths, in 0..=1.
    pub step: f64,
    /// μ, the step that puts the volume back; below −λ.
    pub inflate: f64,
    /// Weights of the neighbours.
    pub weights: EdgeWeights,
    /// Treatment of the boundary of an open mesh.
    pub boundary: Boundary,
}

impl Default for Taubin {
    /// λ = 0.5, μ = −0.53: a pass band of 0.11, ten times.
    fn default() -> Self {
        Self {
            iterations: 10,
            step: 0.5,
            inflate: -0.53,
            weights: EdgeWeights::default(),
            boundary: Boundary::default(),
        }
    }
}

/// Parameters of the method.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::count("iterations", "/iterations", 100, "number of pairs of steps"),
    STEP,
    Parameter::number("inflate", "/inflate", [-1.5, 0.0], "step away from the mean that follows each step towards it"),
    WEIGHTS,
    BOUNDARY,
];

impl DenoiseMethod for Taubin {
    const INFO: MethodInfo = MethodInfo {
        name: "taubin",
        summary: "Smoothing that does not shrink: for light noise on organic shapes",
        reference: Some(Reference {
            cite: "Taubin 1995",
            title: "A signal processing approach to fair surface design. SIGGRAPH",
        }),
        parameters: &[PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        deltas(surface, self, progress)
    }
}

/// Smooths and returns δ = p − p*. #V×3, model units
pub(super) fn deltas(surface: &Surface, settings: &Taubin, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
    let pair = [settings.step, settings.inflate];
    let steps = (0..settings.iterations).flat_map(|_| pair);
    Smoother::new(surface, settings.weights, settings.boundary).deltas(
        steps,
        2 * settings.iterations as usize,
        progress,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::progress::Silent;

    #[test]
    fn a_sphere_keeps_its_volume_where_the_plain_step_shrinks_it() {
        let sphere = shapes::sphere(3);
        let volume_after = |inflate| {
            let settings = Taubin { iterations: 20, inflate, ..Taubin::default() };
            let deltas = deltas(&sphere, &settings, &Silent).unwrap();
            sphere.at(sphere.moved_by(&deltas)).volume() / sphere.volume()
        };
        // Below the pass band the gain of a pair is a little above one: (1 − λk)(1 − μk) for the k of the coordinates.
        assert!((volume_after(-0.53) - 1.0).abs() < 0.05, "{}", volume_after(-0.53));
        // Twenty half steps of the coordinates' k, which is about 0.012 here: (1 − k/2)⁶⁰.
        assert!(volume_after(0.0) < 0.75, "{}", volume_after(0.0));
    }
}
