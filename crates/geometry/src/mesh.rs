//! Surfaces: who touches whom, where vertices lie, normals, Laplacians, and the layout of texture coordinates.
//!
//! Faces and corners have one order in all of these. A corner names a vertex in [`topology::Topology`], which is closed across
//! seams, and a uv vertex in [`atlas::Atlas`], where charts are cut.
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::mesh::{surface::Surface, topology::Topology, weld::{Weld, Welding}};
//!
//! // Two triangles with three vertices each become a square with four.
//! let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Y, DVec3::X, DVec3::new(1.0, 1.0, 0.0)];
//! let weld = Weld::new(&positions, Welding::Exact);
//! let faces = [[0, 1, 2], [3, 4, 5]].map(|face| face.map(|i| weld.vertex_of()[i]).to_vec());
//! let topology = Topology::new(weld.first().len(), faces.into_iter().collect());
//! let square = Surface::new(topology, weld.first().iter().map(|&i| positions[i as usize]).collect());
//! assert_eq!((square.positions().len(), square.topology().edges().len(), square.area()), (4, 5, 1.0));
//! ```

pub mod atlas;
pub mod csr;
pub mod curvature;
pub mod jagged;
pub mod laplacian;
pub(crate) mod locality;
pub(crate) mod nearest;
pub mod normals;
pub mod orientation;
pub mod polygon;
pub mod ray_tree;
pub mod shapes;
pub mod signed_distance;
pub mod surface;
pub mod synthetic_noise;
pub mod topology;
pub(crate) mod triangle_tree;
pub(crate) mod union_find;
pub mod weld;
pub mod winding_number;
