//! The scene of a picture: one triangle mesh in single precision, and the map that displaces it.
//!
//! ```
//! use glam::Vec3;
//! use image::RgbaImage;
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::source::{model::Model, obj::Obj};
//! use planish_render::{input, software};
//! use planish_render::settings::{Settings, Shading, Size};
//! use planish_render::texture::{Content, Texture, Textures};
//!
//! // A square with a red texture.
//! let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
//! let mut scene = input::scene(&Model::new(Obj::parse(text.into())?, Welding::Exact), None)?;
//! let red = RgbaImage::from_pixel(1, 1, [255, 0, 0, 255].into());
//! scene.textures = Textures::one(Texture::new(red, Content::Colour).unwrap());
//! let size = Size { width: 16, height: 12 };
//! let picture = software::render(&scene, &Settings { size, shading: Shading::Texture, ..Settings::default() });
//! let [r, g, b, _] = picture.get_pixel(8, 6).0;
//! assert!(r > 100 && r > 3 * g && r > 3 * b, "{r} {g} {b}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::bounds::Sphere;
use crate::displaced_mesh::DisplacementBinding;
use crate::environment::Environment;
use crate::mesh::{Mesh, Triangle};
use crate::texture::{Texture, Textures};
use crate::volume::Volume;
use glam::Vec3;
use std::sync::Arc;
use thiserror::Error;

/// A mesh whose indices are all in range, and what belongs to it.
#[derive(Clone, Debug)]
pub struct Scene {
    mesh: Mesh,
    bounds: Sphere,
    /// Least coordinates of all triangles.
    low: Vec3,
    /// Base colours, for triangles that have texture coordinates.
    pub textures: Textures,
    /// Tangent-space normals (green along v, up), for triangles that have texture coordinates.
    pub normal_maps: Textures,
    /// Ambient occlusion of the surface, by which ambient light is multiplied.
    pub occlusion: Option<Occlusion>,
    /// Displacement map of the mesh.
    pub displacement: Option<DisplacementBinding>,
    /// Light from all around.
    pub environment: Option<Environment>,
    /// Volume in and around the mesh; shared, because it may be large.
    volume: Option<Arc<Volume>>,
}

/// Fraction of the ambient light that reaches the surface, 0..=1.
#[derive(Clone, Debug)]
pub enum Occlusion {
    /// Grey picture for triangles that have texture coordinates.
    Picture(Texture),
    /// Number for each position of the mesh; 1 where there is none. #V
    Vertices(Vec<f32>),
}

/// Reason why arrays are not a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A corner names a position, normal or texture coordinate that is not there.
    #[error("triangle {triangle} has a corner out of range")]
    CornerOutOfRange {
        /// Index of the triangle, from 0.
        triangle: usize,
    },
    /// The mesh has tangent frames, but not one per triangle.
    #[error("{found} tangent frames for {expected} triangles")]
    TangentCount {
        /// Number of frames.
        found: usize,
        /// Number of triangles.
        expected: usize,
    },
    /// The mesh has numbers for heat maps, but not one per position.
    #[error("{found} numbers for {expected} vertices")]
    ScalarCount {
        /// Number of numbers.
        found: usize,
        /// Number of positions.
        expected: usize,
    },
}

impl Scene {
    /// Checks that all indices of a mesh are in range.
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
        let (found, expected) = (mesh.tangents.len(), mesh.triangles.len());
        if found > 0 && found != expected {
            return Err(SceneError::TangentCount { found, expected });
        }
        let expected = mesh.positions.len();
        match &mesh.scalars {
            Some(scalars) if scalars.len() != expected => {
                Err(SceneError::ScalarCount { found: scalars.len(), expected })
            }
            _ => {
                let (bounds, low) = bounds(&mesh);
                Ok(Self {
                    mesh,
                    bounds,
                    low,
                    textures: Textures::default(),
                    normal_maps: Textures::default(),
                    occlusion: None,
                    displacement: None,
                    environment: None,
                    volume: None,
                })
            }
        }
    }

    /// The mesh as arrays.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Replaces the numbers of the vertices.
    pub fn set_scalars(&mut self, scalars: Vec<f32>) -> Result<(), SceneError> {
        let (found, expected) = (scalars.len(), self.mesh.positions.len());
        if found != expected {
            return Err(SceneError::ScalarCount { found, expected });
        }
        self.mesh.scalars = Some(scalars);
        Ok(())
    }

    /// Volume in and around the mesh.
    pub fn volume(&self) -> Option<&Volume> {
        self.volume.as_deref()
    }

    /// Replaces the volume. It is what the picture frames where there is no triangle.
    pub fn set_volume(&mut self, volume: Option<Arc<Volume>>) {
        if self.mesh.triangles.is_empty() {
            (self.bounds, self.low) =
                volume.as_ref().map_or_else(<_>::default, |volume| (volume.bounds(), volume.corners()[0]));
        }
        self.volume = volume;
    }

    /// Picture of the ambient occlusion.
    pub(crate) fn occlusion_map(&self) -> Option<&Texture> {
        match &self.occlusion {
            Some(Occlusion::Picture(texture)) => Some(texture),
            _ => None,
        }
    }

    /// Fraction of the ambient light that reaches a vertex, where no picture says it.
    pub(crate) fn open_at_vertex(&self, vertex: u32) -> f32 {
        match &self.occlusion {
            Some(Occlusion::Vertices(open)) => open.get(vertex as usize).copied().unwrap_or(1.0),
            _ => 1.0,
        }
    }

    /// A sphere about all triangles (about the middle of their box; not the smallest one), or about the volume of a scene without any.
    pub fn bounds(&self) -> Sphere {
        self.bounds
    }

    /// A sphere about the surface whose vertices have moved by at most `reach` model units, with the same centre.
    pub(crate) fn displaced_bounds(&self, reach: f32) -> Sphere {
        Sphere { radius: self.bounds.radius + reach, ..self.bounds }
    }

    /// Least coordinate of the triangles along an axis of the coordinate system.
    pub(crate) fn lowest(&self, up: Vec3) -> f32 {
        self.low.dot(up)
    }
}

/// A sphere about all triangles, and their least coordinates. Vertices without a face are not drawn and do not count.
fn bounds(mesh: &Mesh) -> (Sphere, Vec3) {
    let drawn = || mesh.triangles.iter().flat_map(|t| t.positions).map(|i| mesh.positions[i as usize]);
    let Some(first) = drawn().next() else { return <_>::default() };
    let (low, high) = drawn().fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
    let centre = 0.5 * (low + high);
    let radius = drawn().map(|p| p.distance(centre)).fold(0.0, f32::max);
    (Sphere { centre, radius }, low)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::splat(1e6)],
            normals: vec![Vec3::Z],
            triangles: vec![Triangle { positions: [0, 1, 2], ..Triangle::default() }],
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
