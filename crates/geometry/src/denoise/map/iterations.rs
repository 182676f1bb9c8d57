//! Rounds of linearising, reweighting and solving.

use super::Prior;
use super::edge_weights::{Linear, Sides, Weighing};
use super::symmetric::Symmetric;
use super::normal_equations::System;
use crate::denoise::connectivity::Connectivity;
use crate::denoise::umbrella::Freedom;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// What does not change between estimates on one mesh.
#[derive(Clone, Copy)]
pub(in crate::denoise) struct Run<'a> {
    pub(in crate::denoise) net: &'a Connectivity,
    pub(in crate::denoise) freedom: &'a Freedom,
    /// σ, in mean edges.
    pub(in crate::denoise) sigma: f64,
    /// How many times more the data hold vertices across the normals than along them, minus one.
    pub(in crate::denoise) held: f64,
    /// Model units.
    pub(in crate::denoise) mean_edge: f64,
    /// Of conjugate gradients, at most.
    pub(in crate::denoise) steps: u32,
}

/// Share of the rounds after which normals are good enough to hold vertices across them with all weight.
const UNKNOWN: f64 = 0.3;

impl<'a> Run<'a> {
    /// The noisier, the more steps a round needs to reach as far as the noise makes it look.
    pub(in crate::denoise) fn of(net: &'a Connectivity, freedom: &'a Freedom, sigma: f64, mean_edge: f64) -> Self {
        let steps = (100.0 * sigma).clamp(20.0, 80.0) as u32;
        Self { net, freedom, sigma, held: 0.0, mean_edge, steps }
    }

    /// Where the vertices of `input` go, from a first guess. #V×3, model units.
    pub(in crate::denoise) fn ways(
        &self,
        input: &[DVec3],
        start: &[DVec3],
        prior: &Prior,
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let unit = 1.0 / self.mean_edge;
        let net = self.net;
        let input: Vec<DVec3> = input.iter().map(|p| *p * unit).collect();
        let mut way: Vec<DVec3> = start.iter().zip(&input).map(|(x, p)| *x * unit - p).collect();
        way.iter_mut().enumerate().for_each(|(v, way)| *way = self.freedom.projected(v, *way));
        let mut shapes = vec![Symmetric::default(); net.faces.len()];
        let mut positions = vec![DVec3::ZERO; input.len()];
        let mut linear = Linear::default();
        let mut sides = Sides::of(net);
        let data = 1.0 / (self.sigma * self.sigma);
        let mut system = System::new(net, self.freedom, data, prior);
        for round in 0..prior.rounds {
            progress.check()?;
            positions.par_iter_mut().zip(&input).zip(&way).for_each(|((x, p), way)| *x = *p + way);
            linear.measure(net, &positions, 10.0);
            sides.weigh(net, &linear, &positions, &shapes, &Weighing::at(prior, round));
            // The first normals are noisy, and what lies across them is not known yet.
            let known = f64::from(round) / (UNKNOWN * f64::from(prior.rounds.max(2) - 1));
            system.hold(data * self.held * known.min(1.0));
            system.solve(&linear, &sides, &positions, &mut way, &mut shapes, self.steps, progress)?;
        }
        Ok(way.into_iter().map(|way| way * self.mean_edge).collect())
    }
}
