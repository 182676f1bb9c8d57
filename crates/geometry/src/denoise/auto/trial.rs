//! Candidates tried side by side.

use super::candidates::Candidate;
use super::risk::{Judge, Seen};
use crate::denoise::map::{Linear, Net, Run};
use crate::denoise::noise_level::{self, knob};
use crate::progress::{Cancelled, Parts, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// What candidates are tried on.
pub(super) struct Trial<'a> {
    pub(super) run: Run<'a>,
    /// #V×3, model units.
    pub(super) input: &'a [DVec3],
    /// Of the smoothed mesh: where the noise is along. #V×3
    pub(super) normals: &'a [DVec3],
    /// μ for the first guess.
    pub(super) smoothing: f64,
    /// Which triangles are judged; all where it is empty.
    pub(super) judged: &'a [bool],
}

/// Ways of a candidate from the input, and how they change with each probe.
struct Tried {
    ways: Vec<DVec3>,
    responses: Vec<Vec<DVec3>>,
}

/// The candidate that is between all others; risks are seen relative to it and to the mean of all.
const MIDDLE: usize = 2;
/// Triangles times probes.
const BUDGET: usize = 40_000;
const PROBES: usize = 4;
/// Square degrees: who is farther behind after the first probe is out.
const BEHIND: f64 = 15.0;
/// Square degrees: who is that far behind has a share e times smaller.
const TEMPERATURE: f64 = 0.5;

impl Trial<'_> {
    /// Shares of the candidates in the best mixture, and their ways.
    pub(super) fn shares(
        &self,
        candidates: &[Candidate],
        progress: &dyn Progress,
    ) -> Result<(Vec<f64>, Vec<Vec<DVec3>>), Cancelled> {
        let net = self.run.net;
        let length = self.run.sigma * self.run.mean_edge;
        let epsilon = 0.3 * length;
        let probes = (knob("BUDGET", BUDGET as f64) as usize / net.faces.len().max(1))
            .clamp(1, knob("PROBES", PROBES as f64) as usize);
        let gaussians = noise_level::gaussians(self.input.len(), knob("SEED", 7.0) as u64);
        let more = noise_level::gaussians(self.input.len(), knob("SEED", 7.0) as u64 + 1);
        let probe = |k: usize| -> Vec<DVec3> {
            let component = |v: usize| if k < 3 { gaussians[v][k] } else { more[v][k % 3] };
            (0..self.input.len()).map(|v| component(v) * self.normals[v]).collect()
        };
        let probes: Vec<Vec<DVec3>> = (0..probes).map(probe).collect();
        let moved =
            |k: usize| -> Vec<DVec3> { self.input.iter().zip(&probes[k]).map(|(p, b)| *p + epsilon * *b).collect() };
        let start = self.start(self.input, progress)?;
        let parts = Parts::new(progress, candidates.len() * (1 + probes.len()));
        let first: Vec<DVec3> = moved(0);
        let first_start = self.start(&first, progress)?;
        let ways = |candidate: &Candidate, input: &[DVec3], start: &[DVec3]| {
            parts.run(|| candidate.ways(&self.run, input, start, progress))?
        };
        let response = |still: &[DVec3], moved: &[DVec3], k: usize| -> Vec<DVec3> {
            (0..still.len()).map(|v| probes[k][v] + (moved[v] - still[v]) / epsilon).collect()
        };
        let jobs: Vec<(usize, bool)> = (0..candidates.len()).flat_map(|k| [(k, false), (k, true)]).collect();
        let mut done = jobs
            .par_iter()
            .map(|&(k, probed)| match probed {
                false => ways(&candidates[k], self.input, &start),
                true => ways(&candidates[k], &first, &first_start),
            })
            .collect::<Result<Vec<_>, _>>()?
            .into_iter();
        let mut tried: Vec<Tried> = Vec::new();
        while let (Some(ways), Some(moved)) = (done.next(), done.next()) {
            let responses = vec![response(&ways, &moved, 0)];
            tried.push(Tried { ways, responses });
        }
        let judge = self.judge(&tried);
        let all: Vec<usize> = (0..candidates.len()).collect();
        let mut shares = self.mixture(&judge, &tried, &probes, &all, 0);
        let alive: Vec<usize> = all.iter().copied().filter(|&k| shares.1[k] <= BEHIND).collect();
        if probes.len() > 1 {
            let inputs: Vec<Vec<DVec3>> = (1..probes.len()).map(moved).collect();
            let starts = inputs.par_iter().map(|x| self.start(x, progress)).collect::<Result<Vec<_>, _>>()?;
            let jobs: Vec<(usize, usize)> =
                alive.iter().flat_map(|&k| (1..probes.len()).map(move |p| (k, p))).collect();
            let found = jobs
                .par_iter()
                .map(|&(k, p)| {
                    let moved = ways(&candidates[k], &inputs[p - 1], &starts[p - 1])?;
                    Ok(response(&tried[k].ways, &moved, p))
                })
                .collect::<Result<Vec<_>, Cancelled>>()?;
            for ((k, _), response) in jobs.into_iter().zip(found) {
                tried[k].responses.push(response);
            }
            shares = self.mixture(&judge, &tried, &probes, &alive, probes.len() - 1);
        }
        Ok((shares.0, tried.into_iter().map(|tried| tried.ways).collect()))
    }

    /// The input smoothed, as a first guess.
    pub(super) fn start(&self, input: &[DVec3], progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        self.run.net.umbrella.smoothed(input, self.smoothing, self.run.freedom, progress)
    }

    /// A at the mean of the results.
    fn judge(&self, tried: &[Tried]) -> Judge<'_> {
        let share = 1.0 / tried.len() as f64;
        let mean = |v: usize| self.input[v] + share * tried.iter().map(|t| t.ways[v]).sum::<DVec3>();
        let mean: Vec<DVec3> = (0..self.input.len()).map(mean).collect();
        let mut linear = Linear::default();
        let net: &Net = self.run.net;
        linear.measure(net, &mean, 3.0 / self.run.mean_edge);
        let length = self.run.sigma * self.run.mean_edge;
        Judge { net, linear, variance: 2.0 * length * length, judged: self.judged }
    }

    /// Shares of those that are still `alive`, and how far behind each is in the best of its mixtures, square degrees.
    fn mixture(
        &self,
        judge: &Judge,
        tried: &[Tried],
        probes: &[Vec<DVec3>],
        alive: &[usize],
        last: usize,
    ) -> (Vec<f64>, Vec<f64>) {
        let seen: Vec<Seen> =
            alive.par_iter().map(|&k| judge.see(&tried[k].ways, &tried[k].responses[..=last], probes)).collect();
        let pairs: Vec<[usize; 2]> = (0..seen.len()).flat_map(|a| (a..seen.len()).map(move |b| [a, b])).collect();
        let every: Vec<Vec<f64>> = seen.iter().map(Seen::risks).collect();
        let middle = &every[alive.iter().position(|k| *k == MIDDLE).unwrap_or(0)];
        let mean = |f: usize| every.iter().map(|r| r[f]).sum::<f64>() / every.len() as f64;
        let reference: Vec<f64> = (0..middle.len()).map(|f| 0.5 * (middle[f] + mean(f))).collect();
        let risks: Vec<f64> =
            pairs.par_iter().map(|[a, b]| judge.difference([&seen[*a], &seen[*b]], &reference)).collect();
        let least = risks.iter().copied().fold(f64::INFINITY, f64::min);
        if knob("SHOW", 0.0) > 0.0 {
            eprintln!(
                "  {last} {:?}",
                pairs
                    .iter()
                    .zip(&risks)
                    .filter(|(p, _)| p[0] == p[1])
                    .map(|(p, r)| format!("{} {:.1}", alive[p[0]], r - least))
                    .collect::<Vec<_>>()
            );
        }
        let mut shares = vec![0.0; tried.len()];
        let mut behind = vec![f64::INFINITY; tried.len()];
        let mut total = 0.0;
        for (pair, risk) in pairs.iter().zip(risks) {
            let weight = (-(risk - least) / knob("TEMP", TEMPERATURE)).exp();
            for k in pair.map(|k| alive[k]) {
                shares[k] += weight / 2.0;
                behind[k] = behind[k].min(risk - least);
            }
            total += weight;
        }
        shares.iter_mut().for_each(|w| *w /= total);
        (shares, behind)
    }
}
