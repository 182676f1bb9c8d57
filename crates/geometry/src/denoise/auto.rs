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
//! tell what the noise is or which candidates to take. In noise that neighbours do not share, the risk of what comes of it is estimated
//! as well, and says how far it counts beside the mixture.
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::denoise::{Auto, auto};
//! use planish_geometry::mesh::{surface::Surface, topology::Topology};
//! use planish_geometry::progress::Silent;
//!
//! // A flat sheet of 24 × 24 vertices, of which each is a little too high or too low.
//! let n = 24;
//! let height = |i: u32, j: u32| f64::from((i * 37 + j * 101 + i * j * 17) % 64) / 64.0 - 0.5;
//! let at = |k: u32| DVec3::new(f64::from(k % n), f64::from(k / n), 0.4 * height(k % n, k / n));
//! let corner = |k: u32| k / (n - 1) * n + k % (n - 1);
//! let faces = (0..(n - 1) * (n - 1)).map(corner).flat_map(|a| [vec![a, a + 1, a + n + 1], vec![a, a + n + 1, a + n]]);
//! let sheet = Surface::new(Topology::new((n * n) as usize, faces.collect()), (0..n * n).map(at).collect());
//!
//! let (deltas, choice) = auto::choose(&sheet, &Auto::default(), &Silent)?;
//! let rough = |heights: &dyn Fn(usize) -> f64| (0..deltas.len()).map(|v| heights(v).abs()).sum::<f64>();
//! let before = rough(&|v| sheet.positions()[v].z);
//! assert!(rough(&|v| sheet.positions()[v].z - deltas[v].z) < 0.4 * before, "{choice}");
//! # Ok::<(), planish_geometry::progress::Cancelled>(())
//! ```

mod assumed_noise;
mod candidates;
mod evaluate;
mod impulses;
mod subsample;
mod sure;
mod with_learned;

pub use super::choice::{Candidate, CandidateShare, DenoiseChoice};

use super::bilaplacian::BoundaryConstraint;
use super::boundary::{BOUNDARY, Boundary};
use super::connectivity::Connectivity;
use super::map::{NOISE, NOISE_ACROSS, Problem};
use super::method::{DenoiseMethod, MethodInfo};
use super::motion::{MOTION, Motion};
use super::noise_field::NoiseField;
use super::noise_level::{self, Kind, NoiseEstimate, NoiseLevel};
use super::parameters::{HUGE, Parameter};
use crate::mesh::locality::Localised;
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use assumed_noise::assumed_noise;
use evaluate::{Evaluation, Mixture};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use subsample::{PatchSizes, subsample};

/// Settings of [`Denoiser::Auto`](super::Denoiser::Auto).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Auto {
    /// σ, mean edge lengths; measured on the mesh where it is not given.
    pub noise: Option<f64>,
    /// Largest standard deviation of the tangential noise, mean edge lengths; measured if it is `None`.
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

/// Deviation, local edges, from which noise is heavy. In heavy noise the normals used for the tangential term are themselves
/// wrong, so results depend nonlinearly on the noise and the risk comes out too low. Candidates are then ranked without that
/// term: their order is the same.
const HEAVY_NOISE: f64 = 0.4;

/// Smallest share, after an evaluation on patches, for which a candidate is run on the whole mesh, and for which the learned filter is run
/// beside the mixture. On training shapes, leaving smaller shares out made results no worse.
const SMALLEST_SHARE: f64 = 0.15;

/// A surface whose noise has been measured, before any candidate is run.
struct Prepared<'a> {
    surface: &'a Surface,
    connectivity: Connectivity,
    constraint: BoundaryConstraint,
    level: NoiseLevel,
    kind: Kind,
    is_noisy: bool,
    noise: NoiseField,
    /// Positions that candidates start from: an outlier is no datum, and is where its neighbours suggest. #V×3, model units
    data: Vec<DVec3>,
    /// Fraction of the noisy vertices that have nearly all of the noise; 0 where all have about the same.
    hit: f64,
    /// Candidates for the mixture; only [`Candidate::Stay`] where nothing is to be done.
    candidates: Vec<Candidate>,
}

/// A result: displacements δ = p − p* (#V×3, model units) from the data, how many of them are as large as the noise allows, and which
/// candidates it is made of.
struct Found {
    deltas: Vec<DVec3>,
    bounded: usize,
    shares: Vec<CandidateShare>,
}

impl<'a> Prepared<'a> {
    fn of(surface: &'a Surface, settings: &Auto, progress: &dyn Progress) -> Result<Self, Cancelled> {
        progress.check()?;
        let connectivity = Connectivity::of(surface);
        let level = NoiseEstimate::of(surface, &connectivity, progress)?;
        let (kind, measured) = assumed_noise(surface, &connectivity, settings, &level, progress)?;
        let mut noise = measured.scaled(settings.strength);
        if settings.candidates.as_ref().is_some_and(|told| told.iter().all(|candidate| *candidate == Candidate::Stay)) {
            noise.outliers.clear();
        }
        let suited = || match noise.correlation {
            // How alike the noise is between neighbours is not known, so that no risk can be estimated.
            0 if kind == Kind::Correlated => vec![Candidate::Flat],
            _ => Candidate::suited_to(kind),
        };
        let mut candidates = settings.candidates.clone().unwrap_or_else(suited);
        // Without noise there is nothing to remove, and nothing to estimate a risk by.
        let is_noisy = kind != Kind::None && noise.typical() > noise_level::ROUNDING_NOISE && noise.mean_edge() > 0.0;
        if !is_noisy || candidates.is_empty() {
            candidates = vec![Candidate::Stay];
        }
        let constraint = BoundaryConstraint::of(surface, settings.boundary);
        let constraint = constraint.and_fixed(noise.relative.iter().map(|sigma| *sigma == 0.0));
        let mut data = surface.positions().to_vec();
        noise.outliers.iter().for_each(|&(v, p)| data[v as usize] = p);
        let level = level.level;
        let mut prepared =
            Self { surface, connectivity, constraint, level, kind, is_noisy, noise, data, hit: 0.0, candidates };
        if prepared.has_work() && prepared.noise.is_measured && prepared.noise.correlation == 0 {
            let found = impulses::by_vertex(&prepared.problem(), &prepared.data, progress)?;
            if let Some(found) = found {
                prepared.noise.relative = found.relative;
                prepared.hit = found.share;
            }
        }
        Ok(prepared)
    }

    /// Whether there is anything to do.
    fn has_work(&self) -> bool {
        self.candidates != [Candidate::Stay]
    }

    fn problem(&self) -> Problem<'_> {
        Problem::new(&self.connectivity, &self.constraint, &self.noise)
    }

    /// Offsets of the vertices (#V×3, model units) as displacements: unfolded, within the bound of the noise, and without flips.
    fn settled(&self, mut offsets: Vec<DVec3>) -> (Vec<DVec3>, usize) {
        self.connectivity.unfold(&self.data, &mut offsets, &self.noise);
        let bounded = self.noise.bound(&mut offsets);
        (self.connectivity.undo_flips(&self.data, offsets, &self.noise), bounded)
    }

    /// The prepared surface with other numbers of the vertices. Outliers are data no more.
    fn renumbered<'b>(&self, other: &'b Localised) -> Prepared<'b> {
        let Localised { surface, originals } = other;
        Prepared {
            surface,
            connectivity: Connectivity::of(surface),
            constraint: self.constraint.of_part(originals),
            level: self.level,
            kind: self.kind,
            is_noisy: self.is_noisy,
            noise: self.noise.of_part(originals),
            data: originals.iter().map(|&v| self.data[v as usize]).collect(),
            hit: self.hit,
            candidates: self.candidates.clone(),
        }
    }

    /// The mixture, together with the learned filter where that has a say.
    fn found(&self, trust_in_learned: f64, progress: &dyn Progress) -> Result<Found, Cancelled> {
        let trust = if self.may_be_learned() { trust_in_learned } else { 0.0 };
        // How noise that neighbours share is correlated is known too roughly to tell the two apart by an estimated error.
        let is_judged = trust > 0.0 && self.noise.correlation == 0;
        let (mixed, learned_share) = self.mixed(is_judged, progress)?;
        let trust = if learned_share > SMALLEST_SHARE { trust * learned_share } else { 0.0 };
        let learned = if trust > 0.0 { self.with_learned(&mixed, progress)? } else { None };
        Ok(match learned {
            Some(learned) => mixed.blended(learned, trust),
            None => mixed,
        })
    }

    /// The mixture of the candidates with the lowest estimated error, and the share that the learned filter should have beside it.
    fn mixed(&self, is_learned_judged: bool, progress: &dyn Progress) -> Result<(Found, f64), Cancelled> {
        let whole = Evaluation { problem: self.problem(), input: &self.data, evaluated: &[] };
        let found = mixture(self.surface, whole, &self.candidates, is_learned_judged, progress)?;
        let Mixture { shares, offsets, learned_share } = found;
        let mixed = |v: usize| shares.iter().zip(&offsets).map(|(share, of)| share.share * of[v]).sum::<DVec3>();
        let (deltas, bounded) = self.settled((0..self.data.len()).map(mixed).collect());
        Ok((Found { deltas, bounded, shares }, learned_share))
    }

    /// Whether the noise is such that the learned filter has a say.
    fn may_be_learned(&self) -> bool {
        // Where few vertices were hit, or heights rounded, the estimate knows more of the noise than the filter was told. Without a
        // measured field, as on depth images with shared noise, nothing says where the filter may act.
        let is_rounded = self.noise.correlation > 0 && self.noise.half_step.min_element().is_finite();
        self.has_work() && self.noise.is_measured && self.hit == 0.0 && !is_rounded
    }
}

impl Found {
    /// The mean of a mixture and what was made of it with the learned filter, with this share of the latter, 0..=1.
    fn blended(mut self, learned: Self, share: f64) -> Self {
        self.deltas.iter_mut().zip(learned.deltas).for_each(|(delta, learned)| *delta = delta.lerp(learned, share));
        let new =
            learned.shares.into_iter().map(|of| CandidateShare { share: of.share * share, ..of }).collect::<Vec<_>>();
        let kept = 1.0 - new.iter().map(|of| of.share).sum::<f64>();
        self.shares.iter_mut().for_each(|of| of.share *= kept);
        self.shares.extend(new);
        self.bounded = learned.bounded;
        self
    }
}

/// Denoises with the mixture of candidates of the lowest estimated error, and with the learned filter where the noise is what that was
/// trained for. Returns δ = p − p* (#V×3, model units), in the free form (see
/// [`Denoiser::run`](super::Denoiser::run)), and what was chosen.
pub fn choose(
    surface: &Surface,
    settings: &Auto,
    progress: &dyn Progress,
) -> Result<(Vec<DVec3>, DenoiseChoice), Cancelled> {
    choose_trusting(surface, settings, settings.trust_in_learned(), progress)
}

/// Runs [`Auto`] without the learned filter. Returns δ = p − p* (#V×3, model units) of the mixture of its other candidates, and what was
/// chosen. The network that mixes it into the result of the learned filter is fitted to it, and its error beside that of the whole says what the
/// learned filter is worth.
pub fn without_learned(
    surface: &Surface,
    settings: &Auto,
    progress: &dyn Progress,
) -> Result<(Vec<DVec3>, DenoiseChoice), Cancelled> {
    choose_trusting(surface, settings, 0.0, progress)
}

fn choose_trusting(
    surface: &Surface,
    settings: &Auto,
    trust_in_learned: f64,
    progress: &dyn Progress,
) -> Result<(Vec<DVec3>, DenoiseChoice), Cancelled> {
    let prepared = Prepared::of(surface, settings, progress)?;
    let Found { mut deltas, bounded, mut shares } = if prepared.has_work() {
        // Neighbourhoods that are near in memory save a third of the time.
        let localised = Localised::of(surface);
        let found = prepared.renumbered(&localised).found(trust_in_learned, progress)?;
        Found { deltas: localised.restored(&found.deltas), ..found }
    } else {
        prepared.mixed(false, progress)?.0
    };
    let noise = &prepared.noise;
    for &(v, p) in &noise.outliers {
        deltas[v as usize] += surface.positions()[v as usize] - p;
    }
    shares.sort_by(|a, b| b.share.total_cmp(&a.share));
    let choice = DenoiseChoice {
        measured: prepared.level,
        kind: prepared.kind,
        sigma: if prepared.is_noisy { noise.typical() } else { 0.0 },
        tangential_sigma: settings.noise_across.unwrap_or(noise.typical_across()),
        noisy: if prepared.is_noisy { noise.noisy_fraction() } else { 0.0 },
        unmeasured: noise.unmeasured,
        hit: prepared.hit,
        outliers: noise.outliers.len(),
        no_data: 0,
        bounded,
        candidates: shares,
        deviations: if prepared.is_noisy { noise.sigma().collect() } else { vec![0.0; deltas.len()] },
    };
    Ok((deltas, choice))
}

/// Evaluates the candidates, on patches if the mesh is large, and runs them on the whole mesh.
fn mixture(
    surface: &Surface,
    whole: Evaluation,
    candidates: &[Candidate],
    is_learned_judged: bool,
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
        let Mixture { shares, learned_share, .. } = patches.best_mixture(candidates, is_learned_judged, progress)?;
        return Ok(Mixture { learned_share, ..whole.run(without_small_shares(shares), progress)? });
    }
    let found = Evaluation { problem, ..whole }.best_mixture(candidates, is_learned_judged, progress)?;
    if is_heavy {
        let Mixture { shares, learned_share, .. } = found;
        return Ok(Mixture { learned_share, ..whole.run(without_small_shares(shares), progress)? });
    }
    Ok(found)
}

/// Shares with those set to zero that are not worth another run; the others make up for them. Where no share is large, none is small.
fn without_small_shares(mut shares: Vec<CandidateShare>) -> Vec<CandidateShare> {
    let largest = shares.iter().map(|share| share.share).fold(0.0, f64::max);
    let smallest = SMALLEST_SHARE.min(0.5 * largest);
    shares.iter_mut().filter(|share| share.share < smallest).for_each(|share| share.share = 0.0);
    let total: f64 = shares.iter().map(|share| share.share).sum();
    shares.iter_mut().for_each(|share| share.share /= total);
    shares
}

#[cfg(test)]
mod tests;
