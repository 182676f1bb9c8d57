//! Displacements of the vertices as the channels of a map.

use super::VertexDisplacements;
use crate::map::displacement::MapKind;
use crate::map::tangents::Tangent;
use crate::source::model::Model;
use glam::{DMat3, DVec3, Vec3};

/// Displacements that a map has to hold, as positions and as the numbers of its channels.
pub(super) struct Offsets {
    /// Position of each vertex at λ = 1. #V×3, model units
    pub(super) positions: Vec<DVec3>,
    /// Channels with one number for each vertex. #V each, model units
    pub(super) channels: Vec<Vec<f64>>,
}

impl Offsets {
    /// Splits displacements into the channels of a map. `frames` (#V) are used in tangent space only.
    pub(super) fn new(model: &Model, kind: MapKind, displacements: &VertexDisplacements, frames: &[Tangent]) -> Self {
        let (deltas, normals) = (&displacements.deltas, &displacements.normals);
        let displaced = |offset: &dyn Fn(usize) -> DVec3| {
            model.surface().positions().iter().enumerate().map(|(v, p)| *p - offset(v)).collect()
        };
        match (kind, &displacements.heights) {
            (MapKind::Scalar, Some((heights, _))) => {
                let positions = displaced(&|v| heights[v] * normals[v].as_dvec3());
                Self { positions, channels: vec![heights.clone()] }
            }
            (MapKind::Scalar | MapKind::VectorObject, _) => {
                Self { positions: displaced(&|v| deltas[v]), channels: split(deltas) }
            }
            (MapKind::VectorTangent, _) => {
                let local = |((delta, n), frame): ((&DVec3, &Vec3), &Tangent)| {
                    let [t, b, n] = frame.frame(*n).map(Vec3::as_dvec3);
                    let local = DMat3::from_cols(t, b, n).inverse() * *delta;
                    if local.is_finite() { local } else { DVec3::ZERO }
                };
                let local: Vec<DVec3> = deltas.iter().zip(normals).zip(frames).map(local).collect();
                let has_frame = |v: usize| if normals[v] == Vec3::ZERO { 0.0 } else { 1.0 };
                Self { positions: displaced(&|v| deltas[v] * has_frame(v)), channels: split(&local) }
            }
        }
    }
}

fn split(vectors: &[DVec3]) -> Vec<Vec<f64>> {
    (0..3).map(|axis| vectors.iter().map(|v| v[axis]).collect()).collect()
}

/// Positions p − λ · δ, given the positions at λ = 1 (#V×3). #V×3, model units
pub(super) fn apply_offsets(model: &Model, denoised: &[DVec3], lambda: f64) -> Vec<DVec3> {
    model.surface().positions().iter().zip(denoised).map(|(p, q)| *p - lambda * (*p - *q)).collect()
}
