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

/// From sharp creases to all smooth. Found on a dozen and a half of meshes from machine parts to animals.
pub(super) fn all() -> Vec<Candidate> {
    let map = |exponent, strength, threshold, curvature, rounds, spread| {
        Candidate::Map(Prior { exponent, strength, threshold, curvature, rounds, spread })
    };
    let k = crate::denoise::noise_level::knob;
    if k("LIN", 0.0) > 0.0 {
        let (p, f) = (k("LIN", 3.0) as u32, k("LF", 1.0));
        return vec![
            map(0.75, 1.0, 0.03, 3.0, 12, 1.0),
            map(0.6, 1.5, 0.02, 3.0, 12, 1.0),
            map(0.5, 2.0, 0.02, 3.0, 12, 1.0),
            map(0.5, 3.0, 0.05, 1.0, 4, 2.0),
            map(0.5, 6.0, 0.1, 1.0, 5, 2.0),
            Candidate::Linear { strength: 10.0 * f, passes: p },
            Candidate::Linear { strength: 25.0 * f, passes: p },
            Candidate::Linear { strength: 60.0 * f, passes: p },
            Candidate::Stay,
        ];
    }
    if k("ONE", -9.0) > -9.0 {
        let m = Candidate::Map(Prior {
            exponent: k("MP", 0.5),
            strength: k("ML", 3.0),
            threshold: k("MK", 0.05),
            curvature: k("MA", 1.0),
            rounds: k("MR", 5.0) as u32,
            spread: k("MT", 2.0),
        });
        return vec![m];
    }
    vec![
        map(0.75, 1.0, 0.03, 3.0, 12, 1.0),
        map(0.6, 1.5, 0.02, 3.0, 12, 1.0),
        map(0.5, 2.0, 0.02, 3.0, 12, 1.0),
        map(0.5, 3.0, 0.05, 1.0, 4, 2.0),
        map(0.5, 6.0, 0.1, 1.0, 5, 2.0),
        Candidate::Linear { strength: 40.0, passes: 1 },
        Candidate::Linear { strength: 100.0, passes: 1 },
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
            Self::Linear { strength, passes } => {
                let mut smoothed = input.to_vec();
                for _ in 0..*passes {
                    let mu = strength * run.sigma / f64::from(*passes);
                    smoothed = run.net.umbrella.smoothed(&smoothed, mu, run.freedom, progress)?;
                }
                Ok(smoothed.iter().zip(input).map(|(x, p)| *x - p).collect())
            }
            Self::Map(prior) => run.ways(input, start, prior, progress),
        }
    }
}
