//! Chooses for itself.

mod candidates;
mod patches;
mod risk;
mod trial;

pub use candidates::Candidate;

use super::map::{Net, Prior, Run};
use super::noise_level::{self, Look, NoiseLevel};
use super::umbrella::Freedom;
use super::{Boundary, Motion};
use crate::progress::{Cancelled, Progress};
use crate::surface::Surface;
use glam::DVec3;
use rayon::prelude::*;
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
    /// Free, at the boundary too: data hold the vertices there.
    fn default() -> Self {
        Self { motion: Motion::Free, boundary: Boundary::Free }
    }
}

/// What was found and done.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// The noise as measured.
    pub noise: NoiseLevel,
    /// How much of each candidate is in the result; they sum to 1.
    pub mixture: Vec<(Candidate, f64)>,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.4} {:.4} {:.4}:", self.noise.fine, self.noise.tail, self.noise.coarse)?;
        for (_, w) in &self.mixture {
            write!(f, " {w:.2}")?;
        }
        Ok(())
    }
}

pub(super) fn deltas(surface: &Surface, settings: &Auto, progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
    Ok(choose(surface, settings, progress)?.0)
}

/// δ of what has the least risk (#V×3, model units), and what that is.
pub fn choose(surface: &Surface, settings: &Auto, progress: &dyn Progress) -> Result<(Vec<DVec3>, Choice), Cancelled> {
    progress.check()?;
    let net = Net::of(surface);
    let look = Look::at(surface, &net, progress)?;
    let input = surface.positions();
    let sigma = look.sigma() * noise_level::knob("SIGF", 1.0);
    let mut choice = Choice { noise: look.level, mixture: Vec::new() };
    if !(sigma > noise_level::NOTHING && !look.level.is_clean() && look.mean_edge > 0.0) {
        return Ok((vec![DVec3::ZERO; input.len()], choice));
    }
    let freedom = Freedom::of(surface, settings.motion, settings.boundary);
    let run = Run {
        net: &net,
        freedom: &freedom,
        sigma,
        mean_edge: look.mean_edge,
        steps: noise_level::knob("CG", 40.0) as u32,
    };
    let whole = Trial { run, input, normals: &look.normals, smoothing: look.smoothing, judged: &[] };
    let mut candidates = candidates::all();
    let part = patches::part(surface, &net);
    let (shares, ways) = if look.level.inflation() > 1.5 {
        candidates = vec![Candidate::Map(Prior::default())];
        (vec![1.0], None)
    } else if let Some(part) = part {
        let freedom = freedom.of_part(&part.vertices);
        let normals: Vec<DVec3> = part.vertices.iter().map(|&v| look.normals[v as usize]).collect();
        let run = Run { net: &part.net, freedom: &freedom, ..run };
        let judged = &part.judged;
        let trial = Trial { run, input: part.surface.positions(), normals: &normals, judged, ..whole };
        (trial.shares(&candidates, progress)?.0, None)
    } else {
        let (shares, ways) = whole.shares(&candidates, progress)?;
        (shares, Some(ways))
    };
    let ways = match ways {
        Some(ways) => ways,
        None => {
            let start = whole.start(input, progress)?;
            let one = |(candidate, share): (&Candidate, &f64)| match *share > SMALL {
                true => candidate.ways(&run, input, &start, progress),
                false => Ok(Vec::new()),
            };
            candidates.par_iter().zip(&shares).map(one).collect::<Result<Vec<_>, _>>()?
        }
    };
    let total: f64 = shares.iter().filter(|share| **share > SMALL).sum();
    choice.mixture = candidates
        .into_iter()
        .zip(shares.iter().map(|share| if *share > SMALL { share / total } else { 0.0 }))
        .collect();
    let mixed = |v: usize| {
        let used = choice.mixture.iter().zip(&ways).filter(|((_, share), _)| *share > 0.0);
        used.map(|((_, share), ways)| *share * ways[v]).sum::<DVec3>()
    };
    let ways: Vec<DVec3> = (0..input.len()).map(mixed).collect();
    let mut result: Vec<DVec3> = input.iter().zip(&ways).map(|(p, way)| *p + way).collect();
    net.take_folds_back(input, &mut result);
    let back = |((p, way), x): ((&DVec3, &DVec3), &DVec3)| if x == p { DVec3::ZERO } else { -*way };
    Ok((input.iter().zip(&ways).zip(&result).map(back).collect(), choice))
}

/// Candidates with a smaller share are left out.
const SMALL: f64 = 0.03;
