//! What is drawn: one triangle mesh, ready for f32, and the maps and pictures on it.

use crate::texture::Texture;
use glam::{Vec2, Vec3};
use planish_geometry::apply::ShaderVertex;
use planish_geometry::displacement::Displacement;
use planish_geometry::texture::tangents::Tangent;
use std::ops::Range;
use thiserror::Error;

/// One triangle: for each corner, where to find its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Into [`Mesh::positions`] and [`Mesh::scalars`].
    pub positions: [u32; 3],
    /// Into [`Mesh::normals`].
    pub normals: [u32; 3],
    /// Into [`Mesh::uvs`]; none where the file has no texture coordinates.
    pub uvs: Option<[u32; 3]>,
}

/// Plain arrays. Counter-clockwise triangles face outwards.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// #V, near the origin so that f32 is fine enough.
    pub positions: Vec<Vec3>,
    /// Unit vectors.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, v up.
    pub uvs: Vec<Vec2>,
    /// The faces.
    pub triangles: Vec<Triangle>,
    /// A number for each position, for heat maps.
    pub scalars: Option<Vec<f32>>,
    /// MikkTSpace frames at the corners of each triangle; what tilts normals needs them.
    pub tangents: Option<Vec<[Tangent; 3]>>,
    /// Which triangles have which texture, one after the other; empty if all have the first.
    pub groups: Vec<Group>,
}

/// Triangles with one texture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Into [`Mesh::triangles`].
    pub triangles: Range<usize>,
    /// Into [`Scene::textures`].
    pub texture: Option<usize>,
}

/// A displacement map on a mesh.
#[derive(Clone, Debug)]
pub struct Carried {
    /// The map.
    pub map: Displacement,
    /// The vertices as the map displaces them, one for each position. #V
    pub vertices: Vec<ShaderVertex>,
    /// How far the map leaves each vertex off its place at λ = 1, model units, where that is known. #V
    pub errors: Option<Vec<f32>>,
}

/// A tangent-space normal map.
#[derive(Clone, Debug)]
pub struct NormalMap {
    /// Linear: n = 2 · rgb − 1, green up.
    pub texels: Texture,
    /// What the frames that it was baked in have as normals.
    pub frames: FrameNormals,
}

/// Normals of tangent frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameNormals {
    /// Those along which the displacement map displaces: one for each vertex.
    Carrier,
    /// Those that corners are lit with.
    Corner,
}

/// A ball.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sphere {
    /// Its middle.
    pub centre: Vec3,
    /// Its radius.
    pub radius: f32,
}

/// A mesh whose indices are all in range, and what belongs to it.
#[derive(Clone, Debug)]
pub struct Scene {
    mesh: Mesh,
    bounds: Sphere,
    carried: Option<Carried>,
    /// Base colours, for triangles that have texture coordinates.
    pub textures: Vec<Texture>,
    /// For normals from a map.
    pub normal_map: Option<NormalMap>,
    /// Heights in red, for bumps and displacement as an effect.
    pub relief: Option<Texture>,
}

/// Why arrays are not a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum SceneError {
    /// A corner names a position, normal or texture coordinate that is not there.
    #[error("triangle {triangle} has a corner out of range")]
    CornerOutOfRange {
        /// Zero-based.
        triangle: usize,
    },
    /// There must be one number per position.
    #[error("{found} numbers for {expected} vertices")]
    ScalarCount {
        /// Numbers.
        found: usize,
        /// Positions.
        expected: usize,
    },
    /// There must be one vertex of the map per position.
    #[error("the map displaces {found} of {expected} vertices")]
    CarriedCount {
        /// Vertices of the map.
        found: usize,
        /// Positions.
        expected: usize,
    },
    /// There must be three tangents per triangle.
    #[error("tangents for {found} of {expected} triangles")]
    TangentCount {
        /// Triples of tangents.
        found: usize,
        /// Triangles.
        expected: usize,
    },
    /// Groups must cover the triangles one after the other.
    #[error("the group of triangle {triangle} does not follow the one before")]
    Groups {
        /// Zero-based, the first of the group, or the number of triangles if the last groups are missing.
        triangle: usize,
    },
}

impl Scene {
    /// Checks the mesh.
    pub fn new(mesh: Mesh) -> Result<Self, SceneError> {
        let inside = |corners: [u32; 3], len: usize| corners.iter().all(|&i| (i as usize) < len);
        let valid = |t: &Triangle| {
            inside(t.positions, mesh.positions.len())
                && inside(t.normals, mesh.normals.len())
                && t.uvs.is_none_or(|uvs| inside(uvs, mesh.uvs.len()))
        };
        if let Some(triangle) = mesh.triangles.iter().position(|t| !valid(t)) {
            return Err(SceneError::CornerOutOfRange { triangle });
        }
        let expected = mesh.positions.len();
        if let Some(found) = mesh.scalars.as_ref().map(Vec::len).filter(|found| *found != expected) {
            return Err(SceneError::ScalarCount { found, expected });
        }
        let expected = mesh.triangles.len();
        if let Some(found) = mesh.tangents.as_ref().map(Vec::len).filter(|found| *found != expected) {
            return Err(SceneError::TangentCount { found, expected });
        }
        let mut end = 0;
        for group in &mesh.groups {
            if group.triangles.start != end || group.triangles.end < end {
                return Err(SceneError::Groups { triangle: group.triangles.start });
            }
            end = group.triangles.end;
        }
        if !mesh.groups.is_empty() && end != expected {
            return Err(SceneError::Groups { triangle: end });
        }
        let bounds = bounds(&mesh);
        Ok(Self { mesh, bounds, carried: None, textures: Vec::new(), normal_map: None, relief: None })
    }

    /// Puts a displacement map on the mesh. Its vertices take the place of the mesh's positions.
    pub fn carry(&mut self, carried: Carried) -> Result<(), SceneError> {
        let (found, expected) = (carried.vertices.len(), self.mesh.positions.len());
        if found != expected || carried.errors.as_ref().is_some_and(|errors| errors.len() != expected) {
            return Err(SceneError::CarriedCount { found, expected });
        }
        for (position, vertex) in self.mesh.positions.iter_mut().zip(&carried.vertices) {
            *position = vertex.position;
        }
        self.bounds = bounds(&self.mesh);
        self.carried = Some(carried);
        Ok(())
    }

    /// The displacement map.
    pub fn carried(&self) -> Option<&Carried> {
        self.carried.as_ref()
    }

    /// Which triangles have which texture.
    pub fn groups(&self) -> Vec<Group> {
        if self.mesh.groups.is_empty() {
            return vec![Group { triangles: 0..self.mesh.triangles.len(), texture: Some(0) }];
        }
        self.mesh.groups.clone()
    }

    /// The texture of a group.
    pub fn texture(&self, group: &Group) -> Option<&Texture> {
        group.texture.and_then(|i| self.textures.get(i))
    }

    /// The arrays.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// A sphere about all triangles (about the middle of their box; not the smallest one).
    pub fn bounds(&self) -> Sphere {
        self.bounds
    }
}

/// Vertices without a face are not drawn and do not count.
fn bounds(mesh: &Mesh) -> Sphere {
    let drawn = || mesh.triangles.iter().flat_map(|t| t.positions).map(|i| mesh.positions[i as usize]);
    let Some(first) = drawn().next() else { return Sphere::default() };
    let (low, high) = drawn().fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
    let centre = 0.5 * (low + high);
    let radius = drawn().map(|p| p.distance(centre)).fold(0.0, f32::max);
    Sphere { centre, radius }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::splat(1e6)],
            normals: vec![Vec3::Z],
            triangles: vec![Triangle { positions: [0, 1, 2], normals: [0; 3], uvs: None }],
            ..Mesh::default()
        }
    }

    #[test]
    fn isolated_vertices_do_not_move_the_camera() {
        let bounds = Scene::new(triangle()).unwrap().bounds();
        assert_eq!(bounds, Sphere { centre: Vec3::new(0.5, 0.5, 0.0), radius: 0.5f32.sqrt() });
    }

    #[test]
    fn bad_corners_and_counts_are_refused() {
        let mut mesh = triangle();
        mesh.triangles[0].uvs = Some([0; 3]);
        assert_eq!(Scene::new(mesh).unwrap_err(), SceneError::CornerOutOfRange { triangle: 0 });
        let mesh = Mesh { scalars: Some(vec![0.0; 3]), ..triangle() };
        assert_eq!(Scene::new(mesh).unwrap_err(), SceneError::ScalarCount { found: 3, expected: 4 });
    }
}
