//! What may come out best.

use crate::denoise::map::{Prior, Run};
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use serde::Serialize;
use std::fmt;

/// A way to denoise, with all it needs to know but the noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Candidate {
    /// Leave the mesh as it is.
    Stay,
    /// Solve (1 + m σ UᵀU / k) x = p with the uniform umbrella, k times.
    Linear {
        /// m, with σ in mean edges.
        strength: f64,
        /// k: with more of them the band that passes has a sharper end.
        passes: u32,
    },
    /// The most probable surface under this prior.
    Map(Prior),
}

/// From sharp creases to all smooth. Found on a dozen and a half meshes, from machine parts to animals. The order is of no
/// matter but for whoever reads the shares.
pub(super) fn all() -> Vec<Candidate> {
    let map = |exponent, strength, threshold, curvature, rounds, spread| {
        Candidate::Map(Prior { exponent, strength, threshold, curvature, rounds, spread })
    };
    let linear = |strength| Candidate::Linear { strength, passes: 4 };
    vec![
        map(0.75, 1.0, 0.03, 3.0, 12, 1.0),
        map(0.6, 1.5, 0.02, 3.0, 12, 1.0),
        map(0.5, 2.0, 0.02, 3.0, 12, 1.0),
        map(0.5, 3.0, 0.05, 1.0, 4, 2.0),
        map(0.5, 6.0, 0.1, 1.0, 5, 2.0),
        linear(20.0),
        linear(50.0),
        linear(120.0),
        Candidate::Stay,
    ]
}

/// For noise that the risk cannot be estimated for.
pub(super) fn robust() -> Candidate {
    Candidate::Map(Prior { exponent: 0.75, curvature: 10.0, ..Prior::default() })
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
            Self::Linear { strength, passes } => {
                let mu = strength * run.sigma / f64::from(*passes);
                let mut smoothed = input.to_vec();
                for _ in 0..*passes {
                    smoothed = run.net.umbrella.smoothed(&smoothed, mu, run.freedom, progress)?;
                }
                Ok(smoothed.iter().zip(input).map(|(x, p)| *x - p).collect())
            }
            Self::Map(prior) => run.ways(input, start, prior, progress),
        }
    }
}

impl fmt::Display for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stay => write!(f, "left alone"),
            Self::Linear { strength, .. } => write!(f, "linear smoothing (strength {strength})"),
            Self::Map(Prior { exponent, strength, threshold, .. }) => {
                write!(f, "map (exponent {exponent}, strength {strength}, threshold {threshold})")
            }
        }
    }
}
