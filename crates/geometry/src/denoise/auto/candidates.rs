//! What may come out best. A new candidate is a name, and what it does in [`Candidate::way`].

use crate::denoise::map::{Prior, Run};
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A way to denoise, with all it needs to know but the noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Candidate {
    /// Leave the mesh as it is.
    Stay,
    /// Flat parts with sharp creases; stands noise that is alike between neighbours.
    Flat,
    /// Curved parts with sharp creases.
    Sharp,
    /// Parts with creases.
    Creases,
    /// Some creases.
    Mixed,
    /// Smooth shapes with detail.
    Detail,
    /// Smooth shapes.
    Smooth,
    /// Linear smoothing, very little.
    LinearFaint,
    /// Linear smoothing, little.
    LinearLight,
    /// Linear smoothing.
    Linear,
    /// Linear smoothing, much.
    LinearStrong,
}

/// What a candidate does.
pub(super) enum Way {
    Stay,
    /// S is to solve (1 + m σ UᵀU / k) x = p with the uniform umbrella, k times; m in mean edges. With more passes the band
    /// that stays has a sharper end. S p + S (p − S p) gives back most of the shape that S has flattened (Tukey's twicing), and
    /// the ways are shortened across the normals by as much as the data hold there.
    Linear {
        strength: f64,
        passes: u32,
    },
    /// The most probable surface under this prior.
    Map(Prior),
}

impl Candidate {
    /// All there are: what goes unsaid is tried.
    pub const ALL: [Self; 11] = [
        Self::Flat,
        Self::Sharp,
        Self::Creases,
        Self::Mixed,
        Self::Detail,
        Self::Smooth,
        Self::LinearFaint,
        Self::LinearLight,
        Self::Linear,
        Self::LinearStrong,
        Self::Stay,
    ];

    /// Its name, as in JSON and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stay => "stay",
            Self::Flat => "flat",
            Self::Sharp => "sharp",
            Self::Creases => "creases",
            Self::Mixed => "mixed",
            Self::Detail => "detail",
            Self::Smooth => "smooth",
            Self::LinearFaint => "linear-faint",
            Self::LinearLight => "linear-light",
            Self::Linear => "linear",
            Self::LinearStrong => "linear-strong",
        }
    }

    /// Strengths were found on a dozen and a half meshes, from machine parts to animals.
    pub(super) fn way(self) -> Way {
        let linear = |strength| Way::Linear { strength, passes: 4 };
        match self {
            Self::Stay => Way::Stay,
            Self::Flat => Way::Map(Prior::FLAT),
            Self::Sharp => Way::Map(Prior::SHARP),
            Self::Creases => Way::Map(Prior::CREASES),
            Self::Mixed => Way::Map(Prior::MIXED),
            Self::Detail => Way::Map(Prior::DETAIL),
            Self::Smooth => Way::Map(Prior::SMOOTH),
            Self::LinearFaint => linear(16.0),
            Self::LinearLight => linear(40.0),
            Self::Linear => linear(100.0),
            Self::LinearStrong => linear(240.0),
        }
    }

    /// Whether it may be mixed with another one. Linear smoothing blurs the creases that priors with creases make, and where
    /// it leaves much noise its risk is known worst: such a pair looks best by chance if ever.
    pub(super) fn mixes_with(self, other: Self) -> bool {
        let has_creases = |c: Self| matches!(c, Self::Flat | Self::Sharp | Self::Creases);
        let is_linear = |c: Self| matches!(c.way(), Way::Linear { .. });
        !(has_creases(self) && is_linear(other) || is_linear(self) && has_creases(other))
    }

    /// Ways of the vertices from `input`; `start` is the input smoothed. #V×3, model units.
    pub(super) fn ways(
        self,
        run: &Run,
        input: &[DVec3],
        start: &[DVec3],
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        match self.way() {
            Way::Stay => Ok(vec![DVec3::ZERO; input.len()]),
            Way::Linear { strength, passes } => {
                let mu = strength * run.sigma / f64::from(passes);
                let smooth = |mut x: Vec<DVec3>| -> Result<Vec<DVec3>, Cancelled> {
                    for _ in 0..passes {
                        x = run.net.umbrella.smoothed(&x, mu, run.freedom, progress)?;
                    }
                    Ok(x)
                };
                let once = smooth(input.to_vec())?;
                let left = smooth(input.iter().zip(&once).map(|(p, x)| *p - *x).collect())?;
                let smoothed: Vec<DVec3> = once.iter().zip(left).map(|(x, left)| *x + left).collect();
                let normals = run.net.vertex_normals(&smoothed);
                let ways = smoothed.iter().zip(input).zip(normals).map(|((x, p), n)| {
                    let across = (*x - *p).reject_from_normalized(n);
                    *x - *p - across * (run.held / (1.0 + run.held))
                });
                Ok(ways.collect())
            }
            Way::Map(prior) => run.ways(input, start, &prior, progress),
        }
    }
}

impl fmt::Display for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests;
