//! Normals as a linear function of the positions, and the weights of the edges between them.

use super::Prior;
use super::estimate::Net;
use super::system::Symmetric;
use glam::DVec3;
use rayon::prelude::*;

/// Faces that a thread treats at a time.
pub(super) const RUN: usize = 1024;

/// n(x + dx) ≈ n − Σₖ gₖ (n · dxₖ) over the corners k of each face.
#[derive(Default)]
pub(in crate::denoise) struct Linear {
    /// n. #T×3
    pub(in crate::denoise) normals: Vec<DVec3>,
    /// gₖ = n × eₖ / 2A, with eₖ the edge opposite to the corner. #T×3×3
    pub(in crate::denoise) gradients: Vec<[DVec3; 3]>,
    /// #T
    pub(in crate::denoise) areas: Vec<f64>,
}

impl Linear {
    /// `steepest` bounds |gₖ|, so that slivers have no more weight than they deserve.
    pub(in crate::denoise) fn measure(&mut self, net: &Net, positions: &[DVec3], steepest: f64) {
        let count = net.faces.len();
        self.normals.resize(count, DVec3::ZERO);
        self.gradients.resize(count, [DVec3::ZERO; 3]);
        self.areas.resize(count, 0.0);
        let slots = self.normals.par_iter_mut().zip(&mut self.gradients).zip(&mut self.areas);
        slots.zip(&net.faces.triangles).with_min_len(RUN).for_each(|(((normal, gradients), area), t)| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let doubled = (b - a).cross(c - a);
            let length = doubled.length();
            *normal = doubled.normalize_or_zero();
            *area = length / 2.0;
            *gradients = [c - b, a - c, b - a].map(|edge| {
                let g = normal.cross(edge) / length;
                if g.is_finite() { g.clamp_length_max(steepest) } else { DVec3::ZERO }
            });
        });
    }

    /// The change of each normal with the positions. #T×3
    pub(in crate::denoise) fn change(&self, net: &Net, ways: &[DVec3], out: &mut [DVec3]) {
        let slots = out.par_iter_mut().zip(&self.normals).zip(&self.gradients).zip(&net.faces.triangles);
        slots.with_min_len(RUN).for_each(|(((out, n), gradients), t)| {
            let turn = |k: usize| gradients[k] * n.dot(ways[t[k] as usize]);
            *out = -(turn(0) + turn(1) + turn(2));
        });
    }
}

/// An edge as one of its two faces sees it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Side {
    /// Centroid of this face minus that of the other, mean edges.
    pub(super) way: DVec3,
    /// Weight of the turn of the normal.
    pub(super) turn: f64,
    /// Weight of the jump of the shape operator.
    pub(super) jump: f64,
}

/// How residuals become weights in one round.
pub(super) struct Weighing {
    strength: f64,
    curvature: f64,
    exponent: f64,
    /// 1/κ²
    sharpness: f64,
}

impl Weighing {
    pub(super) fn at(prior: &Prior, round: u32) -> Self {
        const FIRST: f64 = 0.4;
        // The last fifth of the rounds has the last threshold.
        let share = if prior.rounds > 1 { 1.25 * f64::from(round) / f64::from(prior.rounds - 1) } else { 1.0 };
        let kappa = FIRST * (prior.threshold / FIRST).powf(share.min(1.0));
        let strength = prior.strength * kappa.powf(-2.0 * prior.exponent);
        Self {
            strength,
            curvature: strength * prior.curvature,
            exponent: prior.exponent,
            sharpness: 1.0 / (kappa * kappa),
        }
    }

    /// φ of a squared residual.
    fn robust(&self, squared: f64) -> f64 {
        (1.0 + squared * self.sharpness).powf(-self.exponent)
    }
}

/// Sides of all faces, in the order of [`Net::sides`].
pub(super) struct Sides {
    pub(super) all: Vec<Side>,
    centroids: Vec<DVec3>,
}

impl Sides {
    pub(super) fn of(net: &Net) -> Self {
        let count = net.sides.items().len();
        Self { all: vec![Side::default(); count], centroids: vec![DVec3::ZERO; net.faces.len()] }
    }

    pub(super) fn weigh(
        &mut self,
        net: &Net,
        linear: &Linear,
        positions: &[DVec3],
        shapes: &[Symmetric],
        weighing: &Weighing,
    ) {
        let third = |t: &[u32; 3]| t.iter().map(|&v| positions[v as usize]).sum::<DVec3>() / 3.0;
        self.centroids.par_iter_mut().zip(&net.faces.triangles).for_each(|(c, t)| *c = third(t));
        let centroids = &self.centroids;
        let edges: Vec<Side> = net
            .faces
            .pairs
            .par_iter()
            .zip(&net.faces.pair_edges)
            .with_min_len(RUN)
            .map(|(&[f, g], &[a, b])| {
                let [f, g] = [f, g].map(|f| f as usize);
                let way = (centroids[f] - centroids[g]).clamp_length_max(2.0);
                let length = positions[a as usize].distance(positions[b as usize]).clamp(0.1, 3.0);
                let turn = linear.normals[f] - linear.normals[g] - 0.5 * shapes[f].plus(&shapes[g]).times(way);
                let bent = weighing.robust(turn.length_squared());
                let jump = weighing.robust(shapes[f].minus(&shapes[g]).squared());
                Side { way, turn: weighing.strength * length * bent, jump: weighing.curvature * length * bent * jump }
            })
            .collect();
        let first = |f: usize, e: u32| net.faces.pairs[e as usize][0] as usize == f;
        let of_face = |f: usize| net.sides.get(f as u32).iter().map(move |&(e, _)| (e, f));
        let every = (0..net.faces.len()).flat_map(of_face);
        for (side, (e, f)) in self.all.iter_mut().zip(every) {
            *side = edges[e as usize];
            if !first(f, e) {
                side.way = -side.way;
            }
        }
    }
}

#[cfg(test)]
mod tests;
