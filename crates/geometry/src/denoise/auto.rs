//! Estimates the noise, evaluates candidates, and mixes those whose estimated error is lowest.
//!
//! Candidates are [`Map`](super::Map) with priors from flat to smooth, and linear smoothing of several strengths. Each is
//! run on the mesh and once more for each probe, a little noise of known size; Stein's unbiased risk estimate follows from
//! that (see `auto/sure.rs`) without knowing the clean mesh. The risks of all pairs of candidates, half of each, give the
//! shares of the mixture. Candidates that the first probe finds far behind get no further probes. Large meshes are
//! evaluated on patches, and only candidates with a share are run on the whole.
//!
//! A mesh whose noise cannot be told from its surface is left alone. Where the noise of neighbours is correlated, the risk
//! estimate does not hold, and one robust prior with a large σ is used.
//!
//! Noise along the normals, as that of scanners, leaves the tangential positions of vertices alone. The finest band says how
//! much tangential noise there can be at most, and the data terms of the candidates are stiffer in tangential directions
//! accordingly.

mod candidates;
mod evaluate;
mod subsample;
mod sure;

pub use candidates::Candidate;

use super::bilaplacian::BoundaryConstraint;
use super::connectivity::Connectivity;
use super::laplacian::BOUNDARY;
use super::map::{NOISE, NOISE_ACROSS, Problem};
use super::method::{DenoiseMethod, MethodInfo};
use super::noise_level::{self, Kind, NoiseEstimate, NoiseLevel};
use super::parameters::Parameter;
use super::vertex_update::MOTION;
use super::{Boundary, Motion};
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Progress};
use evaluate::{Evaluation, Mixture};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;
use subsample::{PatchSizes, subsample};

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
            motion: Motion::Free,
            boundary: Boundary::Free,
        }
    }
}

/// Parameters of the method.
pub(super) const PARAMETERS: &[Parameter] = &[
    NOISE,
    NOISE_ACROSS,
    Parameter::word::<Kind>("noise-kind", "/kind", "what the noise is like").label("noise kind").optional(),
    Parameter::words::<Candidate>("candidates", "/candidates", "what is tried; the best are blended").optional(),
    MOTION,
    BOUNDARY,
];

impl DenoiseMethod for Auto {
    const INFO: MethodInfo = MethodInfo {
        name: "auto",
        summary: "Measures the noise, tries several methods and blends the best; leaves clean meshes unchanged",
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
    /// Standard deviation σ of the noise that was assumed, mean edges; 0 where there is none.
    pub sigma: f64,
    /// Upper bound of the standard deviation in tangential directions that was assumed, mean edges.
    #[serde(default, rename = "across")]
    pub tangential_sigma: f64,
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
            Kind::None => write!(f, "no noise that could be told from the surface")?,
            Kind::Independent => write!(f, "noise of {:.3} mean edges", self.sigma)?,
            Kind::Uneven => write!(f, "noise of about {:.3} mean edges, uneven", self.sigma)?,
            Kind::Correlated => write!(
                f,
                "noise alike between neighbours, {:.3} mean edges at the finest and {:.3} over some edges",
                self.measured.fine, self.measured.coarse
            )?,
        }
        if matches!(self.kind, Kind::Independent | Kind::Uneven) && self.tangential_sigma < self.sigma {
            write!(f, ", at most {:.3} across the normals", self.tangential_sigma)?;
        }
        if let [CandidateShare { candidate: Candidate::Stay, .. }] = self.candidates[..] {
            return write!(f, ": left alone");
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

/// Deviation, mean edges, from which noise is heavy. In heavy noise the normals used for the tangential term are themselves
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
    let noise = NoiseEstimate::of(surface, &connectivity, progress)?;
    let (kind, sigma) = assumed_noise(settings, &noise.level);
    let candidates = settings.candidates.as_deref().unwrap_or(match kind {
        Kind::None => &[Candidate::Stay],
        Kind::Correlated => &[Candidate::Flat],
        Kind::Independent | Kind::Uneven => &Candidate::ALL,
    });
    // Without noise there is nothing to remove, and nothing to estimate a risk by.
    let noisy = sigma > noise_level::ROUNDING_NOISE && noise.mean_edge > 0.0 && !candidates.is_empty();
    let candidates = if noisy { candidates } else { &[Candidate::Stay] };
    let constraint = BoundaryConstraint::of(surface, settings.boundary);
    let tangential_stiffness = match settings.noise_across {
        Some(tangential) => noise_level::tangential_stiffness(sigma, tangential),
        None => noise.level.tangential_stiffness(kind),
    };
    let problem = Problem { tangential_stiffness, ..Problem::new(&connectivity, &constraint, sigma, noise.mean_edge) };
    let input = surface.positions();
    let whole = Evaluation { problem, input, smoothing: noise.smoothing, evaluated: &[] };
    let (mut shares, offsets) = mixture(surface, whole, candidates, progress)?;
    let mixed = |v: usize| shares.iter().zip(&offsets).map(|(share, of)| share.share * of[v]).sum::<DVec3>();
    let deltas = connectivity.undo_flips(input, (0..input.len()).map(mixed).collect(), sigma);
    shares.sort_by(|a, b| b.share.total_cmp(&a.share));
    let tangential_sigma = settings.noise_across.unwrap_or(noise.level.tangential);
    Ok((deltas, DenoiseChoice { measured: noise.level, kind, sigma, tangential_sigma, candidates: shares }))
}

/// Kind and deviation σ (mean edges) of the noise: those of the settings, or else as measured.
fn assumed_noise(settings: &Auto, measured: &NoiseLevel) -> (Kind, f64) {
    let kind = settings.kind.unwrap_or_else(|| match settings.noise {
        Some(sigma) if measured.kind() == Kind::None && sigma > 0.0 => Kind::Independent,
        _ => measured.kind(),
    });
    let sigma = if kind == Kind::None { 0.0 } else { settings.noise.unwrap_or_else(|| measured.sigma_as(kind)) };
    (kind, sigma)
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
    let Problem { connectivity, constraint, sigma, .. } = whole.problem;
    let is_heavy = sigma >= HEAVY_NOISE;
    let tangential_stiffness = if is_heavy { 0.0 } else { whole.problem.tangential_stiffness };
    let problem = Problem { tangential_stiffness, ..whole.problem };
    if let Some(part) = subsample(surface, connectivity, PatchSizes::default()) {
        let constraint = constraint.of_part(&part.vertices);
        let problem = Problem { connectivity: &part.connectivity, constraint: &constraint, ..problem };
        let (input, evaluated) = (part.surface.positions(), &part.evaluated[..]);
        let patches = Evaluation { problem, input, evaluated, ..whole };
        return whole.run(without_small_shares(patches.best_mixture(candidates, progress)?.0), progress);
    }
    let found = Evaluation { problem, ..whole }.best_mixture(candidates, progress)?;
    if tangential_stiffness < whole.problem.tangential_stiffness {
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
mod tests {
    use super::*;
    use crate::denoise::face_geometry::FaceGeometry;
    use crate::denoise::triangle_mesh::TriangleMesh;
    use crate::mesh::shapes;
    use crate::mesh::synthetic_noise::{self, Noise};
    use crate::progress::Silent;

    fn noisy(clean: &Surface, sigma: f64) -> Surface {
        noisy_in(clean, sigma, synthetic_noise::Direction::Normal)
    }

    fn noisy_in(clean: &Surface, sigma: f64, direction: synthetic_noise::Direction) -> Surface {
        let noise = Noise { sigma, direction, share: 1.0, seed: 3 };
        synthetic_noise::noisy(clean, &noise)
    }

    /// Mean angle between the normals of two surfaces, degrees.
    fn off(a: &Surface, positions: &[DVec3]) -> f64 {
        let mesh = TriangleMesh::of(a);
        let [a, b] = [a.positions(), positions].map(|x| FaceGeometry::of(&mesh, x).normals);
        a.iter().zip(&b).map(|(a, b)| a.angle_between(*b).to_degrees()).sum::<f64>() / mesh.face_count() as f64
    }

    #[test]
    fn noise_on_a_sphere_goes_and_the_choice_says_how_much_there_was() {
        let clean = shapes::sphere(3);
        let noisy = noisy(&clean, 0.2);
        let (deltas, choice) = choose(&noisy, &Auto::default(), &Silent).unwrap();
        let result = noisy.moved_by(&deltas);
        // From 22°. Curvature is 0.15 radians an edge, and the nearest smoothing by hand leaves 3.5°.
        assert!(off(&clean, &result) < 4.0, "{} {choice}", off(&clean, &result));
        // 642 vertices: the deviation is known to 3 %; three times that, and a tenth that the curvature may add.
        assert!((choice.sigma / 0.2 - 1.0).abs() < 0.2, "{choice}");
        let total: f64 = choice.candidates.iter().map(|share| share.share).sum();
        assert!((total - 1.0).abs() < 1e-12 && choice.kind == Kind::Independent, "{choice}");
    }

    #[test]
    fn noise_along_the_normals_is_told_from_noise_in_all_directions() {
        // With flats and edges: where all is smooth it makes no difference.
        let ball = shapes::sphere(4);
        let clean =
            ball.at(ball.positions().iter().map(|p| p.clamp(DVec3::splat(-0.75), DVec3::splat(0.75))).collect());
        let left = |noisy: &Surface, across: Option<f64>| {
            let (deltas, choice) = choose(noisy, &Auto { noise_across: across, ..Auto::default() }, &Silent).unwrap();
            let result = noisy.moved_by(&deltas);
            (off(&clean, &result), choice)
        };
        let along = noisy_in(&clean, 0.2, synthetic_noise::Direction::Normal);
        let (held, choice) = left(&along, None);
        assert!(
            choice.tangential_sigma < 0.5 * choice.sigma && choice.measured.tangential_stiffness(choice.kind) > 3.0,
            "{choice:?}"
        );
        // As if noise went in all directions.
        let (free, _) = left(&along, Some(0.2));
        assert!(held < 0.97 * free, "{held} {free}");
        // Of that much in all directions a third of the square goes along the normals.
        let (_, choice) = left(&noisy_in(&clean, 0.3, synthetic_noise::Direction::Random), None);
        assert!(
            choice.tangential_sigma > 0.9 * choice.measured.fine
                && choice.measured.tangential_stiffness(choice.kind) < 0.3,
            "{choice:?}"
        );
    }

    #[test]
    fn a_box_keeps_its_edges_in_much_noise() {
        let clean = shapes::gridded_box(24);
        let noisy = noisy(&clean, 0.3);
        let (deltas, choice) = choose(&noisy, &Auto::default(), &Silent).unwrap();
        let result = noisy.moved_by(&deltas);
        // From 33°. Judged along the normals of the smoothed mesh, half of it was linear smoothing, and 5.4° were
        // left; now 1.4°.
        assert!(off(&clean, &result) < 2.5, "{} {choice}", off(&clean, &result));
    }

    #[test]
    fn a_clean_surface_stays_as_it_is() {
        // Not the dented sphere: its dents differ from vertex to vertex, which is what noise does.
        for clean in [shapes::sphere(3), shapes::sphere(4), shapes::cube(), shapes::grid(8)] {
            let (deltas, choice) = choose(&clean, &Auto::default(), &Silent).unwrap();
            assert!(deltas.iter().all(|d| *d == DVec3::ZERO), "{} vertices: {choice:?}", deltas.len());
            assert_eq!(choice.kind, Kind::None);
        }
    }

    #[test]
    fn roughness_with_more_bumps_than_pits_stays() {
        let clean = shapes::sphere(4);
        let noisy = noisy(&clean, 0.2);
        let lift = |(p, q): (&DVec3, &DVec3)| *p + p.normalize() * (*q - *p).length();
        let rough = clean.at(clean.positions().iter().zip(noisy.positions()).map(lift).collect());
        let (deltas, choice) = choose(&rough, &Auto::default(), &Silent).unwrap();
        assert!(deltas.iter().all(|d| *d == DVec3::ZERO) && choice.measured.skewness > 0.125, "{choice:?}");
    }

    #[test]
    fn each_kind_of_noise_has_its_candidates() {
        let clean = shapes::sphere(4);
        let correlated = noise_level::tests::with_correlated_noise(&clean, 0.5, 3);
        let (deltas, choice) = choose(&correlated, &Auto::default(), &Silent).unwrap();
        assert_eq!(choice.kind, Kind::Correlated);
        assert_eq!(choice.candidates, [CandidateShare::all_of(Candidate::Flat)]);
        assert!(deltas.iter().any(|d| *d != DVec3::ZERO));
        let white = noisy(&shapes::sphere(2), 0.2);
        for kind in [Kind::Independent, Kind::Uneven] {
            let (_, choice) = choose(&white, &Auto { kind: Some(kind), ..Auto::default() }, &Silent).unwrap();
            assert_eq!((choice.kind, choice.candidates.len()), (kind, Candidate::ALL.len()));
        }
    }

    #[test]
    fn every_choice_can_be_overruled() {
        let noisy = noisy(&shapes::sphere(3), 0.2);
        let chosen = |settings: Auto| choose(&noisy, &settings, &Silent).unwrap();
        let (_, told) = chosen(Auto { noise: Some(0.1), ..Auto::default() });
        assert_eq!((told.sigma, told.kind), (0.1, Kind::Independent));
        for stays in [
            Auto { noise: Some(0.0), ..Auto::default() },
            Auto { kind: Some(Kind::None), ..Auto::default() },
            Auto { candidates: Some(vec![Candidate::Stay]), ..Auto::default() },
            Auto { candidates: Some(Vec::new()), ..Auto::default() },
        ] {
            let (deltas, choice) = chosen(stays);
            assert!(deltas.iter().all(|d| *d == DVec3::ZERO), "{choice}");
        }
        let (_, two) = chosen(Auto { candidates: Some(vec![Candidate::Smooth, Candidate::Linear]), ..Auto::default() });
        assert_eq!(two.candidates.len(), 2);
        let clean = shapes::sphere(3);
        let (deltas, _) = choose(&clean, &Auto { noise: Some(0.2), ..Auto::default() }, &Silent).unwrap();
        assert!(deltas.iter().any(|d| *d != DVec3::ZERO));
    }

    #[test]
    fn patches_give_about_the_shares_of_the_whole() {
        let noisy = noisy(&shapes::sphere(4), 0.2);
        let connectivity = Connectivity::of(&noisy);
        let noise = NoiseEstimate::of(&noisy, &connectivity, &Silent).unwrap();
        let sizes = PatchSizes { whole: 0, patches: 3, triangles: 600, margin: 4 };
        let part = subsample(&noisy, &connectivity, sizes).unwrap();
        let evaluated = part.evaluated.iter().filter(|evaluated| **evaluated).count();
        assert!(evaluated == 1800 && part.connectivity.mesh.face_count() < noisy.triangles().len(), "{evaluated}");
        let constraint = BoundaryConstraint::default();
        let candidates = &Candidate::ALL[4..];
        let mean = |connectivity: &Connectivity, input: &[DVec3], evaluated: &[bool]| {
            let sigma = noise.level.sigma_as(noise.level.kind());
            let problem = Problem::new(connectivity, &constraint, sigma, noise.mean_edge);
            let evaluation = Evaluation { problem, input, smoothing: noise.smoothing, evaluated };
            let shares = evaluation.best_mixture(candidates, &Silent).unwrap().0;
            shares.iter().zip(0u32..).map(|(share, k)| share.share * f64::from(k)).sum::<f64>()
        };
        let of_part = mean(&part.connectivity, part.surface.positions(), &part.evaluated);
        let of_whole = mean(&connectivity, noisy.positions(), &[]);
        // Both lie among the smoothest of five; one place apart is what a third of the faces may cost.
        assert!((of_part - of_whole).abs() < 1.0, "{of_part} {of_whole}");
    }
}
