//! HC smoothing: Laplacian smoothing with a correction that pushes vertices back.
//!
//! Jörg Vollmer, Robert Mencl, Heinrich Müller. Improved Laplacian smoothing of noisy surface meshes. Computer Graphics
//! Forum 18 (3), Eurographics 1999: the HC algorithm.
//!
//! One iteration moves each vertex q to the mean p of its neighbours, and then back by an average of its own motion and
//! that of its neighbours: with b = p − (α o + (1 − α) q), where o is the position in the input,
//! p ← p − (β b + (1 − β) · mean of the neighbours' b).

use super::boundary::{BOUNDARY, Boundary};
use super::method::{DenoiseMethod, MethodInfo, Reference};
use super::parameters::Parameter;
use crate::mesh::jagged::Index;
use crate::mesh::laplacian;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Settings of [`Denoiser::Hc`](super::Denoiser::Hc).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hc {
    /// Number of steps.
    pub iterations: u32,
    /// α in 0..=1: how much of the way back is to the input, and not to the step before.
    pub alpha: f64,
    /// β in 0..=1: how much a vertex's own way counts, and not that of its neighbours.
    pub beta: f64,
    /// Treatment of the boundary of an open mesh.
    pub boundary: Boundary,
}

impl Default for Hc {
    /// α = 0, β = 0.5 as in the paper, eight times.
    fn default() -> Self {
        Self { iterations: 8, alpha: 0.0, beta: 0.5, boundary: Boundary::Fixed }
    }
}

/// Parameters of the method.
pub(super) const PARAMETERS: &[Parameter] = &[
    Parameter::count("iterations", "/iterations", 100, "number of steps"),
    Parameter::number(
        "alpha",
        "/alpha",
        [0.0, 1.0],
        "how much vertices are pushed back towards the input, and not towards the step before",
    ),
    Parameter::number(
        "beta",
        "/beta",
        [0.0, 1.0],
        "how much the push follows the motion of the vertex itself, and not that of its neighbours",
    ),
    BOUNDARY,
];

impl DenoiseMethod for Hc {
    const INFO: MethodInfo = MethodInfo {
        name: "hc",
        summary: "Smoothing that pushes vertices back after each step, so that little volume is lost",
        reference: Some(Reference {
            cite: "Vollmer et al. 1999",
            title: "Improved Laplacian smoothing of noisy surface meshes. Computer Graphics Forum 18 (3)",
        }),
        parameters: &[PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        deltas(surface, self, progress)
    }

    fn published() -> Option<Self> {
        Some(Self::default())
    }
}

/// Smooths and returns δ = p − p*. #V×3, model units
pub(super) fn deltas(surface: &Surface, settings: &Hc, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
    let (topology, input) = (surface.topology(), surface.positions());
    let stays = |v: usize| settings.boundary == Boundary::Fixed && topology.is_boundary(v as Index);
    let Hc { alpha, beta, .. } = *settings;
    let mut positions = input.to_vec();
    for done in 1..=settings.iterations {
        progress.check()?;
        let to_mean = laplacian::uniform(topology, &positions);
        let correction = |(v, to_mean): (usize, &DVec3)| {
            if stays(v) { DVec3::ZERO } else { alpha * (positions[v] - input[v]) + *to_mean }
        };
        let corrections: Vec<DVec3> = to_mean.par_iter().enumerate().map(correction).collect();
        // Difference between the mean of the neighbours' b and a vertex's own.
        let to_mean_correction = laplacian::uniform(topology, &corrections);
        positions.par_iter_mut().enumerate().for_each(|(v, x)| {
            if !stays(v) {
                *x += to_mean[v] - (corrections[v] + (1.0 - beta) * to_mean_correction[v]);
            }
        });
        progress.done(f64::from(done) / f64::from(settings.iterations));
    }
    Ok(input.iter().zip(positions).map(|(p, x)| *p - x).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::Laplacian;
    use crate::denoise::laplacian as plain;
    use crate::mesh::shapes;
    use crate::progress::Silent;

    #[test]
    fn it_shrinks_a_sphere_far_less_than_the_plain_step() {
        let sphere = shapes::sphere(3);
        let lost = |deltas: Vec<DVec3>| 1.0 - sphere.at(sphere.moved_by(&deltas)).volume() / sphere.volume();
        let hc = lost(deltas(&sphere, &Hc::default(), &Silent).unwrap());
        let steps = Laplacian { iterations: 8, step: 1.0, ..Laplacian::default() };
        let plain = lost(plain::deltas(&sphere, &steps, &Silent).unwrap());
        // A step restores what it takes off smooth shapes, except for the curvature of the neighbours' motion.
        assert!(plain > 0.02 && hc.abs() < plain / 20.0, "{hc} {plain}");
    }

    #[test]
    fn steps_are_those_of_the_formula() {
        let surface = shapes::dented_sphere(2);
        let o = surface.positions();
        let (alpha, beta) = (0.3, 0.4);
        let mean = |v: usize, x: &[DVec3]| {
            let ring = surface.topology().rings().get(v as Index);
            ring.iter().map(|&w| x[w as usize]).sum::<DVec3>() / ring.len() as f64
        };
        let mut q = o.to_vec();
        for iterations in 1..=3 {
            let p: Vec<DVec3> = (0..q.len()).map(|v| mean(v, &q)).collect();
            let b: Vec<DVec3> = (0..q.len()).map(|v| p[v] - (alpha * o[v] + (1.0 - alpha) * q[v])).collect();
            q = (0..q.len()).map(|v| p[v] - (beta * b[v] + (1.0 - beta) * mean(v, &b))).collect();
            let settings = Hc { iterations, alpha, beta, ..Hc::default() };
            for (v, delta) in deltas(&surface, &settings, &Silent).unwrap().into_iter().enumerate() {
                assert!(delta.distance(o[v] - q[v]) < 1e-14, "{iterations}: {delta}");
            }
        }
    }

    #[test]
    fn with_everything_pushed_back_nothing_moves() {
        let surface = shapes::dented_sphere(2);
        let all = Hc { iterations: 3, alpha: 1.0, beta: 1.0, ..Hc::default() };
        for delta in deltas(&surface, &all, &Silent).unwrap() {
            // A few roundings of numbers of size one.
            assert!(delta.length() < 1e-15);
        }
    }
}
