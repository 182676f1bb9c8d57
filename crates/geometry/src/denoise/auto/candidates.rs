//! Algorithms of the candidates of a mixture. A new candidate is a name in [`Candidate`], and its algorithm in [`Candidate::algorithm`].

use crate::denoise::bilaplacian::LocalStrength;
use crate::denoise::bilateral_normals::{self, BilateralNormals};
use crate::denoise::choice::Candidate;
use crate::denoise::face_geometry::FaceGeometry;
use crate::denoise::learned;
use crate::denoise::map::{Prior, Problem};
use crate::denoise::noise_level::Kind;
use crate::denoise::vertex_update::Updater;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;

/// Algorithm of a candidate.
pub(super) enum Algorithm {
    /// The input is the result.
    Stay,
    /// Linear smoothing S: it solves (1 + m σ UᵀU / k) x = p with the umbrella operator, k times; m is the strength, σ is in
    /// mean edges. More passes k make the low-pass filter steeper. S p + S (p − S p) gives back most of the shape that S has
    /// flattened (Tukey's twicing). The tangential part of each offset is scaled down by the stiffness of the data term.
    Linear {
        /// Strength m.
        strength: f64,
        /// Number of passes k.
        passes: u32,
    },
    /// The most probable surface under this prior.
    Map(Prior),
    /// The bilateral filter of the face normals, whatever the noise.
    BilateralNormals(BilateralNormals),
    /// The learned filter, whatever the noise.
    Learned,
}

impl Candidate {
    /// Candidates that suit a kind of noise.
    pub(super) fn suited_to(kind: Kind) -> Vec<Self> {
        let all = Self::ALL.into_iter();
        match kind {
            Kind::None => vec![Self::Stay],
            Kind::Correlated => {
                let unsuited = |c: &Self| matches!(c, Self::Sharp | Self::Detail | Self::LinearFaint);
                all.filter(|c| !unsuited(c) && !c.is_apart()).collect()
            }
            Kind::Independent | Kind::Uneven => all.filter(|c| !c.is_for_shared_noise() && !c.is_apart()).collect(),
        }
    }

    /// Whether the candidate is none of those that are mixed by their estimated errors: nothing to do, and the learned filter, which
    /// joins afterwards.
    fn is_apart(self) -> bool {
        matches!(self, Self::Stay | Self::Learned)
    }

    /// Whether the candidate is for noise that is not white: it smooths more than that calls for, or, as the filter of normals
    /// does, leaves facets whose normals alternate, of which the estimated risk sees little.
    fn is_for_shared_noise(self) -> bool {
        matches!(self, Self::FlatStrong | Self::CreasesStrong | Self::SmoothStrong | Self::LinearWide | Self::Bilateral)
    }

    /// Algorithm with its settings. Strengths were found on a dozen and a half meshes, from machine parts to animals.
    pub(super) fn algorithm(self) -> Algorithm {
        let linear = |strength| Algorithm::Linear { strength, passes: 4 };
        let strong = |prior: Prior| Algorithm::Map(Prior { strength: 5.0 * prior.strength, ..prior });
        match self {
            Self::Stay => Algorithm::Stay,
            Self::Flat => Algorithm::Map(Prior::FLAT),
            Self::Sharp => Algorithm::Map(Prior::SHARP),
            Self::Creases => Algorithm::Map(Prior::CREASES),
            Self::Mixed => Algorithm::Map(Prior::MIXED),
            Self::Detail => Algorithm::Map(Prior::DETAIL),
            Self::Smooth => Algorithm::Map(Prior::SMOOTH),
            Self::FlatStrong => strong(Prior::FLAT),
            Self::CreasesStrong => strong(Prior::CREASES),
            Self::SmoothStrong => strong(Prior::SMOOTH),
            Self::Bilateral => Algorithm::BilateralNormals(BilateralNormals::default()),
            Self::Learned => Algorithm::Learned,
            Self::LinearFaint => linear(16.0),
            Self::LinearLight => linear(40.0),
            Self::Linear => linear(100.0),
            Self::LinearStrong => linear(240.0),
            Self::LinearWide => linear(1000.0),
        }
    }

    /// Whether a mixture may contain the mean of this candidate and another one. Linear smoothing blurs the creases that
    /// priors with creases make, and where it leaves much noise its risk is least certain: such a pair looks best by chance if
    /// ever.
    pub(super) fn mixes_with(self, other: Self) -> bool {
        let has_creases =
            |c: Self| matches!(c, Self::Flat | Self::Sharp | Self::Creases | Self::FlatStrong | Self::CreasesStrong);
        let is_linear = |c: Self| matches!(c.algorithm(), Algorithm::Linear { .. });
        !(has_creases(self) && is_linear(other) || is_linear(self) && has_creases(other))
    }

    /// Runs the candidate. Returns the offset of each vertex from `input`; `guess` is the smoothed input. #V×3, model units
    pub(super) fn offsets(
        self,
        problem: &Problem,
        input: &[DVec3],
        guess: &[DVec3],
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        match self.algorithm() {
            Algorithm::Stay => Ok(vec![DVec3::ZERO; input.len()]),
            Algorithm::Linear { strength, passes } => {
                let strengths = problem.noise.strengths(|sigma| strength * sigma / f64::from(passes));
                smooth_linearly(problem, input, &strengths, passes, progress)
            }
            Algorithm::Map(prior) => problem.estimate(input, guess, &prior, progress),
            Algorithm::BilateralNormals(filter) => filter_normals(problem, input, &filter, progress),
            Algorithm::Learned => {
                let fixed = problem.noise.relative.iter().map(|sigma| *sigma == 0.0).collect();
                let deltas = learned::filtered(input, &problem.connectivity.mesh, fixed, progress)?;
                Ok(deltas.iter().enumerate().map(|(v, delta)| problem.constraint.projected(v, -*delta)).collect())
            }
        }
    }
}

/// Offsets of [`Algorithm::BilateralNormals`]. #V×3, model units
fn filter_normals(
    problem: &Problem,
    input: &[DVec3],
    filter: &BilateralNormals,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let Problem { connectivity, constraint, noise, .. } = *problem;
    let mesh = &connectivity.mesh;
    let normals = bilateral_normals::filtered(mesh, FaceGeometry::of(mesh, input), filter, progress)?;
    let fixed = noise.relative.iter().map(|sigma| *sigma == 0.0).collect();
    let mut updater = Updater::holding(fixed, input, mesh, filter.vertex_update);
    updater.follow(&normals, progress)?;
    let offsets = updater.positions().iter().zip(input).map(|(x, p)| *x - *p);
    Ok(offsets.enumerate().map(|(v, offset)| constraint.projected(v, offset)).collect())
}

/// Offsets of [`Algorithm::Linear`] with `passes` bi-Laplacian steps of these strengths (#V). #V×3, model units
fn smooth_linearly(
    problem: &Problem,
    input: &[DVec3],
    strengths: &[f64],
    passes: u32,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Cancelled> {
    let Problem { connectivity, constraint, noise, .. } = *problem;
    let local = LocalStrength { strength: strengths, edge: &noise.edge };
    let smooth = |mut x: Vec<DVec3>| -> Result<Vec<DVec3>, Cancelled> {
        for _ in 0..passes {
            x = connectivity.umbrella.smoothed_locally(&x, local, constraint, progress)?;
        }
        Ok(x)
    };
    let once = smooth(input.to_vec())?;
    let lost = smooth(input.iter().zip(&once).map(|(p, x)| *p - *x).collect())?;
    let smoothed: Vec<DVec3> = once.iter().zip(lost).map(|(x, lost)| *x + lost).collect();
    let normals = connectivity.vertex_normals(&smoothed);
    let offsets = smoothed.iter().zip(input).zip(normals).zip(&noise.stiffness).map(|(((x, p), n), stiffness)| {
        let tangential = (*x - *p).reject_from_normalized(n);
        *x - *p - tangential * (stiffness / (1.0 + stiffness))
    });
    Ok(offsets.collect())
}

#[cfg(test)]
mod tests;
