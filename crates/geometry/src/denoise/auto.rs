//! Chooses for itself.

mod candidates;
mod risk;

pub use candidates::Candidate;

use super::map::{Linear, Net, Run};
use super::noise_level::{self, Look, NoiseLevel};
use super::umbrella::Freedom;
use super::{Boundary, Motion};
use crate::progress::{Cancelled, Progress};
use crate::surface::Surface;
use glam::DVec3;
use rayon::prelude::*;
use risk::Judge;
use serde::{Deserialize, Serialize};
use std::fmt;

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
    let sigma = look.sigma();
    let mut choice = Choice { noise: look.level, mixture: Vec::new() };
    if !(sigma > noise_level::NOTHING && look.mean_edge > 0.0) {
        return Ok((vec![DVec3::ZERO; input.len()], choice));
    }
    let freedom = Freedom::of(surface, settings.motion, settings.boundary);
    let run = Run { net: &net, freedom: &freedom, sigma, mean_edge: look.mean_edge, steps: 40 };
    let candidates = candidates::all();
    let length = sigma * look.mean_edge;
    let epsilon = 0.3 * length;
    let along: Vec<DVec3> =
        noise_level::gaussians(input.len(), 7).iter().zip(&look.normals).map(|(g, n)| g.x * *n).collect();
    let probed: Vec<DVec3> = input.iter().zip(&along).map(|(p, b)| *p + epsilon * *b).collect();
    let inputs = [input, &probed];
    let starts = inputs.map(|x| net.umbrella.smoothed(x, look.smoothing, &freedom, progress));
    let [start, probed_start] = starts;
    let starts = [start?, probed_start?];
    let jobs: Vec<(usize, usize)> = (0..candidates.len()).flat_map(|k| [(k, 0), (k, 1)]).collect();
    let ways = jobs
        .par_iter()
        .map(|&(k, probe)| candidates[k].ways(&run, inputs[probe], &starts[probe], progress))
        .collect::<Result<Vec<_>, _>>()?;
    let mean = |v: usize| input[v] + ways.iter().step_by(2).map(|w| w[v]).sum::<DVec3>() / candidates.len() as f64;
    let mean: Vec<DVec3> = (0..input.len()).map(mean).collect();
    let mut linear = Linear::default();
    linear.measure(&net, &mean, 3.0 / look.mean_edge);
    let mut probe = vec![DVec3::ZERO; net.faces.len()];
    linear.change(&net, &along, &mut probe);
    let judge = Judge { net: &net, linear, probe, variance: 2.0 * length * length };
    let seen: Vec<_> = ways
        .par_chunks(2)
        .map(|pair| {
            let response: Vec<DVec3> =
                (0..input.len()).map(|v| along[v] + (pair[1][v] - pair[0][v]) / epsilon).collect();
            judge.see(&pair[0], &response)
        })
        .collect();
    let mut weights = risk::weights(&judge, &seen, 0.5)?;
    if look.level.inflation() > 1.5 {
        weights.fill(0.0);
        weights[1] = 1.0;
    }
    let mut result: Vec<DVec3> = (0..input.len())
        .map(|v| input[v] + weights.iter().zip(ways.iter().step_by(2)).map(|(w, ways)| *w * ways[v]).sum::<DVec3>())
        .collect();
    net.take_folds_back(input, &mut result);
    choice.mixture = candidates.into_iter().zip(weights).collect();
    Ok((input.iter().zip(&result).map(|(p, x)| *p - x).collect(), choice))
}
