//! Estimates the noise, evaluates candidates, and mixes those whose estimated error is lowest.
//!
//! Candidates are [`Map`](super::Map) with priors from flat to smooth, and linear smoothing of several strengths. Each is
//! run on the mesh and once more for each probe, a little noise of known size; Stein's unbiased risk estimate follows from
//! that (see `auto/sure.rs`) without knowing the clean mesh. The risks of all pairs of candidates, half of each, give the
//! shares of the mixture. Candidates that the first probe finds far behind get no further probes. Large meshes are
//! evaluated on patches, and only candidates with a share are run on the whole.
//!
//! Noise is a field (see `noise_field.rs`): each vertex has a deviation of its own, in the length of the edges around it. Data
//! terms, probes and the bound of how far a vertex may go follow it. Probes of noise that neighbours share are alike between
//! neighbours, too. A mesh or component whose noise cannot be told from its surface is left alone.
//!
//! Noise along the normals, as that of scanners, leaves the tangential positions of vertices alone. The finest band says how
//! much tangential noise there can be at most, and the data terms of the candidates are stiffer in tangential directions
//! accordingly. Spikes of single vertices are no data; noise of coordinates that were rounded stays within half a step.
//!
//! The mixture and the learned filter are then put together by a network of that filter (see `auto/with_learned.rs`), unless settings
//! tell what the noise is or which candidates to take.

mod candidates;
mod evaluate;
mod impulses;
mod subsample;
mod sure;
mod with_learned;

pub use candidates::Candidate;

use super::bilaplacian::BoundaryConstraint;
use super::connectivity::Connectivity;
use super::laplacian::BOUNDARY;
use super::map::{NOISE, NOISE_ACROSS, Problem};
use super::method::{DenoiseMethod, MethodInfo};
use super::noise_field::{NoiseField, Verdict};
use super::noise_level::{self, Kind, NoiseEstimate, NoiseLevel};
use super::parameters::{HUGE, Parameter};
use super::vertex_update::MOTION;
use super::{Boundary, Motion};
use crate::mesh::jagged::Index;
use crate::mesh::normals;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use evaluate::{Evaluation, Mixture};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;
use subsample::{PatchSizes, subsample};
use with_learned::with_learned;

/// Settings of [`Denoiser::Auto`](super::Denoiser::Auto).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Auto {
    /// σ, mean edge lengths; measured on the mesh where it is not given.
    pub noise: Option<f64>,
    /// Largest standard deviation of the noise across the normals, mean edge lengths; measured if it is `None`.
    pub noise_across: Option<f64>,
    /// Kind of the noise; measured if it is `None`.
    pub kind: Option<Kind>,
    /// Candidates that are tried; all that suit the kind of noise if it is `None`.
    pub candidates: Option<Vec<Candidate>>,
    /// Factor for the noise, measured or given: 0 leaves the mesh alone, 2 denoises as if there were twice as much.
    #[serde(default = "unchanged")]
    pub strength: f64,
    /// Where vertices may go.
    pub motion: Motion,
    /// Treatment of the boundary of an open mesh.
    pub boundary: Boundary,
}

impl Default for Auto {
    /// All measured; free, and vertices at the boundary are held by their data like all others.
    fn default() -> Self {
        Self {
            noise: None,
            noise_across: None,
            kind: None,
            candidates: None,
            strength: unchanged(),
            motion: Motion::Free,
            boundary: Boundary::Free,
        }
    }
}

impl Auto {
    /// How far the learned filter has a say, 0..=1: not at all where settings tell the noise or the candidates, of which it knows
    /// nothing, and the less the farther the strength is from 1, for which it was trained.
    fn trust_in_learned(&self) -> f64 {
        let is_told =
            self.noise.is_some() || self.noise_across.is_some() || self.kind.is_some() || self.candidates.is_some();
        if is_told || self.boundary == Boundary::Fixed { 0.0 } else { (1.0 - (self.strength - 1.0).abs()).max(0.0) }
    }
}

/// Strength of settings that do not mention it.
fn unchanged() -> f64 {
    1.0
}

/// Parameters of the method.
pub(super) const PARAMETERS: &[Parameter] = &[
    NOISE,
    NOISE_ACROSS,
    Parameter::word::<Kind>("noise-kind", "/kind", "what the noise is like").label("noise kind").optional(),
    Parameter::words::<Candidate>("candidates", "/candidates", "what is tried; the best are blended").optional(),
    Parameter::number("strength", "/strength", [0.0, HUGE], "factor for the noise; 0 leaves the mesh alone")
        .slider(3.0),
    MOTION,
    BOUNDARY,
];

impl DenoiseMethod for Auto {
    const INFO: MethodInfo = MethodInfo {
        name: "auto",
        summary: "Measures the noise, tries several methods and blends the best; leaves alone what shows none",
        reference: None,
        parameters: &[PARAMETERS],
    };

    fn deltas(&self, surface: &Surface, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        Ok(choose(surface, self, progress)?.0)
    }

    fn choose(
        &self,
        surface: &Surface,
        progress: &dyn Progress,
    ) -> Result<(Vec<DVec3>, Option<DenoiseChoice>), Cancelled> {
        let (deltas, choice) = choose(surface, self, progress)?;
        Ok((deltas, Some(choice)))
    }

    fn motion_mut(&mut self) -> Option<&mut Motion> {
        Some(&mut self.motion)
    }
}

/// Report of the automatic method: the noise it measured and the candidates it chose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DenoiseChoice {
    /// Noise as measured on the mesh.
    pub measured: NoiseLevel,
    /// Kind of noise that was assumed.
    pub kind: Kind,
    /// Standard deviation σ of the noise that was assumed, the median over the noisy vertices, local edges; 0 where there is none.
    pub sigma: f64,
    /// Upper bound of the standard deviation in tangential directions that was assumed, local edges.
    #[serde(default, rename = "across")]
    pub tangential_sigma: f64,
    /// Fraction of the vertices that are noisy, 0..=1.
    #[serde(default)]
    pub noisy: f64,
    /// Fraction of the vertices in places where nothing can be measured, 0..=1: too few vertices have faces all around them.
    #[serde(default)]
    pub unmeasured: f64,
    /// Fraction of the noisy vertices that have nearly all of the noise, 0..=1; 0 where all have about the same. `sigma` is that of
    /// the others then.
    #[serde(default)]
    pub hit: f64,
    /// Number of vertices that are spikes or craters beside their neighbours; they went to the surface of these.
    #[serde(default)]
    pub outliers: usize,
    /// Number of vertices that stand for "no data", tens of edges away from all that is around them; they stay.
    #[serde(default)]
    pub no_data: usize,
    /// Number of vertices that went as far as their noise can have pushed them.
    #[serde(default)]
    pub bounded: usize,
    /// Candidates with their shares, which add up to 1; the largest share comes first.
    pub candidates: Vec<CandidateShare>,
}

/// A candidate and its share of the result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CandidateShare {
    /// The candidate.
    pub candidate: Candidate,
    /// Share of the candidate in the result, 0..=1.
    pub share: f64,
    /// Estimated mean squared error of the normals beyond that of the best pair, square degrees; `None` where it was not
    /// estimated.
    #[serde(rename = "behind")]
    pub risk_gap: Option<f64>,
}

impl CandidateShare {
    fn all_of(candidate: Candidate) -> Self {
        Self { candidate, share: 1.0, risk_gap: None }
    }
}

impl fmt::Display for DenoiseChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            Kind::None if self.unmeasured > 0.5 => {
                write!(f, "noise that cannot be measured, since too few vertices have faces all around them")?;
            }
            Kind::None => write!(f, "no noise that could be told from the surface")?,
            _ if self.hit > 0.0 => {
                let percent = (100.0 * self.hit).max(1.0);
                write!(
                    f,
                    "noise that hits {percent:.0} % of the vertices, and {:.3} local edges at the others",
                    self.sigma
                )?;
            }
            Kind::Independent => write!(f, "noise of {:.3} local edges", self.sigma)?,
            Kind::Uneven => write!(f, "noise of about {:.3} local edges, uneven", self.sigma)?,
            Kind::Correlated => write!(f, "noise alike between neighbours, of {:.3} local edges", self.sigma)?,
        }
        if self.noisy > 0.0 && self.noisy < 0.95 {
            write!(f, " on {:.0} % of the surface", 100.0 * self.noisy)?;
        }
        if self.unmeasured > 0.0 && (self.kind != Kind::None || self.unmeasured <= 0.5) {
            // Less than one per cent is still something that nothing is known of.
            write!(f, ", not measured on {:.0} % of the surface", (100.0 * self.unmeasured).max(1.0))?;
        }
        if matches!(self.kind, Kind::Independent | Kind::Uneven) && self.tangential_sigma < self.sigma {
            write!(f, ", at most {:.3} across the normals", self.tangential_sigma)?;
        }
        match self.no_data {
            0 => {}
            1 => write!(f, ", one vertex without data")?,
            n => write!(f, ", {n} vertices without data")?,
        }
        let spikes = match self.outliers {
            1 => "one spike".to_owned(),
            n => format!("{n} spikes"),
        };
        if let [CandidateShare { candidate: Candidate::Stay, .. }] = self.candidates[..] {
            return match self.outliers {
                0 => write!(f, ": left alone"),
                _ => write!(f, ": {spikes} removed, all else left alone"),
            };
        }
        if self.outliers > 0 {
            write!(f, ", {spikes}")?;
        }
        let mut separator = ": ";
        // Smaller shares would be printed as 0 %.
        for CandidateShare { candidate, share, .. } in self.candidates.iter().filter(|share| share.share >= 0.005) {
            write!(f, "{separator}{:.0} % {candidate}", 100.0 * share)?;
            separator = ", ";
        }
        Ok(())
    }
}

/// Deviation, local edges, from which noise is heavy. In heavy noise the normals used for the tangential term are themselves
/// wrong, so results depend nonlinearly on the noise and the risk comes out too low. Candidates are then ranked without that
/// term: their order is the same.
const HEAVY_NOISE: f64 = 0.4;

/// Smallest share, after an evaluation on patches, for which a candidate is run on the whole mesh.
const SMALLEST_SHARE: f64 = 0.08;

/// Denoises with the mixture of candidates of the lowest estimated error. Returns δ = p − p* (#V×3, model units), in the free
/// form (see [`Denoiser::run`](super::Denoiser::run)), and what was chosen.
pub fn choose(
    surface: &Surface,
    settings: &Auto,
    progress: &dyn Progress,
) -> Result<(Vec<DVec3>, DenoiseChoice), Cancelled> {
    progress.check()?;
    let connectivity = Connectivity::of(surface);
    let level = NoiseEstimate::of(surface, &connectivity, progress)?;
    let (kind, measured) = assumed_noise(surface, &connectivity, settings, &level, progress)?;
    let mut noise = measured.scaled(settings.strength);
    if settings.candidates.as_ref().is_some_and(|told| told.iter().all(|candidate| *candidate == Candidate::Stay)) {
        noise.outliers.clear();
    }
    let suited = match noise.correlation {
        // How alike the noise is between neighbours is not known, so that no risk can be estimated.
        0 if kind == Kind::Correlated => vec![Candidate::Flat],
        _ => Candidate::suited_to(kind),
    };
    let candidates = settings.candidates.as_deref().unwrap_or(&suited);
    // Without noise there is nothing to remove, and nothing to estimate a risk by.
    let is_noisy = kind != Kind::None && noise.typical() > noise_level::ROUNDING_NOISE && noise.mean_edge() > 0.0;
    let candidates = if is_noisy && !candidates.is_empty() { candidates } else { &[Candidate::Stay] };
    let constraint = BoundaryConstraint::of(surface, settings.boundary);
    let constraint = constraint.and_fixed(noise.relative.iter().map(|sigma| *sigma == 0.0));
    // An outlier is no datum: it starts from where its neighbours suggest.
    let input = surface.positions();
    let mut data = input.to_vec();
    noise.outliers.iter().for_each(|&(v, p)| data[v as usize] = p);
    let mut hit = 0.0;
    if is_noisy && noise.is_measured && noise.correlation == 0 && candidates != [Candidate::Stay] {
        let problem = Problem::new(&connectivity, &constraint, &noise);
        if let Some(found) = impulses::by_vertex(&problem, &data, progress)? {
            noise.relative = found.relative;
            hit = found.share;
        }
    }
    let problem = Problem::new(&connectivity, &constraint, &noise);
    let whole = Evaluation { problem, input: &data, evaluated: &[] };
    let (mut shares, offsets) = mixture(surface, whole, candidates, progress)?;
    let mixed = |v: usize| shares.iter().zip(&offsets).map(|(share, of)| share.share * of[v]).sum::<DVec3>();
    let mut mixed: Vec<DVec3> = (0..input.len()).map(mixed).collect();
    connectivity.unfold(&data, &mut mixed, &noise);
    let mut bounded = noise.bound(&mut mixed);
    let mut deltas = connectivity.undo_flips(&data, mixed, &noise);
    let mut learned_share = 0.0;
    let trust = settings.trust_in_learned();
    // Where few vertices were hit, or heights rounded, the estimate knows more of the noise than the filter was told. Without a measured
    // field, as on depth images with shared noise, nothing says where the filter may act.
    let is_known_better = hit > 0.0 || noise.correlation > 0 && noise.half_step.min_element().is_finite();
    let may_act = is_noisy && noise.is_measured && !is_known_better;
    if may_act && trust > 0.0 && candidates != [Candidate::Stay] {
        let cleaned = surface.at(data.clone());
        if let Some(found) = with_learned(&cleaned, &connectivity, &noise, &deltas, progress)? {
            learned_share = trust * found.share;
            bounded = found.bounded;
            deltas.iter_mut().zip(found.deltas).for_each(|(delta, learned)| *delta = delta.lerp(learned, trust));
        }
    }
    for &(v, p) in &noise.outliers {
        deltas[v as usize] += input[v as usize] - p;
    }
    if learned_share > 0.0 {
        shares.iter_mut().for_each(|share| share.share *= 1.0 - learned_share);
        shares.push(CandidateShare { candidate: Candidate::Learned, share: learned_share, risk_gap: None });
    }
    shares.sort_by(|a, b| b.share.total_cmp(&a.share));
    let choice = DenoiseChoice {
        measured: level.level,
        kind,
        sigma: if is_noisy { noise.typical() } else { 0.0 },
        tangential_sigma: settings.noise_across.unwrap_or(noise.typical_across()),
        noisy: if is_noisy { noise.noisy_fraction() } else { 0.0 },
        unmeasured: noise.unmeasured,
        hit,
        outliers: noise.outliers.len(),
        no_data: 0,
        bounded,
        candidates: shares,
    };
    Ok((deltas, choice))
}

/// True for a triangulated depth image: nearly all vertices have six neighbours, and nearly all faces look to one side. There the
/// two bands of the whole mesh tell shared noise from a surface; on other meshes the second one is mostly surface.
fn is_range_image(surface: &Surface) -> bool {
    /// Largest standard deviation of the valence.
    const LARGEST: f64 = 0.72;
    /// Least fraction of the faces that look to the side of their mean. On closed surfaces it is a half; noise turns some of any.
    const FACING: f64 = 0.75;
    let topology = surface.topology();
    let inner = (0..topology.vertex_count() as Index).filter(|&v| !topology.is_boundary(v) && !topology.is_isolated(v));
    let (count, sum, squares) = inner
        .map(|v| topology.rings().get(v).len() as f64)
        .fold((0.0, 0.0, 0.0), |(n, s, q), x| (n + 1.0, s + x, q + x * x));
    let is_grid = count > 0.0 && squares / count - (sum / count).powi(2) < LARGEST * LARGEST;
    let normals: Vec<DVec3> = normals::face_normals(surface);
    let mean: DVec3 = normals.iter().sum();
    let facing = normals.iter().filter(|n| n.dot(mean) > 0.0).count();
    is_grid && facing as f64 > FACING * normals.len() as f64
}

/// Kind of the noise and its field: those of the settings, or else as measured.
fn assumed_noise(
    surface: &Surface,
    connectivity: &Connectivity,
    settings: &Auto,
    level: &NoiseEstimate,
    progress: &dyn Progress,
) -> Result<(Kind, NoiseField), Cancelled> {
    let white = level.level.kind();
    let count = surface.positions().len();
    if settings.noise.is_some() || settings.kind == Some(Kind::None) {
        let sigma = settings.noise.filter(|_| settings.kind != Some(Kind::None)).unwrap_or(0.0);
        let kind = settings.kind.unwrap_or(if white == Kind::None && sigma > 0.0 { Kind::Independent } else { white });
        let stiffness = match settings.noise_across {
            Some(tangential) => noise_level::tangential_stiffness(sigma, tangential),
            None => level.level.tangential_stiffness(kind),
        };
        return Ok((kind, NoiseField::uniform(count, sigma, level.mean_edge, stiffness)));
    }
    let fine = level.level.fine * level.mean_edge;
    // White noise is told from a surface most surely by the finest band of the whole mesh, all other noise by the networks.
    let is_white = matches!(white, Kind::Independent | Kind::Uneven);
    if white == Kind::Correlated && settings.kind.is_none() && is_range_image(surface) {
        if let Some(noise) = NoiseField::terraces(surface, connectivity, fine) {
            return Ok((white, noise));
        }
        let sigma = level.level.sigma_as(white);
        return Ok((white, NoiseField::uniform(count, sigma, level.mean_edge, 0.0)));
    }
    // A few hundred vertices are too few regions for the networks, and their coarse band is the curvature of the shape.
    const FEW: usize = 400;
    let is_white = is_white || white == Kind::Correlated && settings.kind.is_none() && count < FEW;
    let verdict = if is_white && settings.kind.is_none_or(|kind| kind == white) {
        Verdict::White
    } else if settings.kind.is_some() || NoiseField::is_rounding(surface, connectivity, fine) {
        Verdict::Noisy
    } else {
        Verdict::ByEvidence
    };
    let mut noise = NoiseField::measured(surface, connectivity, verdict, progress)?;
    if white == Kind::Uneven && verdict == Verdict::White && is_range_image(surface) {
        // The medians of the regions are too low where the noise of a depth camera is uneven, as one real frame showed; the tail of
        // the whole mesh is not.
        let typical = noise.typical() * noise.mean_edge();
        if typical > 0.0 {
            noise = noise.scaled((level.level.sigma_as(white) * level.mean_edge / typical).max(1.0));
        }
    }
    if noise.unmeasured == 1.0 && verdict == Verdict::White {
        // A mesh of a few dozen vertices has no regions, but a finest band.
        let stiffness = level.level.tangential_stiffness(white);
        noise = NoiseField::uniform(count, level.level.sigma_as(white), level.mean_edge, stiffness);
    }
    if let Some(tangential) = settings.noise_across {
        let stiffness = noise_level::tangential_stiffness(noise.typical(), tangential);
        noise.stiffness.fill(stiffness);
    }
    let kind = settings.kind.unwrap_or(match white {
        _ if noise.noisy_fraction() == 0.0 => Kind::None,
        _ if noise.correlation > 0 => Kind::Correlated,
        Kind::Uneven => Kind::Uneven,
        _ => Kind::Independent,
    });
    Ok((kind, noise))
}

/// Evaluates the candidates, on patches if the mesh is large, and runs them on the whole mesh.
fn mixture(
    surface: &Surface,
    whole: Evaluation,
    candidates: &[Candidate],
    progress: &dyn Progress,
) -> Result<Mixture, Cancelled> {
    if let [candidate] = candidates {
        return whole.run(vec![CandidateShare::all_of(*candidate)], progress);
    }
    let Problem { connectivity, constraint, noise, .. } = whole.problem;
    let is_heavy = noise.typical() >= HEAVY_NOISE && noise.stiffness.iter().any(|stiffness| *stiffness > 0.0);
    let free = is_heavy.then(|| NoiseField { stiffness: vec![0.0; noise.stiffness.len()], ..noise.clone() });
    let noise = free.as_ref().unwrap_or(noise);
    let problem = Problem { noise, ..whole.problem };
    if let Some(part) = subsample(surface, connectivity, PatchSizes::default()) {
        let constraint = constraint.of_part(&part.vertices);
        let noise = noise.of_part(&part.vertices);
        let problem = Problem { connectivity: &part.connectivity, constraint: &constraint, noise: &noise, ..problem };
        let (input, evaluated) = (part.surface.positions(), &part.evaluated[..]);
        let patches = Evaluation { problem, input, evaluated };
        return whole.run(without_small_shares(patches.best_mixture(candidates, progress)?.0), progress);
    }
    let found = Evaluation { problem, ..whole }.best_mixture(candidates, progress)?;
    if is_heavy {
        return whole.run(without_small_shares(found.0), progress);
    }
    Ok(found)
}

/// Shares with those set to zero that are not worth another run; the others make up for them.
fn without_small_shares(mut shares: Vec<CandidateShare>) -> Vec<CandidateShare> {
    shares.iter_mut().filter(|share| share.share <= SMALLEST_SHARE).for_each(|share| share.share = 0.0);
    let total: f64 = shares.iter().map(|share| share.share).sum();
    shares.iter_mut().for_each(|share| share.share /= total);
    shares
}

#[cfg(test)]
mod tests;
