//! Constraints on the result of denoising, whatever the method: weights, a direction, fixed vertices, a largest displacement, the
//! volume.
//!
//! Weights and direction say what the displacements are; the others limit those. If limits conflict, fixed vertices come first, then the largest displacement, then the volume. The input satisfies every
//! limit, so the volume can be restored by the vertices that have not reached theirs.
//!
//! ```
//! use planish_geometry::denoise::{Denoiser, Denoising, limits::Limits};
//! use planish_geometry::mesh::{shapes, weld::{Weld, Welding}};
//! use planish_geometry::progress::Silent;
//!
//! // No vertex may go farther than a hundredth of an edge, and the first two stay.
//! let surface = shapes::dented_sphere(2);
//! let limits = Limits { fixed: "1-2".parse()?, max_displacement: Some(0.01), ..Limits::default() };
//! let denoising = Denoising { denoiser: Denoiser::named("laplacian").unwrap(), limits };
//! let weld = Weld::new(surface.positions(), Welding::None);
//! let deltas = denoising.run(&surface, &weld, denoising.output(), &Silent)?.deltas;
//!
//! let lengths: Vec<f64> = deltas.iter().map(|delta| delta.length() / surface.mean_edge()).collect();
//! assert_eq!(lengths[..2], [0.0; 2]);
//! let longest = lengths.iter().copied().fold(0.0, f64::max);
//! assert!((longest - 0.01).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod direction;
mod mask;
mod volume;
mod weights;

pub use direction::{Direction, DirectionError};
pub use mask::{Mask, MaskError};
pub use weights::{Weights, WeightsError};

use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use crate::mesh::topology::Topology;
use crate::mesh::weld::Weld;
use crate::named;
use crate::progress::{Cancelled, Progress};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Limits for any method; the default has none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Vertices that stay where they are, bit for bit.
    pub fixed: Mask,
    /// Largest distance of a vertex from its position in the input, mean edge lengths of the input.
    pub max_displacement: Option<f64>,
    /// Treatment of the enclosed volume.
    pub volume: Volume,
    /// How far each vertex may go; `None` if all go as far as the method moves them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mask: Option<WeightMask>,
    /// Direction along which vertices move; `None` if they move in any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<Direction>,
}

/// Weights of the vertices, and where they come from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WeightMask {
    /// Source of the weights, as the user gave it.
    pub from: String,
    /// Weights by which displacements are multiplied; a vertex with weight 0 stays where it is, bit for bit.
    pub weights: Weights,
}

named! {
    /// Treatment of the enclosed volume.
    #[derive(Default)]
    pub enum Volume {
        /// The volume becomes what the method makes of it.
        #[default]
        Free = "free",
        /// The volume of the input is restored.
        Preserve = "preserve",
    }
}

/// Reasons why limits do not fit a surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LimitsError {
    /// The mask names a source vertex that the mesh does not have.
    #[error("`v` line {line} shall stay, but there are {v_lines}")]
    NoSuchLine {
        /// Number of the source vertex, counted from 1.
        line: Index,
        /// Number of source vertices.
        v_lines: usize,
    },
    /// Heights along normals cannot move vertices along another direction.
    #[error("vertices that move along {0} cannot be moved by heights along their normals")]
    NotAlongNormals(Direction),
    /// The largest displacement is negative or not a number.
    #[error("{0} is no largest displacement")]
    NotALength(f64),
    /// The volume is not defined: the sum of tetrahedra over the faces depends on where their apex is, or would after a
    /// motion of these edges.
    #[error(
        "encloses no volume: {edges} edges that may move are open, or their faces disagree about what is outside \
         (the first is between the `v` lines {} and {})", .first[0], .first[1]
    )]
    Open {
        /// Number of such edges.
        edges: usize,
        /// Source vertices at the ends of the first one, counted from 1.
        first: [Index; 2],
    },
}

impl Limits {
    /// Returns true if there are no limits.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
    /// Limits for the vertices of a surface, whose source vertices were welded like this.
    pub fn on(&self, surface: &Surface, weld: &Weld) -> Result<Bounds, LimitsError> {
        let v_lines = weld.vertex_of().len();
        let masked = self.mask.as_ref().map_or(0, |mask| mask.weights.highest());
        let line = self.fixed.highest().max(masked);
        if line as usize > v_lines {
            return Err(LimitsError::NoSuchLine { line, v_lines });
        }
        if let Some(d) = self.max_displacement.filter(|d| !d.is_finite() || *d < 0.0) {
            return Err(LimitsError::NotALength(d));
        }
        let mut fixed = self.fixed.of(surface.topology(), weld);
        let weights = self.mask.as_ref().map(|mask| mask.weights.of(fixed.len(), weld)).unwrap_or_default();
        weights.iter().zip(&mut fixed).filter(|(weight, _)| **weight == 0.0).for_each(|(_, fixed)| *fixed = true);
        if self.volume == Volume::Preserve {
            let moves = |edge: &[Index; 2]| edge.iter().any(|&v| !fixed[v as usize]);
            let open: Vec<[Index; 2]> = unbalanced_edges(surface.topology()).filter(moves).collect();
            if let Some(first) = open.first() {
                let first = first.map(|v| weld.first()[v as usize] + 1);
                return Err(LimitsError::Open { edges: open.len(), first });
            }
        }
        let reach = self.max_displacement.map_or(f64::INFINITY, |d| d * surface.mean_edge());
        let directions = self.direction.map(|direction| direction.of(surface)).unwrap_or_default();
        Ok(Bounds { fixed, weights, directions, reach, volume: self.volume })
    }
}

/// Edges whose faces do not run along them equally often in both directions. A surface without such edges encloses a
/// volume.
fn unbalanced_edges(topology: &Topology) -> impl Iterator<Item = [Index; 2]> {
    let edges = topology.edges().iter().zip(topology.edge_corners().iter());
    let unbalanced = edges.filter(|(edge, corners)| {
        let forwards = corners.iter().filter(|&&c| topology.vertex(c) == edge[0]).count();
        2 * forwards != corners.len()
    });
    unbalanced.map(|(edge, _)| *edge)
}

/// Limits for the vertices of one surface.
#[derive(Clone, Debug)]
pub struct Bounds {
    /// True for vertices that stay. #V
    fixed: Vec<bool>,
    /// Weights of the displacements; empty if all are 1. #V
    weights: Vec<f64>,
    /// Unit directions of the displacements; empty if vertices move in any direction. #V×3
    directions: Vec<DVec3>,
    /// Largest displacement, model units; infinite without a limit.
    reach: f64,
    volume: Volume,
}

/// Effect of the limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Number of fixed vertices.
    pub fixed_vertices: usize,
    /// Number of vertices with the largest displacement that is allowed.
    pub stopped_vertices: usize,
    /// Number of vertices whose displacement was multiplied by a weight below 1; 0 without a mask.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub weighted_vertices: usize,
    /// Change of the volume, with [`Volume::Preserve`] only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeChange>,
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// Change of the enclosed volume, cubic model units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VolumeChange {
    /// Change by the method within the other limits.
    pub by_method: f64,
    /// Change that remains after the volume was restored.
    pub left: f64,
    /// True if the remaining change is rounding. If not, no vertex could move any farther to restore the rest.
    pub restored: bool,
}

impl Bounds {
    /// Returns true if nothing is limited.
    pub(super) fn are_none(&self) -> bool {
        self.volume == Volume::Free
            && self.reach == f64::INFINITY
            && self.weights.is_empty()
            && self.directions.is_empty()
            && !self.fixed.contains(&true)
    }

    /// Turns the δ of a method (#V×3, model units) into the direction of the limits and multiplies them by the weights. All other
    /// limits are for the result of this.
    pub(super) fn shape(&self, surface: &Surface, deltas: &mut Vec<DVec3>) {
        if !self.directions.is_empty() {
            *deltas = direction::along(surface, &self.directions, deltas);
        }
        deltas.iter_mut().zip(&self.weights).for_each(|(delta, weight)| *delta *= *weight);
    }

    /// Vectors (#V×3) along which vertices restore the volume: the normals, or the directions of the limits on their side, times the
    /// weights.
    fn lifts(&self, normals: &[DVec3]) -> Vec<DVec3> {
        let mut lifts = normals.to_vec();
        for (lift, direction) in lifts.iter_mut().zip(&self.directions) {
            *lift = *direction * direction.dot(*lift).signum() + DVec3::ZERO;
        }
        lifts.iter_mut().zip(&self.weights).for_each(|(lift, weight)| *lift *= *weight);
        lifts
    }

    /// Shortens δ (#V×3, model units) to satisfy all limits but that of the volume; directions stay.
    pub fn clamp(&self, deltas: &mut [DVec3]) {
        for (v, delta) in deltas.iter_mut().enumerate() {
            *delta = self.allowed(v, *delta);
        }
    }

    /// Changes δ (#V×3, model units) to satisfy all limits. The volume is restored by motion along `directions`, the normals
    /// of the input (#V×3, unit or zero), so that a δ along its normal stays there.
    pub fn apply(
        &self,
        surface: &Surface,
        directions: &[DVec3],
        deltas: &mut Vec<DVec3>,
        progress: &dyn Progress,
    ) -> Result<Option<Outcome>, Cancelled> {
        if self.are_none() {
            return Ok(None);
        }
        self.clamp(deltas);
        let mut volume = None;
        if self.volume == Volume::Preserve {
            progress.stage("restoring the volume");
            volume = Some(volume::restore(self, surface, &self.lifts(directions), deltas, progress)?);
        }
        // Shortening may have cost a few bits.
        let stopped = |(delta, fixed): &(&DVec3, &bool)| !**fixed && delta.length() >= self.reach * (1.0 - 1e-12);
        Ok(Some(Outcome {
            fixed_vertices: self.fixed.iter().filter(|fixed| **fixed).count(),
            weighted_vertices: self.weights.iter().filter(|weight| **weight < 1.0).count(),
            stopped_vertices: deltas.iter().zip(&self.fixed).filter(stopped).count(),
            volume,
        }))
    }

    /// The δ that a vertex may have nearest to the given one.
    fn allowed(&self, v: usize, delta: DVec3) -> DVec3 {
        if self.fixed[v] {
            return DVec3::ZERO;
        }
        let mut allowed = delta;
        let mut length = delta.length();
        // Rounding may leave the product a bit too long.
        while length > self.reach {
            allowed *= self.reach / length * (1.0 - f64::EPSILON);
            length = allowed.length();
        }
        allowed
    }
}

#[cfg(test)]
mod tests;
