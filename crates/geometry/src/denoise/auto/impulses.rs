//! Noise that hits single vertices: how much each of them has, from what a first estimate of the surface leaves.
//!
//! The heights of the vertices over the estimate are a mixture of two Gaussians about zero, little noise and much. Expectation–
//! maximisation finds their deviations and shares (Arthur Dempster, Nan Laird, Donald Rubin. Maximum likelihood from incomplete
//! data via the EM algorithm. Journal of the Royal Statistical Society B 39 (1), 1977). A vertex then has the mean of the two
//! weights, the inverse variances, by the odds of its height.

use crate::denoise::choice::Candidate;
use crate::denoise::map::Problem;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;

/// Estimates of the surface: the first one is by the same deviation for all vertices, the second by what that has shown.
const ROUNDS: usize = 2;
/// Number of lazy umbrella steps over which the heights around a vertex are averaged: four edges.
const AROUND: usize = 32;
/// Candidate that makes the estimates.
const PILOT: Candidate = Candidate::Mixed;

/// Noise of which few vertices have most.
pub(super) struct Impulses {
    /// Deviation of each vertex, local edges. #V
    pub(super) relative: Vec<f64>,
    /// Share of the noisy vertices that are hit, 0..=1.
    pub(super) share: f64,
}

/// Finds the noise of each vertex, where few vertices have most of it; `None` elsewhere.
pub(super) fn by_vertex(
    problem: &Problem,
    input: &[DVec3],
    progress: &dyn Progress,
) -> Result<Option<Impulses>, Cancelled> {
    let Problem { connectivity, constraint, noise, .. } = *problem;
    let mut found = noise.clone();
    let mut share = 0.0;
    for _ in 0..ROUNDS {
        let problem = Problem::new(connectivity, constraint, &found);
        let guess = problem.guess(input, progress)?;
        let offsets = PILOT.offsets(&problem, input, &guess, progress)?;
        let estimate: Vec<DVec3> = input.iter().zip(&offsets).map(|(p, offset)| *p + *offset).collect();
        let normals = connectivity.vertex_normals(&estimate);
        let height = |v: usize| offsets[v].dot(normals[v]) / (noise.edge[v] * noise.relative[v]);
        let is_noisy = |v: &usize| noise.relative[*v] > 0.0;
        let heights: Vec<f64> = (0..input.len()).map(|v| if is_noisy(&v) { height(v) } else { 0.0 }).collect();
        // Noise that is more in some places than in others is a mixture, too, but not one of neighbours.
        let mut around: Vec<DVec3> = heights.iter().map(|height| DVec3::X * height.abs()).collect();
        for _ in 0..AROUND {
            around = connectivity.umbrella.lazy_step(&around);
        }
        let scaled = |v: usize| if around[v].x > 0.0 { heights[v] / around[v].x } else { 0.0 };
        let Some(mixture) = TwoGaussians::of(&(0..input.len()).filter(is_noisy).map(scaled).collect::<Vec<f64>>())
        else {
            return Ok(None);
        };
        share = mixture.share;
        for v in (0..input.len()).filter(is_noisy) {
            found.relative[v] = noise.relative[v] * around[v].x.max(0.0) * mixture.variance(scaled(v)).sqrt();
        }
    }
    Ok(Some(Impulses { relative: found.relative, share }))
}

/// Two Gaussians about zero.
#[derive(Clone, Copy, Debug)]
struct TwoGaussians {
    /// Variances, the smaller one first.
    variances: [f64; 2],
    /// Share of the second Gaussian, 0..=1.
    share: f64,
}

impl TwoGaussians {
    /// The most probable mixture, if it is one of many values with little noise and few with much.
    fn of(values: &[f64]) -> Option<Self> {
        /// Steps of the search; each changes less than the one before.
        const STEPS: usize = 50;
        /// Least ratio of the two variances, three in the deviations: less may be an estimate that errs more at creases.
        const LEAST_RATIO: f64 = 9.0;
        let mean = values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64;
        if mean.is_nan() || mean <= 0.0 {
            return None;
        }
        // Variances over their mean do not under- or overflow.
        let squares: Vec<f64> = values.iter().map(|x| x * x / mean).collect();
        let mut found = Self { variances: [0.1, 2.0], share: 0.3 };
        for _ in 0..STEPS {
            let (mut weight, mut sum) = (0.0, 0.0);
            for square in &squares {
                let odds = found.odds(*square);
                weight += odds;
                sum += odds * square;
            }
            let count = squares.len() as f64;
            let variance = |sum: f64, weight: f64| if weight > 0.0 { (sum / weight).max(1e-6) } else { 1e-6 };
            found.variances = [variance(count - sum, count - weight), variance(sum, weight)];
            found.share = weight / count;
        }
        let [little, much] = found.variances;
        let few_are_hit = found.share < 0.5 && much > LEAST_RATIO * little;
        few_are_hit.then_some(Self { variances: found.variances.map(|v| v * mean), ..found })
    }

    /// Probability that a value with this square is of the second Gaussian.
    fn odds(&self, square: f64) -> f64 {
        let [little, much] = self.variances;
        // The ratio of the densities, so that values far out are not zero over zero.
        let ratio = (0.5 * square * (1.0 / much - 1.0 / little)).exp() * (much / little).sqrt();
        self.share / (self.share + (1.0 - self.share) * ratio)
    }

    /// Variance by which a value is to be weighed: the inverse of the mean weight by the odds of the value.
    fn variance(&self, value: f64) -> f64 {
        let odds = self.odds(value * value);
        1.0 / ((1.0 - odds) / self.variances[0] + odds / self.variances[1])
    }
}

#[cfg(test)]
mod tests;
