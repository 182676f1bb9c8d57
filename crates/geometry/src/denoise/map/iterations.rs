//! Rounds of linearising, reweighting and solving.

use super::Prior;
use super::edge_weights::{Configuration, HalfEdgeWeights, RobustWeights};
use super::linearised_normals::LinearisedNormals;
use super::normal_equations::{DataWeights, Linearisation, NormalEquations, Unknowns};
use super::symmetric::Symmetric;
use crate::denoise::bilaplacian::{BoundaryConstraint, LocalStrength};
use crate::denoise::connectivity::Connectivity;
use crate::denoise::noise_field::NoiseField;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// A mesh and its noise: what does not change between estimates under different priors.
#[derive(Clone, Copy)]
pub(in crate::denoise) struct Problem<'a> {
    pub(in crate::denoise) connectivity: &'a Connectivity,
    pub(in crate::denoise) constraint: &'a BoundaryConstraint,
    /// Noise at each vertex.
    pub(in crate::denoise) noise: &'a NoiseField,
    /// Largest number of steps of conjugate gradients in each round.
    pub(in crate::denoise) max_steps: u32,
}

/// Fraction of the rounds in which the tangential stiffness rises from zero to its value. The normals of the first rounds
/// are noisy, and so is what they call tangential.
const STIFFNESS_RAMP: f64 = 0.3;

impl<'a> Problem<'a> {
    /// A problem on a mesh with this noise. Noisier meshes are smoothed over wider neighbourhoods, which takes more steps. Half as many
    /// were as good on training shapes, but up to a tenth worse on the machine parts of `docs/results.md`.
    pub(in crate::denoise) fn new(
        connectivity: &'a Connectivity,
        constraint: &'a BoundaryConstraint,
        noise: &'a NoiseField,
    ) -> Self {
        let max_steps = (100.0 * noise.typical()).clamp(20.0, 80.0) as u32;
        Self { connectivity, constraint, noise, max_steps }
    }

    /// First guess of the surface from the vertices `input`: a smoothing that suits the noise. #V×3, model units
    pub(in crate::denoise) fn guess(&self, input: &[DVec3], progress: &dyn Progress) -> Result<Vec<DVec3>, Cancelled> {
        // Noise of a tenth of an edge goes with μ = 1, and as σ² beyond.
        let strengths = self.noise.strengths(|sigma| (100.0 * sigma * sigma).max(0.5));
        let local = LocalStrength { strength: &strengths, edge: &self.noise.edge };
        self.connectivity.umbrella.smoothed_locally(input, local, self.constraint, progress)
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
        let Self { connectivity, noise, .. } = *self;
        let mean_edge = noise.mean_edge();
        let unit = 1.0 / mean_edge;
        let input: Vec<DVec3> = input.iter().map(|p| *p * unit).collect();
        let mut offsets: Vec<DVec3> = guess.iter().zip(&input).map(|(x, p)| *x * unit - p).collect();
        offsets.iter_mut().enumerate().for_each(|(v, offset)| *offset = self.constraint.projected(v, *offset));
        let offsets = offsets.iter().map(|offset| offset.as_vec3a()).collect();
        let shape_operators = vec![Symmetric::default(); connectivity.mesh.face_count()];
        let mut unknowns = Unknowns { offsets, shape_operators };
        let mut positions = vec![DVec3::ZERO; input.len()];
        let mut normals = LinearisedNormals::default();
        let mut weights = HalfEdgeWeights::new(connectivity);
        let edges: Vec<f64> = connectivity.mesh.triangles.iter().map(|t| noise.edge_of(t) * unit).collect();
        let data = DataWeights::of(noise, prior);
        let mut equations = NormalEquations::new(connectivity, self.constraint, data, prior);
        for round in 0..prior.rounds {
            progress.check()?;
            let slots = positions.par_iter_mut().zip(&input).zip(&unknowns.offsets);
            slots.for_each(|((x, p), offset)| *x = *p + offset.as_dvec3());
            normals.update(connectivity, &positions, |f| MAX_GRADIENT / edges[f]);
            let robust = RobustWeights::at_round(prior, round);
            let at = Configuration { normals: &normals, positions: &positions, edges: &edges };
            weights.update(connectivity, &at, &unknowns.shape_operators, &robust);
            let ramp = f64::from(round) / (STIFFNESS_RAMP * f64::from(prior.rounds.max(2) - 1));
            equations.set_tangential_share(ramp.min(1.0));
            let at = Linearisation { normals: &normals, weights: &weights, positions: &positions };
            equations.solve(&at, &mut unknowns, self.max_steps, progress)?;
        }
        Ok(unknowns.offsets.into_iter().map(|offset| offset.as_dvec3() * mean_edge).collect())
    }
}

/// Largest gradient of a normal with respect to a corner, 1/local edge: that of a triangle whose height is a tenth of such an
/// edge. Normals of thinner triangles are not linear over a step anyway.
const MAX_GRADIENT: f64 = 10.0;
