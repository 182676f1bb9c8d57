//! How far off a result is, without knowing the truth.
//!
//! Charles M. Stein. Estimation of the mean of a multivariate normal distribution. Annals of Statistics 9 (6), 1981;
//! its divergence by one random probe: Sathish Ramani, Thierry Blu, Michael Unser. Monte-Carlo SURE. IEEE Transactions on
//! Image Processing 17 (9), 2008.
//!
//! The noise of a face normal is A e, linear in that of the vertices. For a result y(p) the expectation of
//! |A (y − p)|² + 2σ² (A b)·(A (y(p + ε b) − y(p)) / ε), with b standard Gaussian along the normals, is the squared error
//! of its normals but for a constant that is the same for all results.
//!
//! A face is averaged a little with those beside it: its noise is many times what results differ by and alternates from face
//! to face, so that the risk is known better, and what results leave of the noise or take of the shape is seen as well.

use crate::denoise::map::{Linear, Net};
use glam::DVec3;
use std::ops::{Add, Div, Mul};

/// One result, as changes of the face normals.
pub(super) struct Seen {
    /// A (y − p), averaged. #T×3
    residuals: Vec<DVec3>,
    /// 2σ² (A b)·(A dy) for each probe, both averaged. #probes×T
    divergences: Vec<Vec<f64>>,
}

/// What is the same for all results.
pub(super) struct Judge<'a> {
    pub(super) net: &'a Net,
    /// A, at the mean of the results.
    pub(super) linear: Linear,
    /// 2σ², square model units.
    pub(super) variance: f64,
    /// Which triangles count; all where it is empty.
    pub(super) judged: &'a [bool],
}

impl Seen {
    /// Risk at each triangle, the mean over the probes, square unit length. #T
    pub(super) fn risks(&self) -> Vec<f64> {
        let mean = |f: usize| self.divergences.iter().map(|of| of[f]).sum::<f64>() / self.divergences.len() as f64;
        self.residuals.iter().enumerate().map(|(f, r)| r.length_squared() + mean(f)).collect()
    }

    /// The same for one of the probes; those with few start anew.
    fn divergences(&self, probe: usize) -> &[f64] {
        &self.divergences[probe % self.divergences.len()]
    }
}

impl Judge<'_> {
    /// `ways` of a result, and how it moves with each probe, dy. #V×3, model units.
    pub(super) fn see(&self, ways: &[DVec3], responses: &[Vec<DVec3>], probes: &[Vec<DVec3>]) -> Seen {
        let changed = |ways: &[DVec3]| {
            let mut out = vec![DVec3::ZERO; self.net.faces.len()];
            self.linear.change(self.net, ways, &mut out);
            self.softened(&out)
        };
        let turned = |(response, probe): (&Vec<DVec3>, &Vec<DVec3>)| -> Vec<f64> {
            let (response, probe) = (changed(response), changed(probe));
            response.iter().zip(&probe).map(|(a, b)| self.variance * a.dot(*b)).collect()
        };
        Seen { residuals: changed(ways), divergences: responses.iter().zip(probes).map(turned).collect() }
    }

    /// Risk of the mean of two results minus a reference risk (#T, square unit length), square degrees, the mean over the
    /// probes.
    pub(super) fn difference(&self, pair: [&Seen; 2], reference: &[f64]) -> f64 {
        let probes = pair.map(|seen| seen.divergences.len()).into_iter().fold(1, usize::max);
        (0..probes).map(|probe| self.by_one_probe(pair, reference, probe)).sum::<f64>() / probes as f64
    }

    /// Slivers count by their area, and the least and the largest are left out: faces that have turned over say nothing.
    /// Those are others for each probe.
    fn by_one_probe(&self, [a, b]: [&Seen; 2], reference: &[f64], probe: usize) -> f64 {
        const TRIMMED: f64 = 0.02;
        let count = self.net.faces.len();
        let mean_area = self.linear.areas.iter().sum::<f64>() / count.max(1) as f64;
        let [of_a, of_b] = [a, b].map(|seen| seen.divergences(probe));
        let one = |f: usize| {
            let mean = 0.5 * (a.residuals[f] + b.residuals[f]);
            let risk = mean.length_squared() + 0.5 * (of_a[f] + of_b[f]);
            (risk - reference[f]) * (self.linear.areas[f] / mean_area).min(1.0)
        };
        let mut values: Vec<f64> = (0..count).map(one).collect();
        for _ in 0..3 {
            values = (0..count).map(|f| self.averaged(&values, f, 1.0)).collect();
        }
        if !self.judged.is_empty() {
            values = values.into_iter().zip(self.judged).filter(|(_, judged)| **judged).map(|(x, _)| x).collect();
        }
        values.sort_unstable_by(f64::total_cmp);
        let cut = (TRIMMED * values.len() as f64) as usize;
        let kept = &values[cut..values.len() - cut];
        let degrees = 1f64.to_degrees().powi(2);
        degrees * kept.iter().sum::<f64>() / kept.len().max(1) as f64
    }

    /// Each face's change, and as much of the mean of those around it.
    fn softened(&self, changes: &[DVec3]) -> Vec<DVec3> {
        (0..changes.len()).map(|f| self.averaged(changes, f, 3.0)).collect()
    }

    /// Mean at a face and those beside it, where it counts `own` times.
    fn averaged<T>(&self, values: &[T], f: usize, own: f64) -> T
    where
        T: Copy + Add<Output = T> + Mul<f64, Output = T> + Div<f64, Output = T>,
    {
        let start = (values[f] * own, own);
        let (sum, count) = self.net.beside(f).fold(start, |(sum, count), g| (sum + values[g], count + 1.0));
        sum / count
    }
}

#[cfg(test)]
mod tests;
