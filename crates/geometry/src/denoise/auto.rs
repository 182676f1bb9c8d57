//! Measures the noise, tries candidates, and mixes those that come nearest to the truth by an estimate that needs none.
//!
//! Candidates are [`Map`](super::Map) with priors from sharp to smooth and linear smoothing of three strengths. Each is
//! run on the mesh and once more for each probe, a little noise of known size; that tells its risk (see `auto/risk.rs`), and
//! the risks of all pairs, half of each, make the shares of the mixture. Large meshes are tried on patches, and only what has
//! a share is run on the whole. A mesh on which no noise can be told from the surface is left alone. Where noise is alike
//! between neighbours the estimate of the risk does not hold, and one robust prior with a large σ is used.

mod candidates;
mod patches;
mod risk;
mod trial;

pub use candidates::Candidate;

use super::map::{Net, Run};
use super::noise_level::{Kind, Look, NoiseLevel};
use super::umbrella::Freedom;
use super::{Boundary, Motion};
use crate::progress::{Cancelled, Progress};
use crate::surface::Surface;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;
use trial::Trial;

/// Settings of [`Denoiser::Auto`](super::Denoiser::Auto).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Auto {
    /// Where vertices may go.
    pub motion: Motion,
    /// What happens at the boundary.
    pub boundary: Boundary,
}

impl Default for Auto {
    /// Free; vertices at the boundary are held by their data like all others.
    fn default() -> Self {
        Self { motion: Motion::Free, boundary: Boundary::Free }
    }
}

/// What was found and done.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// The noise as measured.
    pub noise: NoiseLevel,
    /// What that says.
    pub kind: Kind,
    /// What the result is made of; shares sum to 1, the largest comes first.
    pub mixture: Vec<Share>,
}

/// A part of the result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Share {
    /// What was done.
    pub candidate: Candidate,
    /// How much of it is in the result.
    pub share: f64,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            Kind::None => write!(f, "no noise that could be told from the surface")?,
            Kind::Independent => write!(f, "noise of {:.3} mean edges", self.noise.sigma())?,
            Kind::Uneven => write!(f, "noise of about {:.3} mean edges, uneven", self.noise.sigma())?,
            Kind::Correlated => write!(
                f,
                "noise alike between neighbours, {:.3} mean edges at the finest and {:.3} over some edges",
                self.noise.fine, self.noise.coarse
            )?,
        }
        let mut separator = ": ";
        for Share { candidate, share } in &self.mixture {
            write!(f, "{separator}{:.0} % {candidate}", 100.0 * share)?;
            separator = ", ";
        }
        Ok(())
    }
}

/// δ of what has the least risk. #V×3, model units.
pub(super) fn deltas(surface: &Surface, settings: &Auto, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
    Ok(choose(surface, settings, progress)?.0)
}

/// δ of what has the least risk (#V×3, model units), and what that is.
pub fn choose(surface: &Surface, settings: &Auto, progress: &dyn Progress) -> Result<(Vec<DVec3>, Choice), Cancelled> {
    progress.check()?;
    let net = Net::of(surface);
    let look = Look::at(surface, &net, progress)?;
    let kind = look.level.kind();
    let input = surface.positions();
    let (candidates, ways) = match kind {
        Kind::None => (vec![Share { candidate: Candidate::Stay, share: 1.0 }], vec![vec![DVec3::ZERO; input.len()]]),
        _ => {
            let freedom = Freedom::of(surface, settings.motion, settings.boundary);
            let run = Run::of(&net, &freedom, look.sigma(), look.mean_edge);
            let smoothing = look.smoothing;
            let whole = Trial { run, input, normals: &look.normals, smoothing, judged: &[] };
            if kind == Kind::Correlated {
                whole.without_judging(vec![Share { candidate: candidates::robust(), share: 1.0 }], progress)?
            } else if let Some(part) = patches::part(surface, &net, patches::Sizes::default()) {
                let freedom = freedom.of_part(&part.vertices);
                let normals: Vec<DVec3> = part.vertices.iter().map(|&v| look.normals[v as usize]).collect();
                let run = Run { net: &part.net, freedom: &freedom, ..run };
                let input = part.surface.positions();
                let trial = Trial { run, input, normals: &normals, smoothing, judged: &part.judged };
                whole.without_judging(large(trial.judged(&candidates::all(), progress)?.0), progress)?
            } else {
                whole.judged(&candidates::all(), progress)?
            }
        }
    };
    let mixed = |v: usize| candidates.iter().zip(&ways).map(|(share, ways)| share.share * ways[v]).sum::<DVec3>();
    let deltas = net.without_folds(input, (0..input.len()).map(mixed).collect());
    let mut mixture: Vec<Share> = candidates.into_iter().filter(|share| share.share >= 0.005).collect();
    mixture.sort_by(|a, b| b.share.total_cmp(&a.share));
    Ok((deltas, Choice { noise: look.level, kind, mixture }))
}

/// Shares that are worth another run.
fn large(shares: Vec<Share>) -> Vec<Share> {
    const SMALL: f64 = 0.08;
    let mut kept: Vec<Share> = shares.into_iter().filter(|share| share.share > SMALL).collect();
    let total: f64 = kept.iter().map(|share| share.share).sum();
    kept.iter_mut().for_each(|share| share.share /= total);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::faces::{Faces, Shapes};
    use crate::noise::{self, Noise};
    use crate::progress::Silent;
    use crate::shapes;

    fn noisy(clean: &Surface, sigma: f64) -> Surface {
        let noise = Noise { sigma, direction: noise::Direction::Normal, share: 1.0, seed: 3 };
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
        assert!((choice.noise.sigma() / 0.2 - 1.0).abs() < 0.2, "{choice}");
        let total: f64 = choice.mixture.iter().map(|share| share.share).sum();
        // What is too small to be told of is below half a per cent each.
        assert!((total - 1.0).abs() < 0.05 && choice.kind == Kind::Independent, "{choice}");
    }

    #[test]
    fn a_clean_surface_stays_as_it_is() {
        for clean in [shapes::sphere(3), shapes::dented_sphere(4), shapes::cube(), shapes::grid(8)] {
            let (deltas, choice) = choose(&clean, &Auto::default(), &Silent).unwrap();
            assert!(deltas.iter().all(|d| *d == DVec3::ZERO), "{choice}");
            assert_eq!(choice.kind, Kind::None);
        }
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
        let candidates = &candidates::all()[3..];
        let mean = |net: &Net, input: &[DVec3], normals: &[DVec3], judged: &[bool]| {
            let run = Run::of(net, &freedom, look.sigma(), look.mean_edge);
            let trial = Trial { run, input, normals, smoothing: look.smoothing, judged };
            let shares = trial.judged(candidates, &Silent).unwrap().0;
            shares.iter().zip(0u32..).map(|(share, k)| share.share * f64::from(k)).sum::<f64>()
        };
        let normals: Vec<DVec3> = part.vertices.iter().map(|&v| look.normals[v as usize]).collect();
        let of_part = mean(&part.net, part.surface.positions(), &normals, &part.judged);
        let of_whole = mean(&net, noisy.positions(), &look.normals, &[]);
        // Both lie among the smoothest of five; one place apart is what a third of the faces may cost.
        assert!((of_part - of_whole).abs() < 1.0, "{of_part} {of_whole}");
    }
}
