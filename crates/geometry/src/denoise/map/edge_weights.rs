//! Weights of the edges between faces in iteratively reweighted least squares.

use super::Prior;
use super::linearised_normals::LinearisedNormals;
use super::symmetric::Symmetric;
use crate::denoise::conjugate_gradients::CHUNK;
use crate::denoise::connectivity::Connectivity;
use crate::mesh::jagged::Index;
use glam::{DVec3, Vec3A};
use rayon::prelude::*;

/// An edge as one of its two faces sees it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HalfEdgeWeight {
    /// Centroid of this face minus that of the other one, cᵢ − cⱼ, local edges.
    pub(super) centroid_offset: Vec3A,
    /// Weight wₑ of the jump of the normal that the shape operators do not explain.
    pub(super) normal_weight: f32,
    /// Weight vₑ of the jump of the shape operator.
    pub(super) shape_operator_weight: f32,
    /// The other face.
    pub(super) other: Index,
}

/// Positions of the vertices and what follows from them.
#[derive(Clone, Copy)]
pub(super) struct Configuration<'a> {
    /// Normals, linearised at the positions.
    pub(super) normals: &'a LinearisedNormals,
    /// Positions of the vertices. #V×3, mean edges
    pub(super) positions: &'a [DVec3],
    /// Length of the edges around each face. #T, mean edges
    pub(super) edges: &'a [f64],
}

/// The robust penalty φ(r) = (1 + |r|²/κ²)^−p of one round, with the weights of the prior.
pub(super) struct RobustWeights {
    strength: f64,
    curvature: f64,
    exponent: f64,
    /// 1/κ²
    sharpness: f64,
}

impl RobustWeights {
    /// Penalty of a round: κ falls geometrically from a first value, at which only strong creases stand out, to the
    /// threshold of the prior (graduated non-convexity, Blake & Zisserman 1987).
    pub(super) fn at_round(prior: &Prior, round: u32) -> Self {
        // As unit vectors, normals that differ by 23° are 0.4 apart.
        const FIRST_KAPPA: f64 = 0.4;
        // The threshold is reached after four fifths of the rounds, so that the last ones converge.
        let progress = if prior.rounds > 1 { 1.25 * f64::from(round) / f64::from(prior.rounds - 1) } else { 1.0 };
        let kappa = FIRST_KAPPA * (prior.threshold / FIRST_KAPPA).powf(progress.min(1.0));
        let strength = prior.strength * kappa.powf(-2.0 * prior.exponent);
        Self {
            strength,
            curvature: strength * prior.curvature,
            exponent: prior.exponent,
            sharpness: 1.0 / (kappa * kappa),
        }
    }

    /// φ for a squared residual.
    fn robust(&self, squared: f64) -> f64 {
        (1.0 + squared * self.sharpness).powf(-self.exponent)
    }
}

/// Weights of all half-edges, in the order of [`Connectivity::half_edges`].
pub(super) struct HalfEdgeWeights {
    pub(super) all: Vec<HalfEdgeWeight>,
    centroids: Vec<DVec3>,
}

impl HalfEdgeWeights {
    /// Weights of zero, to be filled by [`Self::update`].
    pub(super) fn new(connectivity: &Connectivity) -> Self {
        let count = connectivity.half_edges.items().len();
        let centroids = vec![DVec3::ZERO; connectivity.mesh.face_count()];
        Self { all: vec![HalfEdgeWeight::default(); count], centroids }
    }

    /// Computes the weights from the residuals at a configuration and the `shape_operators` there (#T, 1/local edge).
    pub(super) fn update(
        &mut self,
        connectivity: &Connectivity,
        at: &Configuration,
        shape_operators: &[Symmetric],
        robust: &RobustWeights,
    ) {
        let mesh = &connectivity.mesh;
        let Configuration { normals, positions, edges: local_edges } = *at;
        let centroid = |t: &[u32; 3]| t.iter().map(|&v| positions[v as usize]).sum::<DVec3>() / 3.0;
        self.centroids.par_iter_mut().zip(&mesh.triangles).for_each(|(c, t)| *c = centroid(t));
        let centroids = &self.centroids;
        let of_edge = |(&[f, g], &[a, b]): (&[u32; 2], &[u32; 2])| {
            let [f, g] = [f, g].map(|f| f as usize);
            // Long and short edges of a bad triangulation are clamped: they shall not outweigh the others.
            let per_edge = 2.0 / (local_edges[f] + local_edges[g]);
            let centroid_offset = ((centroids[f] - centroids[g]) * per_edge).clamp_length_max(2.0);
            let length = (positions[a as usize].distance(positions[b as usize]) * per_edge).clamp(0.1, 3.0);
            let centroid_offset = centroid_offset.as_vec3a();
            let predicted = (shape_operators[f] + shape_operators[g]).times(0.5 * centroid_offset);
            let normal_jump = normals.normals[f] - normals.normals[g] - predicted;
            let jump = shape_operators[f] - shape_operators[g];
            let of_normal = robust.robust(f64::from(normal_jump.length_squared()));
            let of_shape_operator = robust.robust(f64::from(jump.dot(jump)));
            HalfEdgeWeight {
                centroid_offset,
                normal_weight: (robust.strength * length * of_normal) as f32,
                shape_operator_weight: (robust.curvature * length * of_normal * of_shape_operator) as f32,
                other: g as Index,
            }
        };
        let edges = mesh.edge_faces.par_iter().zip(&mesh.edge_vertices).with_min_len(CHUNK);
        let edges: Vec<HalfEdgeWeight> = edges.map(of_edge).collect();
        let half_edges = connectivity.half_edges.items().par_iter();
        self.all.par_iter_mut().zip(half_edges).with_min_len(CHUNK).for_each(|(half_edge, &(e, other))| {
            *half_edge = edges[e as usize];
            if half_edge.other != other {
                *half_edge = HalfEdgeWeight { centroid_offset: -half_edge.centroid_offset, other, ..*half_edge };
            }
        });
    }
}

#[cfg(test)]
mod tests;
