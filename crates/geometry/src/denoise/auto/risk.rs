//! How far off a result is, without knowing the truth.
//!
//! Charles M. Stein. Estimation of the mean of a multivariate normal distribution. Annals of Statistics 9 (6), 1981;
//! its divergence by one random probe: Sathish Ramani, Thierry Blu, Michael Unser. Monte-Carlo SURE. IEEE Transactions on
//! Image Processing 17 (9), 2008.
//!
//! The noise of a face normal is A e, linear in that of the vertices. For a result y(p) the expectation of
//! |A (y − p)|² + 2σ² (A b)·(A (y(p + ε b) − y(p)) / ε), with b standard Gaussian along the normals, is the squared error
//! of its normals but for a constant that is the same for all results.

use super::super::map::{Linear, Net};
use crate::progress::Cancelled;
use glam::DVec3;

/// One result, as changes of the face normals.
pub(super) struct Seen {
    /// A (y − p). #T×3
    residuals: Vec<DVec3>,
    /// 2σ² (A b)·(A dy). #T
    divergences: Vec<f64>,
}

/// What is the same for all results.
pub(super) struct Judge<'a> {
    pub(super) net: &'a Net,
    /// A, at the mean of the results.
    pub(super) linear: Linear,
    /// A b. #T×3
    pub(super) probe: Vec<DVec3>,
    /// 2σ², square model units.
    pub(super) variance: f64,
}

impl Judge<'_> {
    /// `ways` of a result, and how they change with the probe (dy = b + change of the way). #V×3, model units.
    pub(super) fn see(&self, ways: &[DVec3], response: &[DVec3]) -> Seen {
        let mut residuals = vec![DVec3::ZERO; self.net.faces.len()];
        let mut turned = residuals.clone();
        self.linear.change(self.net, ways, &mut residuals);
        self.linear.change(self.net, response, &mut turned);
        let divergences = turned.iter().zip(&self.probe).map(|(a, b)| self.variance * a.dot(*b)).collect();
        Seen { residuals, divergences }
    }

    /// Risk of the mean of two results minus that of a third, square degrees. Slivers count by their area, and the least and
    /// the largest are left out: faces that have turned over say nothing.
    pub(super) fn difference(&self, [a, b]: [&Seen; 2], reference: &Seen) -> f64 {
        const TRIMMED: f64 = 0.02;
        let count = self.net.faces.len();
        let mean_area = self.linear.areas.iter().sum::<f64>() / count.max(1) as f64;
        let one = |f: usize| {
            let mean = 0.5 * (a.residuals[f] + b.residuals[f]);
            let risk = mean.length_squared() + 0.5 * (a.divergences[f] + b.divergences[f]);
            let other = reference.residuals[f].length_squared() + reference.divergences[f];
            (risk - other) * (self.linear.areas[f] / mean_area).min(1.0)
        };
        let mut values: Vec<f64> = (0..count).map(one).collect();
        for _ in 0..3 {
            values = (0..count).map(|f| self.averaged(&values, f)).collect();
        }
        values.sort_unstable_by(f64::total_cmp);
        let cut = (TRIMMED * count as f64) as usize;
        let kept = &values[cut..count - cut];
        let degrees = 1f64.to_degrees().powi(2);
        degrees * kept.iter().sum::<f64>() / kept.len().max(1) as f64
    }

    fn averaged(&self, values: &[f64], f: usize) -> f64 {
        let (mut sum, mut count) = (values[f], 1.0);
        for g in self.net.beside(f) {
            sum += values[g];
            count += 1.0;
        }
        sum / count
    }
}

/// How much of each of two results, for all pairs of results: exp(−risk / temperature), normalised, shared equally.
pub(super) fn weights(judge: &Judge, seen: &[Seen], temperature: f64) -> Result<Vec<f64>, Cancelled> {
    use rayon::prelude::*;
    let pairs: Vec<[usize; 2]> = (0..seen.len()).flat_map(|a| (a..seen.len()).map(move |b| [a, b])).collect();
    let reference = &seen[0];
    let risks: Vec<f64> = pairs.par_iter().map(|[a, b]| judge.difference([&seen[*a], &seen[*b]], reference)).collect();
    let least = risks.iter().copied().fold(f64::INFINITY, f64::min);
    let mut weights = vec![0.0; seen.len()];
    let mut total = 0.0;
    for ([a, b], risk) in pairs.iter().zip(risks) {
        let weight = (-(risk - least) / temperature).exp();
        weights[*a] += weight / 2.0;
        weights[*b] += weight / 2.0;
        total += weight;
    }
    weights.iter_mut().for_each(|w| *w /= total);
    Ok(weights)
}
