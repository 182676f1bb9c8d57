//! The triangle mesh of a scene, as plain arrays in single precision.

use glam::{Vec2, Vec3};
use planish_geometry::map::tangents::Tangent;

/// Kind of a side of a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// An edge of the mesh.
    #[default]
    Edge,
    /// An edge at which the texture is cut.
    Seam,
    /// A diagonal inside a polygon.
    Diagonal,
}

/// One triangle: for each corner, the indices of its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Indices into [`Mesh::positions`] and [`Mesh::scalars`].
    pub positions: [u32; 3],
    /// Indices into [`Mesh::normals`].
    pub normals: [u32; 3],
    /// Indices into [`Mesh::uvs`]; none where the file has no texture coordinates.
    pub uvs: Option<[u32; 3]>,
    /// Sides from each corner to the next one.
    pub sides: [Side; 3],
}

/// Triangle mesh as plain arrays. Counter-clockwise triangles face outwards.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Positions, #V×3, near the origin so that f32 is fine enough.
    pub positions: Vec<Vec3>,
    /// Unit normals, #N×3.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, #UV×2, v up.
    pub uvs: Vec<Vec2>,
    /// Triangles of the mesh, #T.
    pub triangles: Vec<Triangle>,
    /// MikkTSpace frames at the corners of the triangles, #T×3, for bump and normal maps; empty where there are none.
    pub tangents: Vec<[Tangent; 3]>,
    /// A number for each position, #V, for heat maps.
    pub scalars: Option<Vec<f32>>,
}
