//! Candidates tried side by side.

use super::Share;
use super::candidates::Candidate;
use super::risk::{Judge, Seen};
use crate::denoise::map::{Linear, Run};
use crate::denoise::noise_level;
use crate::progress::{Cancelled, Parts, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// What candidates are tried on.
#[derive(Clone, Copy)]
pub(super) struct Trial<'a> {
    pub(super) run: Run<'a>,
    /// #V×3, model units.
    pub(super) input: &'a [DVec3],
    /// μ for the first guess.
    pub(super) smoothing: f64,
    /// Which triangles are judged; all where it is empty.
    pub(super) judged: &'a [bool],
}

/// Ways of a candidate from the input, and how its result moves with each probe. #V×3 each, model units.
struct Tried {
    ways: Vec<DVec3>,
    responses: Vec<Vec<DVec3>>,
}

/// The mesh, or the mesh with a probe added, and a first guess for it.
struct Given {
    input: Vec<DVec3>,
    start: Vec<DVec3>,
}

/// Probes times triangles.
const BUDGET: usize = 40_000;
const PROBES: usize = 4;
/// Size of a probe in σ: large against the steps that robust weights make, small against the noise.
const EPSILON: f64 = 0.3;
/// Whose normals the noise is taken to go along. Along those of a smoothed mesh, which lean at creases, probes are moved the
/// way that candidates hold vertices least, and the noise that they keep across those normals goes unseen.
const UPRIGHT: Candidate = Candidate::Creases;
/// Square degrees: who is farther behind after the first probe gets no more of them.
const BEHIND: f64 = 15.0;
/// Square degrees: who is that much farther behind has a share e times smaller.
const TEMPERATURE: f64 = 0.3;

impl Trial<'_> {
    /// Ways of candidates whose shares are known.
    pub(super) fn without_judging(
        &self,
        shares: Vec<Share>,
        progress: &dyn Progress,
    ) -> Result<(Vec<Share>, Vec<Vec<DVec3>>), Cancelled> {
        let start = self.start(self.input, progress)?;
        let parts = Parts::new(progress, shares.len());
        let ways = |share: &Share| -> Result<Vec<DVec3>, Cancelled> {
            let candidate = if share.share > 0.0 { share.candidate } else { Candidate::Stay };
            parts.run(|| candidate.ways(&self.run, self.input, &start, progress))?
        };
        let ways = shares.par_iter().map(ways).collect::<Result<Vec<_>, _>>()?;
        Ok((shares, ways))
    }

    /// Shares of the candidates in the best mixture, and their ways.
    pub(super) fn judged(
        &self,
        candidates: &[Candidate],
        progress: &dyn Progress,
    ) -> Result<(Vec<Share>, Vec<Vec<DVec3>>), Cancelled> {
        let epsilon = EPSILON * self.length();
        let count = (BUDGET / self.run.net.faces.len().max(1)).clamp(1, PROBES);
        let parts = Parts::new(progress, candidates.len() * (1 + count) + 1);
        let ways = |candidate: Candidate, given: &Given| {
            parts.run(|| candidate.ways(&self.run, &given.input, &given.start, progress))?
        };
        let mesh = Given { start: self.start(self.input, progress)?, input: self.input.to_vec() };
        let all = candidates.par_iter().map(|&candidate| ways(candidate, &mesh));
        let still = all.collect::<Result<Vec<_>, _>>()?;
        let probes = match candidates.iter().position(|candidate| *candidate == UPRIGHT) {
            Some(k) => self.probes(count, &still[k]),
            None => self.probes(count, &ways(UPRIGHT, &mesh)?),
        };
        let given = |probe: &Vec<DVec3>| -> Result<Given, Cancelled> {
            let input: Vec<DVec3> = self.input.iter().zip(probe).map(|(p, b)| *p + epsilon * *b).collect();
            Ok(Given { start: self.start(&input, progress)?, input })
        };
        let given = probes.par_iter().map(given).collect::<Result<Vec<_>, _>>()?;
        // How these candidates move with each of these probes.
        let responses = |jobs: &[(usize, usize)]| -> Result<Vec<Vec<DVec3>>, Cancelled> {
            let one = |&(candidate, k): &(usize, usize)| -> Result<Vec<DVec3>, Cancelled> {
                let moved = ways(candidates[candidate], &given[k])?;
                let still = &still[candidate];
                Ok((0..moved.len()).map(|v| probes[k][v] + (moved[v] - still[v]) / epsilon).collect())
            };
            jobs.par_iter().map(one).collect()
        };
        let every: Vec<usize> = (0..candidates.len()).collect();
        let first = responses(&jobs(&every, 0..1))?;
        let tried =
            still.iter().zip(first).map(|(ways, response)| Tried { ways: ways.clone(), responses: vec![response] });
        let mut tried: Vec<Tried> = tried.collect();
        let judge = self.judge(candidates, &tried);
        let mut shares = mixture(&judge, candidates, &tried, &probes);
        if count > 1 {
            let alive: Vec<usize> = every.iter().copied().filter(|&k| shares.1[k] <= BEHIND).collect();
            let jobs = jobs(&alive, 1..count);
            for ((candidate, _), response) in jobs.iter().zip(responses(&jobs)?) {
                tried[*candidate].responses.push(response);
            }
            // All are judged again: trimming is against the mean of the same results as before.
            shares = mixture(&judge, candidates, &tried, &probes);
        }
        let found = candidates.iter().zip(shares.0).zip(shares.1);
        let share = |((&candidate, share), behind)| Share { candidate, share, behind: Some(behind) };
        Ok((found.map(share).collect(), tried.into_iter().map(|tried| tried.ways).collect()))
    }

    /// σ, model units.
    fn length(&self) -> f64 {
        self.run.sigma * self.run.mean_edge
    }

    /// Standard Gaussians along the normals of a result with these ways.
    fn probes(&self, count: usize, ways: &[DVec3]) -> Vec<Vec<DVec3>> {
        let result: Vec<DVec3> = self.input.iter().zip(ways).map(|(p, way)| *p + *way).collect();
        let normals = self.run.net.vertex_normals(&result);
        let seeds = (7..).map(|seed| noise_level::gaussians(self.input.len(), seed));
        let along = |gaussians: Vec<DVec3>| gaussians.iter().zip(&normals).map(|(g, n)| g.x * *n).collect();
        seeds.take(count).map(along).collect()
    }

    /// The input smoothed, as a first guess.
    fn start(&self, input: &[DVec3], progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        self.run.net.umbrella.smoothed(input, self.smoothing, self.run.freedom, progress)
    }

    /// A at the mean of all results but the noisy mesh itself.
    fn judge(&self, candidates: &[Candidate], tried: &[Tried]) -> Judge<'_> {
        let smoothed: Vec<&Tried> =
            candidates.iter().zip(tried).filter(|(c, _)| **c != Candidate::Stay).map(|(_, tried)| tried).collect();
        let share = 1.0 / smoothed.len().max(1) as f64;
        let mean = |v: usize| self.input[v] + share * smoothed.iter().map(|t| t.ways[v]).sum::<DVec3>();
        let mean: Vec<DVec3> = (0..self.input.len()).map(mean).collect();
        let mut linear = Linear::default();
        // Steeper changes are those of slivers, which say nothing about the whole.
        linear.measure(self.run.net, &mean, 3.0 / self.run.mean_edge);
        Judge { net: self.run.net, linear, variance: 2.0 * self.length() * self.length(), judged: self.judged }
    }
}

/// Each of these candidates with each of what it is given.
fn jobs(candidates: &[usize], given: std::ops::Range<usize>) -> Vec<(usize, usize)> {
    candidates.iter().flat_map(|&c| given.clone().map(move |k| (c, k))).collect()
}

/// Shares of the candidates, and how far behind each is in the best of its pairs, square degrees.
fn mixture(judge: &Judge, candidates: &[Candidate], tried: &[Tried], probes: &[Vec<DVec3>]) -> (Vec<f64>, Vec<f64>) {
    let seen: Vec<Seen> = tried.par_iter().map(|tried| judge.see(&tried.ways, &tried.responses, probes)).collect();
    let all: Vec<Vec<f64>> = seen.iter().map(Seen::risks).collect();
    let mean = |f: usize| all.iter().map(|risks| risks[f]).sum::<f64>() / all.len() as f64;
    let reference: Vec<f64> = (0..judge.net.faces.len()).map(mean).collect();
    let all_pairs = (0..seen.len()).flat_map(|a| (a..seen.len()).map(move |b| [a, b]));
    let pairs: Vec<[usize; 2]> = all_pairs.filter(|[a, b]| candidates[*a].mixes_with(candidates[*b])).collect();
    let risk = |[a, b]: &[usize; 2]| judge.difference([&seen[*a], &seen[*b]], &reference);
    let risks: Vec<f64> = pairs.par_iter().map(risk).collect();
    let least = risks.iter().copied().fold(f64::INFINITY, f64::min);
    let mut shares = vec![0.0; tried.len()];
    let mut behind = vec![f64::INFINITY; tried.len()];
    let mut total = 0.0;
    for (pair, risk) in pairs.iter().zip(risks) {
        let weight = (-(risk - least) / TEMPERATURE).exp();
        for &k in pair {
            shares[k] += weight / 2.0;
            behind[k] = behind[k].min(risk - least);
        }
        total += weight;
    }
    shares.iter_mut().for_each(|w| *w /= total);
    (shares, behind)
}
