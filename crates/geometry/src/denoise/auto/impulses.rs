//! Noise that hits single vertices: how much each of them has, from what a first estimate of the surface leaves.
//!
//! The heights of the vertices over the estimate are a mixture of two Gaussians about zero, little noise and much. Expectation–
//! maximisation finds their deviations and shares (Arthur Dempster, Nan Laird, Donald Rubin. Maximum likelihood from incomplete
//! data via the EM algorithm. Journal of the Royal Statistical Society B 39 (1), 1977). A vertex then has the mean of the two
//! variances, weighed by the odds of its height.

use super::candidates::Candidate;
use crate::denoise::map::Problem;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;

/// Estimates of the surface: the first one is by the same deviation for all vertices, the second by what that has shown.
const ROUNDS: usize = 2;
/// Candidate that makes the estimates.
const PILOT: Candidate = Candidate::Mixed;

/// Deviation of each vertex (#V, local edges), where few vertices have most of the noise; `None` elsewhere.
pub(super) fn by_vertex(
    problem: &Problem,
    input: &[DVec3],
    progress: &dyn Progress,
) -> Result<Option<Vec<f64>>, Cancelled> {
    let Problem { connectivity, constraint, noise, .. } = *problem;
    let mut found = noise.clone();
    for _ in 0..ROUNDS {
        let problem = Problem::new(connectivity, constraint, &found);
        let guess = problem.guess(input, progress)?;
        let offsets = PILOT.offsets(&problem, input, &guess, progress)?;
        let estimate: Vec<DVec3> = input.iter().zip(&offsets).map(|(p, offset)| *p + *offset).collect();
        let normals = connectivity.vertex_normals(&estimate);
        let height = |v: usize| offsets[v].dot(normals[v]) / (noise.edge[v] * noise.relative[v]);
        let heights: Vec<Option<f64>> =
            (0..input.len()).map(|v| (noise.relative[v] > 0.0).then(|| height(v))).collect();
        let Some(mixture) = Mixture::of(&heights.iter().flatten().copied().collect::<Vec<f64>>()) else {
            return Ok(None);
        };
        for ((found, relative), height) in found.relative.iter_mut().zip(&noise.relative).zip(heights) {
            *found = height.map_or(0.0, |height| relative * mixture.variance(height).sqrt());
        }
    }
    Ok(Some(found.relative))
}

/// Two Gaussians about zero.
#[derive(Clone, Copy, Debug)]
struct Mixture {
    /// Variances, the smaller one first.
    variances: [f64; 2],
    /// Share of the second Gaussian, 0..=1.
    share: f64,
}

impl Mixture {
    /// The most probable mixture, if it is one of many values with little noise and few with much.
    fn of(values: &[f64]) -> Option<Self> {
        /// Steps of the search; each changes less than the one before.
        const STEPS: usize = 50;
        /// Least ratio of the two variances: creases, where estimates err more, make it four or so.
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

    /// Mean of the two variances by the odds of a value.
    fn variance(&self, value: f64) -> f64 {
        let odds = self.odds(value * value);
        (1.0 - odds) * self.variances[0] + odds * self.variances[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::denoise::noise_level::gaussians;

    #[test]
    fn few_values_with_much_noise_are_told_from_the_others() {
        let values: Vec<f64> =
            gaussians(4000, 3).iter().enumerate().map(|(i, g)| if i % 5 == 0 { 5.0 * g.x } else { 0.2 * g.y }).collect();
        let found = Mixture::of(&values).unwrap();
        let [little, much] = found.variances.map(f64::sqrt);
        assert!((little / 0.2 - 1.0).abs() < 0.05 && (much / 5.0 - 1.0).abs() < 0.1, "{found:?}");
        assert!((found.share - 0.2).abs() < 0.03, "{found:?}");
        assert!(found.variance(0.1).sqrt() < 0.25 && found.variance(8.0).sqrt() > 4.5);
        for same in [1e-8, 1.0, 1e8] {
            let white: Vec<f64> = gaussians(4000, 4).iter().map(|g| same * g.x).collect();
            assert!(Mixture::of(&white).is_none());
        }
        assert!(Mixture::of(&[]).is_none() && Mixture::of(&[0.0; 9]).is_none());
    }
}
