//! The measured accuracy of a map.

use crate::denoise::HeightResidual;
use crate::denoise::limits::Outcome;
#[cfg(doc)]
use crate::map::displacement::MapKind;
use crate::map::layout_issues::LayoutIssues;
#[cfg(doc)]
use crate::map::manifest::Layout;
use serde::{Deserialize, Serialize};
use std::fmt;

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// Accuracy of the written files, which are decoded and applied at λ = 1 in single precision, and compared with p − h·n (or p
/// − δ for vectors) in double precision.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Largest distance of a vertex from its exact position, model units.
    pub max_error: f64,
    /// 99th percentile of these distances, model units.
    pub p99_error: f64,
    /// Mean of these distances, model units.
    pub mean_error: f64,
    /// Bound of the distances whatever the rounding of the program that checks them, model units: `max_error` and one unit in
    /// the last place of the largest coordinate.
    pub error_bound: f64,
    /// Step between two heights (quantum), model units.
    pub quantum: f64,
    /// `max_error` in quanta; `None` for a flat map.
    pub max_error_quanta: Option<f64>,
    /// `p99_error` in quanta; `None` for a flat map.
    pub p99_error_quanta: Option<f64>,
    /// `mean_error` in quanta; `None` for a flat map.
    pub mean_error_quanta: Option<f64>,
    /// `max_error` as a fraction of the range of the map, which is its scale; `None` for a flat map.
    pub max_error_range: Option<f64>,
    /// `p99_error` as a fraction of the range; `None` for a flat map.
    pub p99_error_range: Option<f64>,
    /// `mean_error` as a fraction of the range; `None` for a flat map.
    pub mean_error_range: Option<f64>,
    /// Largest distance between two wedges of one vertex after displacement, model units; 0 without cracks.
    pub seam_gap: f64,
    /// Errors of the map alone, without the rounding of positions to single precision.
    pub map_errors: MapErrors,
    /// Largest error of the map at a vertex that counts as resolved, quanta.
    pub tolerance_quanta: f64,
    /// Number of vertices with a larger error of the map, because the layout gives them no texels of their own.
    pub unresolved_vertices: usize,
    /// Errors with weights of 8 bits, as in the samplers of many GPUs.
    pub eight_bit_weights: Filtered,
    /// Errors that 8, 16 and 32 bits would give.
    pub by_bits: Vec<BitsError>,
    /// Number of vertices with private texels, welded ones counted once.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub private_vertices: usize,
    /// Result of clients that sample each wedge at its own texture coordinate; only with [`Layout::Uv`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own_uvs: Option<OwnUvs>,
    /// Issues of the UV layout; only with [`Layout::Uv`].
    #[serde(flatten)]
    pub layout: LayoutIssues,
    /// Root mean square over the vertices of |δ − h·n|, the part of the displacement that heights leave out, model units; zero
    /// for vectors.
    pub left_out_rms: f64,
    /// Loss of heights in the angles of the faces; only with [`MapKind::Scalar`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heights: Option<HeightsLoss>,
    /// Effect of the limits of the method; `None` without limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<Outcome>,
    /// Number of vertices without a normal, because those of their faces cancel. A height map does not displace them.
    pub vertices_without_normal: usize,
    /// Advice on how to get a better map; `None` if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub suggestion: Option<String>,
}

/// Loss of a height map: the part of the denoised surface that heights along the normals cannot express.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeightsLoss {
    /// Mean angle between the faces of the input and of the denoised surface, degrees.
    #[serde(rename = "turned_deg")]
    pub rotation_deg: f64,
    /// Mean angle between the faces of the denoised surface and of the one that the heights give, degrees.
    pub lost_deg: f64,
    /// Fraction of the vertices whose normal is tilted towards their displacement, so that their faces come out right.
    #[serde(default, rename = "leaning")]
    pub tilted: f64,
}

impl HeightsLoss {
    /// Returns true if a vector map is worth its three channels. Either more than half a degree is lost, which shading shows,
    /// and more than a tenth of the rotation, so that visible noise is left; or so many normals are tilted that they do not
    /// look like normals of the surface any more.
    pub fn is_much(&self) -> bool {
        (self.lost_deg > 0.5 && self.lost_deg > 0.1 * self.rotation_deg) || self.tilted > 0.2
    }
}

impl From<HeightResidual> for HeightsLoss {
    fn from(residual: HeightResidual) -> Self {
        Self { rotation_deg: residual.rotation, lost_deg: residual.angle, tilted: residual.tilted }
    }
}

impl fmt::Display for HeightsLoss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rotation_deg, lost_deg, tilted } = self;
        write!(f, "heights lose {lost_deg:.2}° of the {rotation_deg:.2}° by which denoising rotates the faces")?;
        if *tilted > 0.0 {
            write!(f, ", with {:.1} % of the normals tilted", 100.0 * tilted)?;
        }
        if self.is_much() {
            write!(f, ": a vector map loses nothing")?;
        }
        Ok(())
    }
}

/// Differences between the height that a vertex samples and its exact one; for a vector, the largest of its components.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapErrors {
    /// Largest difference, model units.
    pub max: f64,
    /// 99th percentile of the differences, model units.
    pub p99: f64,
    /// Largest difference, quanta; `None` for a flat map.
    pub max_quanta: Option<f64>,
    /// 99th percentile of the differences, quanta; `None` for a flat map.
    pub p99_quanta: Option<f64>,
}

/// Errors of displaced vertices with weights of another accuracy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Filtered {
    /// Largest distance of a vertex from its exact position, model units.
    pub max_error: f64,
    /// 99th percentile of these distances, model units.
    pub p99_error: f64,
    /// Largest distance between two wedges of one vertex after displacement, model units.
    pub seam_gap: f64,
}

/// Error of a map with a certain number of bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BitsError {
    /// Number of bits of a texel: 8 or 16 (integers), or 32 (floating point).
    pub bits: u32,
    /// Largest distance of a vertex from its exact position, model units.
    pub max_error: f64,
}

/// Displacement by clients that sample each wedge at its own texture coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OwnUvs {
    /// Number of vertices with several wedges.
    pub seam_vertices: usize,
    /// Number of vertices with several wedges that are all displaced to the same position, bit for bit.
    pub bit_equal_seam_vertices: usize,
    /// Largest distance between two wedges of one vertex after displacement, model units.
    pub seam_gap: f64,
    /// Errors of the wedges; only with private texels, of which these clients know nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub errors: Option<OwnUvErrors>,
}

/// Distances of wedges, displaced at their own texture coordinates, from the exact positions of their vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OwnUvErrors {
    /// Largest distance, model units.
    pub max: f64,
    /// Mean of the distances, model units.
    pub mean: f64,
    /// Number of vertices with a wedge that is farther off than the tolerance.
    pub vertices: usize,
}
