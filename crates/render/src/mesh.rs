//! The triangle mesh of a scene, as plain arrays in single precision.
//!
//! ```
//! use glam::Vec3;
//! use planish_render::mesh::{Mesh, Side, Triangle};
//! use planish_render::scene::{Scene, SceneError};
//!
//! // A square of two triangles with one normal. Lines along edges leave its diagonal out.
//! let triangle = |positions, sides| Triangle { positions, normals: [0; 3], uvs: None, sides, ..Triangle::default() };
//! let square = Mesh {
//!     positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
//!     normals: vec![Vec3::Z],
//!     triangles: vec![
//!         triangle([0, 1, 2], [Side::Edge, Side::Edge, Side::Diagonal]),
//!         triangle([0, 2, 3], [Side::Diagonal, Side::Edge, Side::Edge]),
//!     ],
//!     ..Mesh::default()
//! };
//! assert!((Scene::new(square.clone())?.bounds().radius - 0.5f32.sqrt()).abs() < 1e-6);
//! let cut = Mesh { positions: square.positions[..3].to_vec(), ..square };
//! assert_eq!(Scene::new(cut).unwrap_err(), SceneError::CornerOutOfRange { triangle: 1 });
//! # Ok::<(), SceneError>(())
//! ```

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

/// Sides of a triangle that are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Facing {
    /// Both sides.
    #[default]
    Both,
    /// The outer side, because the inner one is that of a back at the same place.
    Front,
    /// The outer side of a back. Its vertices are those of its front, so that the normals of these have to be turned round for it.
    Back,
}

/// One triangle: for each corner, the indices of its values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Triangle {
    /// Indices into [`Mesh::positions`] and [`Mesh::scalars`].
    pub positions: [u32; 3],
    /// Indices into [`Mesh::normals`].
    pub normals: [u32; 3],
    /// Indices into [`Mesh::uvs`]; none where the file has no texture coordinates.
    pub uvs: Option<[u32; 3]>,
    /// Sides from each corner to the next one.
    pub sides: [Side; 3],
    /// Sides of the triangle that are drawn.
    pub facing: Facing,
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
