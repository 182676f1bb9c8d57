//! Flaws of a mesh that make results worse than they could be. All of them are handled; whoever gets a result should know.
//!
//! ```
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::source::{flaws::{self, Flaw}, model::Model, obj::{Obj, ObjError}};
//!
//! // A tetrahedron whose last face is turned over.
//! let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 4 3 2\n";
//! let model = Model::new(Obj::parse(text.into())?, Welding::Exact);
//! assert_eq!(flaws::flaws(&model), [Flaw::Turned { edges: 3 }]);
//! # Ok::<(), ObjError>(())
//! ```

use crate::mesh::jagged::Index;
use crate::source::model::Model;
use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;
use std::fmt;
use std::num::NonZero;

/// Distance in mean edge lengths below which two vertices are taken for one that was meant.
const NEARLY_EQUAL: f64 = 1e-2;
/// Fraction of the vertices at the boundary that must have a twin, so that they are worth a word.
const MANY: f64 = 0.1;
/// Step of single precision in mean edge lengths above which it has harmed the shape.
const COARSE: f64 = 0.05;

/// A flaw of a mesh, with what would help.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Flaw {
    /// Some faces are turned over.
    Turned {
        /// Number of edges whose two faces have normals that point to opposite sides.
        edges: usize,
    },
    /// Vertices at the boundary are nearly at the position of another one, as after rounding.
    NearlyEqual {
        /// Number of such vertices.
        vertices: usize,
        /// Largest distance to the other one, model units.
        apart: f64,
        /// True if no two faces share an edge.
        loose: bool,
    },
    /// Coordinates have gone through single precision far from the origin, where its steps are as coarse as the shape.
    Rounded {
        /// Axis of the coordinates: `x`, `y` or `z`.
        axis: char,
        /// Step of single precision there, model units.
        step: f64,
        /// Mean edge length, model units.
        edge: f64,
    },
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Turned { edges } => {
                let edges_lie = if *edges == 1 { "edge lies" } else { "edges lie" };
                write!(
                    f,
                    "{edges} {edges_lie} between faces whose normals point to opposite sides: some faces are turned over; results are better if all face outwards"
                )
            }
            Self::NearlyEqual { vertices, apart, loose } => {
                let what = if *loose { "no two faces share an edge: " } else { "" };
                let vertices_are =
                    if *vertices == 1 { "vertex at the boundary is" } else { "vertices at the boundary are" };
                // The next power of ten is surely above it.
                let weld = 10f64.powf((1.01 * apart).log10().ceil());
                write!(
                    f,
                    "{what}{vertices} {vertices_are} not quite where another one is, but within {apart:.2e}: --weld {weld:e} makes them one"
                )
            }
            Self::Rounded { axis, step, edge } => {
                write!(
                    f,
                    "{axis} has steps of {step}, those of single precision so far from the origin, and edges are {edge:.3} long: export the mesh again with an offset"
                )
            }
        }
    }
}

/// Finds the flaws of a mesh.
pub fn flaws(model: &Model) -> Vec<Flaw> {
    let turned = model.surface().topology().misoriented_edges();
    let turned = (turned > 0).then_some(Flaw::Turned { edges: turned });
    turned.into_iter().chain(nearly_equal(model)).chain(rounded(model)).collect()
}

/// Finds vertices at the boundary that lie nearly where another one lies.
fn nearly_equal(model: &Model) -> Option<Flaw> {
    let surface = model.surface();
    let topology = surface.topology();
    let at_boundary = (0..topology.vertex_count() as Index).filter(|&v| topology.is_boundary(v));
    let mut positions: Vec<[f64; 3]> =
        at_boundary.map(|v| (surface.positions()[v as usize] + 0.0).to_array()).collect();
    let vertices = positions.len();
    // Equal positions are apart on purpose, and would make the tree slow.
    positions.par_sort_unstable_by(|a, b| DVec3::from(*a).to_array().map(f64::to_bits).cmp(&b.map(f64::to_bits)));
    positions.dedup();
    let limit = NEARLY_EQUAL * surface.mean_edge();
    let tree = ImmutableKdTree::<f64, 3>::new_from_slice(&positions).ok()?;
    const TWO: NonZero<usize> = NonZero::new(2).expect("two is not zero");
    let nearest = |p: &[f64; 3]| {
        let found = tree.query(p).nearest_n::<SquaredEuclidean<f64>>(TWO).execute();
        found.get(1).map(|n| n.distance.sqrt()).filter(|d| *d <= limit)
    };
    let near: Vec<f64> = positions.par_iter().filter_map(nearest).collect();
    if near.is_empty() || (near.len() as f64) < MANY * vertices as f64 {
        return None;
    }
    let loose = topology.edge_corners().iter().all(|corners| corners.len() == 1);
    Some(Flaw::NearlyEqual { vertices: near.len(), apart: near.iter().copied().fold(0.0, f64::max), loose })
}

/// Finds the axis with the coarsest steps, if single precision has harmed the shape.
fn rounded(model: &Model) -> Option<Flaw> {
    let surface = model.surface();
    let edge = surface.mean_edge();
    let all = (0..surface.positions().len() as Index).into_par_iter();
    let used = || {
        let used = all.clone().filter(|v| !surface.topology().is_isolated(*v));
        used.map(|v| surface.positions()[v as usize])
    };
    let step = |axis: usize| {
        let largest = used().map(|p| p[axis].abs()).reduce(|| 0.0, f64::max) as f32;
        let step = f64::from(largest) - f64::from(largest.next_down());
        let is_single = || used().all(|p| f64::from(p[axis] as f32) == p[axis]);
        (step >= COARSE * edge && is_single()).then_some((axis, step))
    };
    let (axis, step) = (0..3).filter_map(step).max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(Flaw::Rounded { axis: ['x', 'y', 'z'][axis], step, edge })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::weld::Welding;
    use crate::source::obj::Obj;

    fn found(text: &str) -> Vec<Flaw> {
        flaws(&Model::new(Obj::parse(text.into()).unwrap(), Welding::Exact))
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn a_plain_mesh_has_none() {
        assert_eq!(found(&format!("{SQUARE}f 1 2 3\nf 1 3 4\n")), []);
        // A face that is repeated is none, and neither is the back of one.
        assert_eq!(found(&format!("{SQUARE}f 1 2 3 4\nf 2 3 4 1\nf 4 3 2 1\n")), []);
    }

    #[test]
    fn turned_faces_are_found() {
        let flaws = found(&format!("{SQUARE}f 1 2 3\nf 4 3 1\n"));
        assert_eq!(flaws, [Flaw::Turned { edges: 1 }]);
        assert!(flaws[0].to_string().starts_with("1 edge lies between faces whose normals"), "{}", flaws[0]);
    }

    #[test]
    fn corners_that_are_nearly_equal_are_found_with_the_distance_that_welds_them() {
        let flaws = found(&format!("{SQUARE}v 0.000003 0 0\nv 1 0.999998 0\nf 1 2 3\nf 5 6 4\n"));
        let [Flaw::NearlyEqual { vertices: 4, apart, loose: true }] = flaws[..] else { panic!("{flaws:?}") };
        assert!((apart - 3e-6).abs() < 1e-12, "{apart}");
        assert!(flaws[0].to_string().contains("--weld 1e-5 "), "{}", flaws[0]);
    }

    #[test]
    fn coordinates_that_lost_their_shape_are_found() {
        let flaws = found("v 500000 4500000 0\nv 500000.0625 4500000 0\nv 500000 4500000.5 0\nf 1 2 3\n");
        let [Flaw::Rounded { axis: 'y', step: 0.5, .. }] = flaws[..] else { panic!("{flaws:?}") };
        assert_eq!(found("v 500000.01 4500000.01 0\nv 500000.07 4500000 0\nv 500000 4500000.5 0\nf 1 2 3\n"), []);
    }
}
