//! Evaluation of candidates: each is run on the mesh and on perturbed meshes, and its risk makes its share of the result.

use super::sure::{Response, SureEstimator};
use crate::denoise::choice::{Candidate, CandidateShare};
use crate::denoise::learned;
use crate::denoise::map::{LinearisedNormals, Problem};
use crate::mesh::jagged::Index;
use crate::progress::{Cancelled, Parts, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// A mesh on which candidates are evaluated.
#[derive(Clone, Copy)]
pub(super) struct Evaluation<'a> {
    pub(super) problem: Problem<'a>,
    /// Noisy positions. #V×3, model units
    pub(super) input: &'a [DVec3],
    /// True for triangles that are evaluated. #T, or empty where all are
    pub(super) evaluated: &'a [bool],
}

/// A mixture of candidates, and how far the learned filter may go on from it.
pub(super) struct Mixture {
    /// Candidates with their shares.
    pub(super) shares: Vec<CandidateShare>,
    /// Offsets of each candidate from the input. #V×3 each, model units
    pub(super) offsets: Vec<Vec<DVec3>>,
    /// Share of what the learned filter makes of the mixture, 0..=1; 1 where it was not estimated.
    pub(super) learned_share: f64,
}

/// The result of a candidate and its derivative along each probe. #V×3 each, model units
struct CandidateResult {
    offsets: Vec<DVec3>,
    derivatives: Vec<Vec<DVec3>>,
}

/// The mesh, or the mesh with a probe added, and a first guess for it.
struct PerturbedInput {
    input: Vec<DVec3>,
    guess: Vec<DVec3>,
}

/// Number of triangles, summed over the probes, that a candidate is evaluated on: small meshes need more probes for a risk
/// that is as certain.
const TRIANGLE_BUDGET: usize = 6_000;
/// Largest number of probes.
const MAX_PROBES: usize = 4;
/// Size of a probe over that of the noise: large against the steps that robust weights make, small against the noise.
const PROBE_SIZE: f64 = 0.3;
/// Probes displace vertices along the normals of this candidate's result. The normals of a smoothed mesh are tilted at
/// creases; probes along them would excite the tangential directions that the candidates barely constrain, and the risk
/// would come out too low.
const PROBE_DIRECTION_CANDIDATE: Candidate = Candidate::Creases;
/// Candidates whose risk is higher than the lowest one by more than this after the first probe get no further probes,
/// square degrees.
const PRUNE_GAP_DEG2: f64 = 15.0;
/// Risk difference by which a candidate's weight falls by a factor of e, square degrees.
const TEMPERATURE_DEG2: f64 = 0.3;

impl Evaluation<'_> {
    /// Runs candidates whose shares are known; those with a share of zero are not run, and their offsets are zero.
    pub(super) fn run(&self, shares: Vec<CandidateShare>, progress: &dyn Progress) -> Result<Mixture, Cancelled> {
        let guess = self.guess(self.input, progress)?;
        let parts = Parts::new(progress, shares.len());
        let offsets = |share: &CandidateShare| -> Result<Vec<DVec3>, Cancelled> {
            let candidate = if share.share > 0.0 { share.candidate } else { Candidate::Stay };
            parts.run(|| candidate.offsets(&self.problem, self.input, &guess, progress))?
        };
        let offsets = shares.par_iter().map(offsets).collect::<Result<Vec<_>, _>>()?;
        Ok(Mixture { shares, offsets, learned_share: 1.0 })
    }

    /// Runs the candidates, estimates their risks and gives each its share of the best mixture; also estimates the risk of what the
    /// learned filter makes of it, if that is to be judged.
    pub(super) fn best_mixture(
        &self,
        candidates: &[Candidate],
        is_learned_judged: bool,
        progress: &dyn Progress,
    ) -> Result<Mixture, Cancelled> {
        let probe_count = (TRIANGLE_BUDGET / self.problem.connectivity.mesh.face_count().max(1)).clamp(1, MAX_PROBES);
        let parts = Parts::new(progress, candidates.len() * (1 + probe_count) + 1);
        let run = |candidate: Candidate, input: &PerturbedInput| {
            parts.run(|| candidate.offsets(&self.problem, &input.input, &input.guess, progress))?
        };
        let mesh = PerturbedInput { guess: self.guess(self.input, progress)?, input: self.input.to_vec() };
        let offsets = candidates.par_iter().map(|&candidate| run(candidate, &mesh));
        let offsets = offsets.collect::<Result<Vec<_>, _>>()?;
        let probes = match candidates.iter().position(|candidate| *candidate == PROBE_DIRECTION_CANDIDATE) {
            Some(k) => self.probes(probe_count, &offsets[k]),
            None => self.probes(probe_count, &run(PROBE_DIRECTION_CANDIDATE, &mesh)?),
        };
        let perturbed = probes.par_iter().map(|probe| self.perturbed(probe, progress));
        let perturbed = perturbed.collect::<Result<Vec<_>, _>>()?;
        let derivative = |&(candidate, k): &(usize, usize)| -> Result<Vec<DVec3>, Cancelled> {
            let moved = run(candidates[candidate], &perturbed[k])?;
            let (probe, still) = (&probes[k], &offsets[candidate]);
            Ok((0..moved.len()).map(|v| probe[v] + (moved[v] - still[v]) / PROBE_SIZE).collect())
        };
        let derivatives = |jobs: &[(usize, usize)]| -> Result<Vec<Vec<DVec3>>, Cancelled> {
            jobs.par_iter().map(derivative).collect()
        };
        let all: Vec<usize> = (0..candidates.len()).collect();
        let of_first = derivatives(&jobs(&all, 0..1))?;
        let result = |(offsets, derivative)| CandidateResult { offsets, derivatives: vec![derivative] };
        let mut results: Vec<CandidateResult> = offsets.iter().cloned().zip(of_first).map(result).collect();
        let estimator = self.estimator(candidates, &results);
        let mixes = |a: usize, b: usize| candidates[a].mixes_with(candidates[b]);
        let mut weights = mixture_weights(&estimator, mixes, &results, &probes);
        if probe_count > 1 {
            let survivors: Vec<usize> = all.iter().copied().filter(|&k| weights[k].1 <= PRUNE_GAP_DEG2).collect();
            let jobs = jobs(&survivors, 1..probe_count);
            for ((candidate, _), derivative) in jobs.iter().zip(derivatives(&jobs)?) {
                results[*candidate].derivatives.push(derivative);
            }
            // All are evaluated again: trimming is against the mean of the same results as before.
            weights = mixture_weights(&estimator, mixes, &results, &probes);
        }
        let learned_share = if is_learned_judged {
            let mixed = mixed(&results, &weights, probes.len());
            let results = [self.learned(&mixed, &probes, progress)?, mixed];
            mixture_weights(&estimator, |_, _| true, &results, &probes)[0].0
        } else {
            1.0
        };
        let share = |(&candidate, (share, gap))| CandidateShare { candidate, share, risk_gap: Some(gap) };
        Ok(Mixture { shares: candidates.iter().zip(weights).map(share).collect(), offsets, learned_share })
    }

    /// Runs the learned filter on a mixture. Returns its result, and how that changes with each probe.
    fn learned(
        &self,
        mixed: &CandidateResult,
        probes: &[Vec<DVec3>],
        progress: &dyn Progress,
    ) -> Result<CandidateResult, Cancelled> {
        let Problem { connectivity, noise, .. } = self.problem;
        let run = |input: &[DVec3], offsets: &[DVec3]| -> Result<Vec<DVec3>, Cancelled> {
            let fixed = noise.relative.iter().map(|sigma| *sigma == 0.0).collect();
            let deltas: Vec<DVec3> = offsets.iter().map(|offset| -*offset).collect();
            let found = learned::fused(input, &connectivity.mesh, fixed, &deltas, progress)?;
            Ok(found.map_or_else(|| offsets.to_vec(), |found| found.deltas.iter().map(|delta| -*delta).collect()))
        };
        let still = run(self.input, &mixed.offsets)?;
        let derivative = |(probe, of_mixed): (&Vec<DVec3>, &Vec<DVec3>)| -> Result<Vec<DVec3>, Cancelled> {
            let count = probe.len();
            let input: Vec<DVec3> = (0..count).map(|v| self.input[v] + PROBE_SIZE * probe[v]).collect();
            let offsets = |v: usize| mixed.offsets[v] + PROBE_SIZE * (of_mixed[v] - probe[v]);
            let moved = run(&input, &(0..count).map(offsets).collect::<Vec<_>>())?;
            Ok((0..count).map(|v| probe[v] + (moved[v] - still[v]) / PROBE_SIZE).collect())
        };
        let derivatives = probes.par_iter().zip(&mixed.derivatives).map(derivative);
        Ok(CandidateResult { derivatives: derivatives.collect::<Result<_, _>>()?, offsets: still })
    }

    /// Probes: samples of the noise along the normals of the result with these offsets (#V×3, model units). #V×3 each, model
    /// units
    fn probes(&self, count: usize, offsets: &[DVec3]) -> Vec<Vec<DVec3>> {
        let result: Vec<DVec3> = self.input.iter().zip(offsets).map(|(p, offset)| *p + *offset).collect();
        let normals = self.problem.connectivity.vertex_normals(&result);
        let Problem { connectivity, noise, .. } = self.problem;
        let samples = (7..).map(|seed| noise.sample(connectivity, seed));
        let along_normals = |lengths: Vec<f64>| lengths.iter().zip(&normals).map(|(x, n)| *x * *n).collect();
        samples.take(count).map(along_normals).collect()
    }

    fn perturbed(&self, probe: &[DVec3], progress: &dyn Progress) -> Result<PerturbedInput, Cancelled> {
        let input: Vec<DVec3> = self.input.iter().zip(probe).map(|(p, b)| *p + PROBE_SIZE * *b).collect();
        Ok(PerturbedInput { guess: self.guess(&input, progress)?, input })
    }

    /// First guess for candidates: the smoothed input. #V×3, model units
    fn guess(&self, input: &[DVec3], progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        self.problem.guess(input, progress)
    }

    /// Risk estimator with normals that are linearised at the mean of all results but the noisy mesh itself.
    fn estimator(&self, candidates: &[Candidate], results: &[CandidateResult]) -> SureEstimator<'_> {
        let denoised = candidates.iter().zip(results).filter(|(candidate, _)| **candidate != Candidate::Stay);
        let denoised: Vec<&CandidateResult> = denoised.map(|(_, result)| result).collect();
        let weight = 1.0 / denoised.len().max(1) as f64;
        let mean = |v: usize| self.input[v] + weight * denoised.iter().map(|result| result.offsets[v]).sum::<DVec3>();
        let mean: Vec<DVec3> = (0..self.input.len()).map(mean).collect();
        let mut linear = LinearisedNormals::default();
        let Problem { connectivity, noise, .. } = self.problem;
        let triangles = &connectivity.mesh.triangles;
        linear.update(connectivity, &mean, |f| MAX_GRADIENT / noise.edge_of(&triangles[f]));
        // Slivers count by their area, beside that of a triangle with local edges.
        let weight = |(t, area): (&[Index; 3], &f64)| (area / (0.433 * noise.edge_of(t).powi(2))).min(1.0);
        let weights = triangles.iter().zip(&linear.areas).map(weight).collect();
        SureEstimator { connectivity, weights, linear, evaluated: self.evaluated }
    }
}

/// Largest gradient of a normal, 1/local edge: steeper ones are those of slivers, which say nothing about the whole.
const MAX_GRADIENT: f64 = 3.0;

/// The mixture of results with these shares, as one result for so many probes.
fn mixed(results: &[CandidateResult], weights: &[(f64, f64)], probes: usize) -> CandidateResult {
    let sum = |of: &dyn Fn(&CandidateResult) -> &Vec<DVec3>| {
        let mut sum = vec![DVec3::ZERO; results.first().map_or(0, |result| result.offsets.len())];
        for (result, (share, _)) in results.iter().zip(weights) {
            sum.iter_mut().zip(of(result)).for_each(|(sum, x)| *sum += *share * *x);
        }
        sum
    };
    // What was pruned has a share of nearly nothing, and one derivative.
    let derivative = |k: usize| sum(&|result| &result.derivatives[k % result.derivatives.len()]);
    CandidateResult { offsets: sum(&|result| &result.offsets), derivatives: (0..probes).map(derivative).collect() }
}

/// All pairs of a candidate and a probe.
fn jobs(candidates: &[usize], probes: std::ops::Range<usize>) -> Vec<(usize, usize)> {
    candidates.iter().flat_map(|&c| probes.clone().map(move |k| (c, k))).collect()
}

/// Share of each result in the mixture, and by how much the risk of the best of its pairs exceeds that of the best of all
/// pairs, square degrees. Every pair of results that may be mixed, half of each, has a weight that falls exponentially
/// with its risk.
fn mixture_weights(
    estimator: &SureEstimator,
    may_mix: impl Fn(usize, usize) -> bool,
    results: &[CandidateResult],
    probes: &[Vec<DVec3>],
) -> Vec<(f64, f64)> {
    let response = |result: &CandidateResult| estimator.response(&result.offsets, &result.derivatives, probes);
    let responses: Vec<Response> = results.par_iter().map(response).collect();
    let all_risks: Vec<Vec<f64>> = responses.iter().map(Response::risks).collect();
    let mean = |f: usize| all_risks.iter().map(|risks| risks[f]).sum::<f64>() / all_risks.len() as f64;
    let reference: Vec<f64> = (0..estimator.connectivity.mesh.face_count()).map(mean).collect();
    let all_pairs = (0..responses.len()).flat_map(|a| (a..responses.len()).map(move |b| [a, b]));
    let pairs: Vec<[usize; 2]> = all_pairs.filter(|[a, b]| may_mix(*a, *b)).collect();
    let risk = |[a, b]: &[usize; 2]| estimator.risk_difference([&responses[*a], &responses[*b]], &reference);
    let risks: Vec<f64> = pairs.par_iter().map(risk).collect();
    let lowest = risks.iter().copied().fold(f64::INFINITY, f64::min);
    let mut weights = vec![(0.0, f64::INFINITY); results.len()];
    let mut total = 0.0;
    for (pair, risk) in pairs.iter().zip(risks) {
        let weight = (-(risk - lowest) / TEMPERATURE_DEG2).exp();
        for &k in pair {
            let (share, gap) = &mut weights[k];
            *share += weight / 2.0;
            *gap = gap.min(risk - lowest);
        }
        total += weight;
    }
    weights.iter_mut().for_each(|(share, _)| *share /= total);
    weights
}

#[cfg(test)]
mod tests;
