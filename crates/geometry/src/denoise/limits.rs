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
    fn are_none(&self) -> bool {
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
mod tests {
    use super::*;
    use crate::denoise::{Denoiser, Denoising, DenoisingError, Laplacian, Moved};
    use crate::mesh::shapes;
    use crate::mesh::weld::Welding;
    use crate::progress::Silent;

    fn on(limits: &Limits, surface: &Surface) -> Result<Bounds, LimitsError> {
        limits.on(surface, &Weld::new(surface.positions(), Welding::None))
    }

    #[test]
    fn limits_that_do_not_fit_are_refused() {
        let grid = shapes::grid(2);
        let fixed = |text: &str| Limits { fixed: text.parse().unwrap(), ..Limits::default() };
        assert!(on(&fixed("9"), &grid).is_ok());
        let error = on(&fixed("9-10"), &grid).unwrap_err();
        assert_eq!(error, LimitsError::NoSuchLine { line: 10, v_lines: 9 });
        for d in [-1.0, f64::NAN, f64::INFINITY] {
            let limits = Limits { max_displacement: Some(d), ..Limits::default() };
            assert!(matches!(on(&limits, &grid), Err(LimitsError::NotALength(_))));
        }
    }

    #[test]
    fn an_open_surface_has_a_volume_as_long_as_its_boundary_stays() {
        let grid = shapes::grid(2);
        let keep =
            |fixed: &str| Limits { fixed: fixed.parse().unwrap(), volume: Volume::Preserve, ..Limits::default() };
        assert!(on(&keep("boundary"), &grid).is_ok());
        // All around, but for the third vertex of the lower row, which has two boundary edges.
        let error = on(&keep("1-2 4 6-9"), &grid).unwrap_err();
        assert_eq!(error, LimitsError::Open { edges: 2, first: [2, 3] });
        // A face that is turned over makes a wall of its edges.
        let cube = shapes::cube();
        let mut faces: Vec<Vec<Index>> = cube.topology().faces().iter().map(Vec::from).collect();
        assert!(on(&keep(""), &cube).is_ok());
        faces[0].reverse();
        let turned = Surface::new(Topology::new(8, faces.into_iter().collect()), cube.positions().to_vec());
        assert!(matches!(on(&keep(""), &turned), Err(LimitsError::Open { edges: 4, .. })));
    }

    #[test]
    fn a_sphere_that_was_smoothed_keeps_its_volume_and_becomes_no_rougher() {
        let sphere = shapes::dented_sphere(3);
        let denoiser = Denoiser::Laplacian(Laplacian { iterations: 30, ..Laplacian::default() });
        let weld = Weld::new(sphere.positions(), Welding::None);
        let after = |volume| {
            let denoising = Denoising { denoiser: denoiser.clone(), limits: Limits { volume, ..Limits::default() } };
            let Moved { deltas, limits: outcome, .. } =
                denoising.run(&sphere, &weld, denoising.output(), &Silent).unwrap();
            (sphere.at(sphere.moved_by(&deltas)), outcome)
        };
        let [(shrunk, _), (restored, outcome)] = [Volume::Free, Volume::Preserve].map(after);
        let change = outcome.unwrap().volume.unwrap();
        assert!((change.by_method - (shrunk.volume() - sphere.volume())).abs() < 1e-12);
        assert!(change.by_method < -0.1 * sphere.volume());
        // Spread of the radii, against their mean.
        let roughness = |surface: &Surface| {
            let radii: Vec<f64> = surface.positions().iter().map(|p| p.length()).collect();
            let mean = radii.iter().sum::<f64>() / radii.len() as f64;
            (radii.iter().map(|r| (r / mean - 1.0).powi(2)).sum::<f64>() / radii.len() as f64).sqrt()
        };
        assert!(roughness(&restored) < 1.1 * roughness(&shrunk));
    }

    #[test]
    fn where_nothing_is_free_nothing_is_done() {
        let sphere = shapes::dented_sphere(1);
        let weld = Weld::new(sphere.positions(), Welding::None);
        let limits = Limits { fixed: "1-42".parse().unwrap(), volume: Volume::Preserve, ..Limits::default() };
        let denoising = Denoising { limits, ..Denoising::default() };
        let Moved { deltas, limits: outcome, .. } = denoising.run(&sphere, &weld, denoising.output(), &Silent).unwrap();
        assert_eq!(deltas, [DVec3::ZERO; 42]);
        let change = VolumeChange { by_method: 0.0, left: 0.0, restored: true };
        assert_eq!(
            outcome,
            Some(Outcome { fixed_vertices: 42, stopped_vertices: 0, weighted_vertices: 0, volume: Some(change) })
        );
        let limits = Limits { fixed: "43".parse().unwrap(), ..Limits::default() };
        let denoising = Denoising { limits, ..Denoising::default() };
        let error = denoising.run(&sphere, &weld, denoising.output(), &Silent).unwrap_err();
        assert!(matches!(error, DenoisingError::Limits(LimitsError::NoSuchLine { line: 43, v_lines: 42 })));
    }

    #[test]
    fn numbers_that_are_none_end_the_search() {
        let sphere = shapes::dented_sphere(1);
        let bounds = on(&Limits { volume: Volume::Preserve, ..Limits::default() }, &sphere).unwrap();
        let mut deltas = vec![DVec3::splat(f64::INFINITY); 42];
        let along = vec![DVec3::X; 42];
        let outcome = bounds.apply(&sphere, &along, &mut deltas, &Silent).unwrap().unwrap();
        assert!(!outcome.volume.unwrap().restored);
    }

    /// A dented sphere, its displacements within limits, and what the limits did.
    fn limited(limits: Limits) -> (Surface, Vec<DVec3>, Outcome) {
        let sphere = shapes::dented_sphere(3);
        let denoiser = Denoiser::Laplacian(Laplacian { iterations: 5, ..Laplacian::default() });
        let weld = Weld::new(sphere.positions(), Welding::None);
        let denoising = Denoising { denoiser, limits };
        let moved = denoising.run(&sphere, &weld, denoising.output(), &Silent).unwrap();
        (sphere, moved.deltas, moved.limits.unwrap_or_default())
    }

    fn mask(weights: &[f32]) -> Limits {
        let mask = WeightMask { from: "test".to_owned(), weights: Weights::new(weights) };
        Limits { mask: Some(mask), ..Limits::default() }
    }

    #[test]
    fn vertices_go_as_far_as_their_weight_says() {
        let (sphere, free, _) = limited(Limits::default());
        let weights: Vec<f32> = (0..sphere.positions().len()).map(|v| (v % 4) as f32 / 3.0).collect();
        let (_, deltas, outcome) = limited(mask(&weights));
        for ((delta, free), weight) in deltas.iter().zip(&free).zip(&weights) {
            assert!(delta.distance(*free * f64::from(*weight)) <= 1e-7 * free.length());
            assert!(*weight > 0.0 || *delta == DVec3::ZERO);
        }
        let count = |picked: &dyn Fn(f32) -> bool| weights.iter().filter(|weight| picked(**weight)).count();
        assert_eq!((outcome.fixed_vertices, outcome.weighted_vertices), (count(&|w| w == 0.0), count(&|w| w < 1.0)));
    }

    #[test]
    fn vertices_move_along_their_direction_alone() {
        for (direction, volume) in
            [("0,0,1", Volume::Free), ("0,0,-2", Volume::Preserve), ("ray:3,0,0", Volume::Preserve)]
        {
            let direction: Direction = direction.parse().unwrap();
            let (sphere, deltas, outcome) = limited(Limits {
                direction: Some(direction),
                volume,
                max_displacement: Some(0.3),
                ..Limits::default()
            });
            for (delta, along) in deltas.iter().zip(direction.of(&sphere)) {
                assert!(delta.cross(along).length() <= 1e-12 * sphere.mean_edge(), "{delta} {along}");
                assert!(delta.length() <= 0.3 * sphere.mean_edge());
            }
            assert!(deltas.iter().any(|delta| delta.length() > 0.01 * sphere.mean_edge()));
            assert!(outcome.volume.is_none_or(|change| change.left.abs() < change.by_method.abs()), "{outcome:?}");
        }
    }

    #[test]
    fn heights_along_normals_are_no_motion_along_a_direction() {
        let sphere = shapes::dented_sphere(2);
        let direction = Direction::Axis(DVec3::Z);
        let limits = Limits { direction: Some(direction), ..Limits::default() };
        let denoising = Denoising { denoiser: Denoiser::Laplacian(Laplacian::default()), limits };
        let weld = Weld::new(sphere.positions(), Welding::None);
        let error = denoising.run(&sphere, &weld, crate::denoise::Output::Heights(None), &Silent).unwrap_err();
        assert_eq!(error, DenoisingError::Limits(LimitsError::NotAlongNormals(direction)));
    }
}
