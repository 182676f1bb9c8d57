//! What may come out best.

use crate::denoise::map::{Prior, Run};
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use serde::Serialize;

/// A way to denoise, with all it needs to know but the noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Candidate {
    /// Leave the mesh as it is.
    Stay,
    /// Solve (1 + m σ UᵀU) x = p with the uniform umbrella.
    Linear {
        /// m, with σ in mean edges.
        strength: f64,
    },
    /// The most probable surface under this prior.
    Map(Prior),
}

/// From sharp creases to all smooth. Found on a dozen and a half of meshes from machine parts to animals.
pub(super) fn all() -> Vec<Candidate> {
    let map = |exponent, strength, threshold, curvature, rounds, spread| {
        Candidate::Map(Prior { exponent, strength, threshold, curvature, rounds, spread })
    };
    vec![
        map(0.75, 1.0, 0.03, 3.0, 12, 1.0),
        map(0.6, 1.5, 0.02, 3.0, 12, 1.0),
        map(0.5, 2.0, 0.02, 3.0, 12, 1.0),
        map(0.5, 3.0, 0.05, 1.0, 4, 2.0),
        map(0.5, 6.0, 0.1, 1.0, 5, 2.0),
        Candidate::Linear { strength: 40.0 },
        Candidate::Linear { strength: 100.0 },
        Candidate::Stay,
    ]
}

impl Candidate {
    /// Ways of the vertices from `input`; `start` is the input smoothed. #V×3, model units.
    pub(super) fn ways(
        &self,
        run: &Run,
        input: &[DVec3],
        start: &[DVec3],
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        match self {
            Self::Stay => Ok(vec![DVec3::ZERO; input.len()]),
            Self::Linear { strength } => {
                let smoothed = run.net.umbrella.smoothed(input, strength * run.sigma, run.freedom, progress)?;
                Ok(smoothed.iter().zip(input).map(|(x, p)| *x - p).collect())
            }
            Self::Map(prior) => run.ways(input, start, prior, progress),
        }
    }
}
