//! Rounds of linearising, reweighting and solving.

use super::Prior;
use super::edge_weights::{HalfEdgeWeights, RobustWeights};
use super::linearised_normals::LinearisedNormals;
use super::normal_equations::{Linearisation, NormalEquations, Unknowns};
use super::symmetric::Symmetric;
use crate::denoise::bilaplacian::BoundaryConstraint;
use crate::denoise::connectivity::Connectivity;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// A mesh and its noise: what does not change between estimates under different priors.
#[derive(Clone, Copy)]
pub(in crate::denoise) struct Problem<'a> {
    pub(in crate::denoise) connectivity: &'a Connectivity,
    pub(in crate::denoise) constraint: &'a BoundaryConstraint,
    /// Standard deviation σ of the noise, mean edges.
    pub(in crate::denoise) sigma: f64,
    /// Weight k of the data term's tangential part, on top of the weight 1 of all directions; 0 for isotropic noise.
    pub(in crate::denoise) tangential_stiffness: f64,
    /// Mean edge length, model units.
    pub(in crate::denoise) mean_edge: f64,
    /// Largest number of steps of conjugate gradients in each round.
    pub(in crate::denoise) max_steps: u32,
}

/// Fraction of the rounds in which the tangential stiffness rises from zero to its value. The normals of the first rounds
/// are noisy, and so is what they call tangential.
const STIFFNESS_RAMP: f64 = 0.3;

impl<'a> Problem<'a> {
    /// A problem with isotropic noise. Noisier meshes are smoothed over wider neighbourhoods, which takes more steps.
    pub(in crate::denoise) fn new(
        connectivity: &'a Connectivity,
        constraint: &'a BoundaryConstraint,
        sigma: f64,
        mean_edge: f64,
    ) -> Self {
        let max_steps = (100.0 * sigma).clamp(20.0, 80.0) as u32;
        Self { connectivity, constraint, sigma, tangential_stiffness: 0.0, mean_edge, max_steps }
    }

    /// Estimates the surface from the vertices `input`, starting at `guess`. Returns the offset of each vertex from the
    /// input. #V×3, model units
    pub(in crate::denoise) fn estimate(
        &self,
        input: &[DVec3],
        guess: &[DVec3],
        prior: &Prior,
        progress: &dyn Progress,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let unit = 1.0 / self.mean_edge;
        let connectivity = self.connectivity;
        let input: Vec<DVec3> = input.iter().map(|p| *p * unit).collect();
        let mut offsets: Vec<DVec3> = guess.iter().zip(&input).map(|(x, p)| *x * unit - p).collect();
        offsets.iter_mut().enumerate().for_each(|(v, offset)| *offset = self.constraint.projected(v, *offset));
        let shape_operators = vec![Symmetric::default(); connectivity.mesh.face_count()];
        let mut unknowns = Unknowns { offsets, shape_operators };
        let mut positions = vec![DVec3::ZERO; input.len()];
        let mut normals = LinearisedNormals::default();
        let mut weights = HalfEdgeWeights::new(connectivity);
        let data = 1.0 / (self.sigma * self.sigma);
        let mut equations = NormalEquations::new(connectivity, self.constraint, data, prior);
        for round in 0..prior.rounds {
            progress.check()?;
            let slots = positions.par_iter_mut().zip(&input).zip(&unknowns.offsets);
            slots.for_each(|((x, p), offset)| *x = *p + offset);
            normals.update(connectivity, &positions, MAX_GRADIENT);
            let robust = RobustWeights::at_round(prior, round);
            weights.update(connectivity, &normals, &positions, &unknowns.shape_operators, &robust);
            let ramp = f64::from(round) / (STIFFNESS_RAMP * f64::from(prior.rounds.max(2) - 1));
            equations.set_tangential_weight(data * self.tangential_stiffness * ramp.min(1.0));
            let at = Linearisation { normals: &normals, weights: &weights, positions: &positions };
            equations.solve(&at, &mut unknowns, self.max_steps, progress)?;
        }
        Ok(unknowns.offsets.into_iter().map(|offset| offset * self.mean_edge).collect())
    }
}

/// Largest gradient of a normal with respect to a corner, 1/mean edge: that of a triangle whose height is a tenth of a mean
/// edge. Normals of thinner triangles are not linear over a step anyway.
const MAX_GRADIENT: f64 = 10.0;
