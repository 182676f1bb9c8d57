//! Stein's unbiased risk estimate (SURE): the error of a result without knowing the truth.
//!
//! Charles M. Stein. Estimation of the mean of a multivariate normal distribution. Annals of Statistics 9 (6), 1981.
//! The divergence in it is found by random probes: Sathish Ramani, Thierry Blu, Michael Unser. Monte-Carlo SURE. IEEE
//! Transactions on Image Processing 17 (9), 2008.
//!
//! The error of a result is that of its face normals, which are a linear function A of the positions. For a result y(p)
//! the expectation of |A (y − p)|² + 2 (A b)·(A (y(p + ε b) − y(p)) / ε), with b a further sample of the noise, is the
//! squared error of its normals up to a constant that is the same for all results. The noise need not be white or even.
//!
//! Residuals are smoothed over each face's edge neighbours first. The noise of faces is much larger than the differences
//! between candidates and alternates in sign, so smoothing reduces the variance of the estimate; leftover noise and lost
//! shape survive it.

use crate::denoise::connectivity::Connectivity;
use crate::denoise::map::LinearisedNormals;
use glam::{DVec3, Vec3A};
use std::ops::{Add, Div, Mul};

/// Residuals and divergences of one result, from which its risk is estimated.
pub(super) struct Response {
    /// Smoothed residual A (y − p) of each face. #T×3
    residuals: Vec<DVec3>,
    /// For each probe, the divergence term 2 (A b)·(A dy) of each face, both factors smoothed. #probes×T
    divergences: Vec<Vec<f64>>,
}

/// The risk estimator: what is the same for all results.
pub(super) struct SureEstimator<'a> {
    pub(super) connectivity: &'a Connectivity,
    /// Linear function A from positions to face normals, at the mean of the results.
    pub(super) linear: LinearisedNormals,
    /// Weights of the triangles: 1, or less for slivers. #T
    pub(super) weights: Vec<f64>,
    /// True for triangles that count. #T, or empty where all do
    pub(super) evaluated: &'a [bool],
}

impl Response {
    /// Risk at each triangle, the mean over the probes, square unit length. #T
    pub(super) fn risks(&self) -> Vec<f64> {
        let mean = |f: usize| self.divergences.iter().map(|of| of[f]).sum::<f64>() / self.divergences.len() as f64;
        self.residuals.iter().enumerate().map(|(f, r)| r.length_squared() + mean(f)).collect()
    }

    /// Divergence terms of one probe. A result with fewer probes than another one reuses its own in turn.
    fn divergences(&self, probe: usize) -> &[f64] {
        &self.divergences[probe % self.divergences.len()]
    }
}

impl SureEstimator<'_> {
    /// Response of a result with these `offsets` from the input, whose positions change by `derivatives` for the `probes`.
    /// All are #V×3, model units; the latter two have one entry for each probe.
    pub(super) fn response(&self, offsets: &[DVec3], derivatives: &[Vec<DVec3>], probes: &[Vec<DVec3>]) -> Response {
        let normal_changes = |offsets: &[DVec3]| {
            let mut changes = vec![Vec3A::ZERO; self.connectivity.mesh.face_count()];
            let offsets: Vec<Vec3A> = offsets.iter().map(|offset| offset.as_vec3a()).collect();
            self.linear.apply_jacobian(self.connectivity, &offsets, &mut changes);
            self.smoothed(&changes.iter().map(|change| change.as_dvec3()).collect::<Vec<_>>())
        };
        let divergence = |(derivative, probe): (&Vec<DVec3>, &Vec<DVec3>)| -> Vec<f64> {
            let (derivative, probe) = (normal_changes(derivative), normal_changes(probe));
            derivative.iter().zip(&probe).map(|(a, b)| 2.0 * a.dot(*b)).collect()
        };
        Response {
            residuals: normal_changes(offsets),
            divergences: derivatives.iter().zip(probes).map(divergence).collect(),
        }
    }

    /// Risk of the mean of two results minus a reference risk (#T, square unit length), averaged over the probes, square
    /// degrees.
    pub(super) fn risk_difference(&self, pair: [&Response; 2], reference: &[f64]) -> f64 {
        let probes = pair.map(|response| response.divergences.len()).into_iter().fold(1, usize::max);
        (0..probes).map(|probe| self.risk_difference_by_probe(pair, reference, probe)).sum::<f64>() / probes as f64
    }

    /// Risk difference by one probe. Slivers count by their area, and the least and the largest values are left out: faces
    /// that have flipped say nothing, and they are other faces for each probe.
    fn risk_difference_by_probe(&self, [a, b]: [&Response; 2], reference: &[f64], probe: usize) -> f64 {
        /// Fraction of the faces that is left out at either end.
        const TRIMMED: f64 = 0.02;
        /// Number of times that values are averaged over neighbours, so that trimming cuts off regions rather than noise.
        const SMOOTHINGS: usize = 3;
        let count = self.connectivity.mesh.face_count();
        let [of_a, of_b] = [a, b].map(|response| response.divergences(probe));
        let one = |f: usize| {
            let mean = 0.5 * (a.residuals[f] + b.residuals[f]);
            let risk = mean.length_squared() + 0.5 * (of_a[f] + of_b[f]);
            (risk - reference[f]) * self.weights[f]
        };
        let mut values: Vec<f64> = (0..count).map(one).collect();
        for _ in 0..SMOOTHINGS {
            values = (0..count).map(|f| self.local_mean(&values, f, 1.0)).collect();
        }
        if !self.evaluated.is_empty() {
            let evaluated = values.into_iter().zip(self.evaluated).filter(|(_, evaluated)| **evaluated);
            values = evaluated.map(|(x, _)| x).collect();
        }
        values.sort_unstable_by(f64::total_cmp);
        let cut = (TRIMMED * values.len() as f64) as usize;
        let kept = &values[cut..values.len() - cut];
        let square_degrees = 1f64.to_degrees().powi(2);
        square_degrees * kept.iter().sum::<f64>() / kept.len().max(1) as f64
    }

    /// Changes of the normals smoothed over edge neighbours; each face counts as much as its three neighbours together.
    fn smoothed(&self, changes: &[DVec3]) -> Vec<DVec3> {
        (0..changes.len()).map(|f| self.local_mean(changes, f, 3.0)).collect()
    }

    /// Mean of the values at a face and its edge neighbours, where the face itself has weight `own`.
    fn local_mean<T>(&self, values: &[T], f: usize, own: f64) -> T
    where
        T: Copy + Add<Output = T> + Mul<f64, Output = T> + Div<f64, Output = T>,
    {
        let start = (values[f] * own, own);
        let neighbours = self.connectivity.edge_neighbours(f);
        let (sum, weight) = neighbours.fold(start, |(sum, weight), g| (sum + values[g], weight + 1.0));
        sum / weight
    }
}

#[cfg(test)]
mod tests;
