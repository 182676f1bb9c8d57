//! Measures the noise, tries candidates, and mixes those that come nearest to the truth by an estimate that needs none.
//!
//! Candidates are [`Map`](super::Map) with priors from flat to smooth and linear smoothing of several strengths. Each is
//! run on the mesh and once more for each probe, a little noise of known size; that tells its risk (see `auto/risk.rs`), and
//! the risks of all pairs, half of each, make the shares of the mixture. Those that the first probe finds far behind get no
//! more of them. Large meshes are tried on patches, and only what has a share is run on the whole. A mesh on which no noise
//! can be told from the surface is left alone. Where noise is alike between neighbours the estimate of the risk does not
//! hold, and one robust prior with a large σ is used.
//!
//! Noise along the normals leaves vertices where they are across them, and the finest band across the normals says how far
//! noise can have pushed them sideways at most. By that the candidates hold them, which is what tells noise along the normals
//! from noise in all directions.

mod candidates;
mod patches;
mod risk;
mod trial;

pub use candidates::Candidate;

use super::map::{Net, Run};
use super::noise_level::{self, Kind, Look, NoiseLevel};
use super::umbrella::Freedom;
use super::{Boundary, Motion};
use crate::progress::{Cancelled, Progress};
use crate::surface::Surface;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;
use trial::Trial;

/// Settings of [`Denoiser::Auto`](super::Denoiser::Auto).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Auto {
    /// σ, mean edge lengths; measured on the mesh where it is not given.
    pub noise: Option<f64>,
    /// The same across the normals, at most; measured where it is not given.
    pub noise_across: Option<f64>,
    /// What the noise is like; measured where it is not given.
    pub kind: Option<Kind>,
    /// What is tried; those that go with the kind of noise where it is not given.
    pub candidates: Option<Vec<Candidate>>,
    /// Where vertices may go.
    pub motion: Motion,
    /// What happens at the boundary.
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

/// What was found and done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// The noise as measured.
    pub measured: NoiseLevel,
    /// What it is taken to be like.
    pub kind: Kind,
    /// σ that it is taken to have, mean edges; 0 where there is none.
    pub sigma: f64,
    /// The same across the normals, at most.
    #[serde(default)]
    pub across: f64,
    /// What was tried; shares sum to 1, the largest comes first.
    pub candidates: Vec<Share>,
}

/// A part of the result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// What was tried.
    pub candidate: Candidate,
    /// How much of it is in the result, 0..=1.
    pub share: f64,
    /// How much more its estimated mean squared error of the normals is than that of the best pair, square degrees; none
    /// where it was not estimated.
    pub behind: Option<f64>,
}

impl Share {
    fn all_of(candidate: Candidate) -> Self {
        Self { candidate, share: 1.0, behind: None }
    }
}

impl fmt::Display for Choice {
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
        if matches!(self.kind, Kind::Independent | Kind::Uneven) && self.across < self.sigma {
            write!(f, ", at most {:.3} across the normals", self.across)?;
        }
        if let [Share { candidate: Candidate::Stay, .. }] = self.candidates[..] {
            return write!(f, ": left alone");
        }
        let mut separator = ": ";
        // What is less rounds to nothing.
        for Share { candidate, share, .. } in self.candidates.iter().filter(|share| share.share >= 0.005) {
            write!(f, "{separator}{:.0} % {candidate}", 100.0 * share)?;
            separator = ", ";
        }
        Ok(())
    }
}

/// σ, mean edges, beyond which results are judged without holding vertices.
const MUCH: f64 = 0.4;

/// δ of what has the least risk (#V×3, model units), and what that is; in the free form, see [`Denoiser::run`](super::Denoiser::run).
pub fn choose(surface: &Surface, settings: &Auto, progress: &dyn Progress) -> Result<(Vec<DVec3>, Choice), Cancelled> {
    progress.check()?;
    let net = Net::of(surface);
    let look = Look::at(surface, &net, progress)?;
    let kind = settings.kind.unwrap_or_else(|| match settings.noise {
        Some(sigma) if look.level.kind() == Kind::None && sigma > 0.0 => Kind::Independent,
        _ => look.level.kind(),
    });
    let sigma = if kind == Kind::None { 0.0 } else { settings.noise.unwrap_or_else(|| look.level.sigma_as(kind)) };
    let input = surface.positions();
    let candidates = settings.candidates.as_deref().unwrap_or(match kind {
        Kind::None => &[Candidate::Stay],
        Kind::Correlated => &[Candidate::Flat],
        Kind::Independent | Kind::Uneven => &Candidate::ALL,
    });
    // Without noise there is nothing to do, and nothing to measure a risk by.
    let noisy = sigma > noise_level::NOTHING && look.mean_edge > 0.0 && !candidates.is_empty();
    let candidates = if noisy { candidates } else { &[Candidate::Stay] };
    let freedom = Freedom::of(surface, settings.boundary);
    let held = settings.noise_across.map_or(look.level.held(kind), |across| noise_level::held(sigma, across));
    let run = Run { held, ..Run::of(&net, &freedom, sigma, look.mean_edge) };
    // Held by normals that much noise has turned, results depend on it in a way that is not linear any more, and their risk
    // comes out too low. Those that are not held are as far behind each other.
    let judged = Run { held: if sigma < MUCH { held } else { 0.0 }, ..run };
    let smoothing = look.smoothing;
    let whole = Trial { run, input, smoothing, judged: &[] };
    let (shares, ways) = if let [candidate] = candidates {
        whole.without_judging(vec![Share::all_of(*candidate)], progress)?
    } else if let Some(part) = patches::part(surface, &net, patches::Sizes::default()) {
        let freedom = freedom.of_part(&part.vertices);
        let run = Run { net: &part.net, freedom: &freedom, ..judged };
        let input = part.surface.positions();
        let trial = Trial { run, input, smoothing, judged: &part.judged };
        whole.without_judging(large(trial.judged(candidates, progress)?.0), progress)?
    } else {
        let found = Trial { run: judged, ..whole }.judged(candidates, progress)?;
        if judged.held < held { whole.without_judging(large(found.0), progress)? } else { found }
    };
    let mixed = |v: usize| shares.iter().zip(&ways).map(|(share, ways)| share.share * ways[v]).sum::<DVec3>();
    let deltas = net.without_folds(input, (0..input.len()).map(mixed).collect(), sigma);
    let mut candidates = shares;
    candidates.sort_by(|a, b| b.share.total_cmp(&a.share));
    let across = settings.noise_across.unwrap_or(look.level.across);
    Ok((deltas, Choice { measured: look.level, kind, sigma, across, candidates }))
}

/// Leaves out those that are not worth another run.
fn large(mut shares: Vec<Share>) -> Vec<Share> {
    const SMALL: f64 = 0.08;
    shares.iter_mut().filter(|share| share.share <= SMALL).for_each(|share| share.share = 0.0);
    let total: f64 = shares.iter().map(|share| share.share).sum();
    shares.iter_mut().for_each(|share| share.share /= total);
    shares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::faces::{Faces, Shapes};
    use crate::noise::{self, Noise};
    use crate::progress::Silent;
    use crate::shapes;

    fn noisy(clean: &Surface, sigma: f64) -> Surface {
        noisy_in(clean, sigma, noise::Direction::Normal)
    }

    fn noisy_in(clean: &Surface, sigma: f64, direction: noise::Direction) -> Surface {
        let noise = Noise { sigma, direction, share: 1.0, seed: 3 };
        let lifted = noise::displacements(clean, &noise);
        clean.at(clean.positions().iter().zip(lifted).map(|(p, d)| *p + d).collect())
    }

    /// Mean angle between the normals of two surfaces, degrees.
    fn off(a: &Surface, positions: &[DVec3]) -> f64 {
        let faces = Faces::of(a);
        let [a, b] = [a.positions(), positions].map(|x| Shapes::of(&faces, x).normals);
        a.iter().zip(&b).map(|(a, b)| a.angle_between(*b).to_degrees()).sum::<f64>() / faces.len() as f64
    }

    #[test]
    fn noise_on_a_sphere_goes_and_the_choice_says_how_much_there_was() {
        let clean = shapes::sphere(3);
        let noisy = noisy(&clean, 0.2);
        let (deltas, choice) = choose(&noisy, &Auto::default(), &Silent).unwrap();
        let result: Vec<DVec3> = noisy.positions().iter().zip(deltas).map(|(p, d)| *p - d).collect();
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
            let result: Vec<DVec3> = noisy.positions().iter().zip(deltas).map(|(p, d)| *p - d).collect();
            (off(&clean, &result), choice)
        };
        let along = noisy_in(&clean, 0.2, noise::Direction::Normal);
        let (held, choice) = left(&along, None);
        assert!(choice.across < 0.5 * choice.sigma && choice.measured.held(choice.kind) > 3.0, "{choice:?}");
        // As if noise went in all directions.
        let (free, _) = left(&along, Some(0.2));
        assert!(held < 0.97 * free, "{held} {free}");
        // Of that much in all directions a third of the square goes along the normals.
        let (_, choice) = left(&noisy_in(&clean, 0.3, noise::Direction::Random), None);
        assert!(choice.across > 0.9 * choice.measured.fine && choice.measured.held(choice.kind) < 0.3, "{choice:?}");
    }

    #[test]
    fn a_box_keeps_its_edges_in_much_noise() {
        let clean = shapes::gridded_box(24);
        let noisy = noisy(&clean, 0.3);
        let (deltas, choice) = choose(&noisy, &Auto::default(), &Silent).unwrap();
        let result: Vec<DVec3> = noisy.positions().iter().zip(deltas).map(|(p, d)| *p - d).collect();
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
        assert!(deltas.iter().all(|d| *d == DVec3::ZERO) && choice.measured.skew > 0.125, "{choice:?}");
    }

    #[test]
    fn each_kind_of_noise_has_its_candidates() {
        let clean = shapes::sphere(4);
        let correlated = noise_level::tests::with_correlated_noise(&clean, 0.5, 3);
        let (deltas, choice) = choose(&correlated, &Auto::default(), &Silent).unwrap();
        assert_eq!(choice.kind, Kind::Correlated);
        assert_eq!(choice.candidates, [Share::all_of(Candidate::Flat)]);
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
        let net = Net::of(&noisy);
        let look = Look::at(&noisy, &net, &Silent).unwrap();
        let sizes = patches::Sizes { whole: 0, patches: 3, patch: 600, margin: 4 };
        let part = patches::part(&noisy, &net, sizes).unwrap();
        let judged = part.judged.iter().filter(|judged| **judged).count();
        assert!(judged == 1800 && part.net.faces.len() < noisy.triangles().len(), "{judged}");
        let freedom = Freedom::default();
        let candidates = &Candidate::ALL[4..];
        let mean = |net: &Net, input: &[DVec3], judged: &[bool]| {
            let run = Run::of(net, &freedom, look.level.sigma_as(look.level.kind()), look.mean_edge);
            let trial = Trial { run, input, smoothing: look.smoothing, judged };
            let shares = trial.judged(candidates, &Silent).unwrap().0;
            shares.iter().zip(0u32..).map(|(share, k)| share.share * f64::from(k)).sum::<f64>()
        };
        let of_part = mean(&part.net, part.surface.positions(), &part.judged);
        let of_whole = mean(&net, noisy.positions(), &[]);
        // Both lie among the smoothest of five; one place apart is what a third of the faces may cost.
        assert!((of_part - of_whole).abs() < 1.0, "{of_part} {of_whole}");
    }
}
