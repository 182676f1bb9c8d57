//! Surfaces: who touches whom, where vertices lie, normals, Laplacians, and the layout of texture coordinates.
//!
//! Faces and corners have one order in all of these. A corner names a vertex in [`topology::Topology`], which is closed across
//! seams, and a uv vertex in [`atlas::Atlas`], where charts are cut.

pub mod atlas;
pub mod csr;
pub mod curvature;
pub mod jagged;
pub mod laplacian;
pub(crate) mod locality;
pub mod normals;
pub mod orientation;
pub mod polygon;
pub(crate) mod ray_tree;
pub mod shapes;
pub mod surface;
pub mod synthetic_noise;
pub mod topology;
pub(crate) mod triangle_tree;
pub(crate) mod union_find;
pub mod weld;
