//! Face normals, vertex normals, and heights along vertex normals.
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::mesh::{normals::{self, FaceWeight}, shapes};
//!
//! let normals = normals::vertex_normals(&shapes::cube(), FaceWeight::Angle);
//! assert!(normals[7].distance(DVec3::ONE.normalize()) < 1e-12);
//! // A vertex that lies a tenth below its denoised position has the height −0.1.
//! let heights = normals::heights(&[normals[7] * -0.1], &[normals[7].as_vec3()]);
//! assert!((heights[0] + 0.1).abs() < 1e-7);
//! ```

use crate::mesh::jagged::Index;
use crate::mesh::surface::Surface;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Weights of the face normals in a vertex normal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FaceWeight {
    /// Each face counts once (Gouraud 1971).
    Uniform,
    /// Each face counts by its area.
    Area,
    /// Each face counts by its angle at the vertex (Thürmer & Wüthrich 1998). The result does not depend on how a plane is cut
    /// into faces, and Blender displaces along these normals.
    #[default]
    Angle,
}

/// Unit normal of each face; zero where a face has no area. #F×3
pub fn face_normals(surface: &Surface) -> Vec<DVec3> {
    surface.face_vectors().into_iter().map(DVec3::normalize_or_zero).collect()
}

/// Unit normal of each vertex; zero where it has no faces or their normals cancel. #V×3
pub fn vertex_normals(surface: &Surface, weight: FaceWeight) -> Vec<DVec3> {
    let topology = surface.topology();
    let vectors = surface.face_vectors();
    let weighted = |corner: Index| {
        let vector = vectors[topology.face(corner) as usize];
        match weight {
            FaceWeight::Uniform => vector.normalize_or_zero(),
            FaceWeight::Area => vector,
            FaceWeight::Angle => vector.normalize_or_zero() * corner_angle(surface, corner),
        }
    };
    let vertices = (0..topology.vertex_count() as Index).into_par_iter();
    let sum = |v: Index| topology.corners(v).iter().map(|&c| weighted(c)).sum::<DVec3>();
    vertices.map(|v| sum(v).normalize_or_zero()).collect()
}

/// Angle between the two edges of a face at a corner, 0..=π; 0 where an edge has no length.
pub fn corner_angle(surface: &Surface, corner: Index) -> f64 {
    let topology = surface.topology();
    let p = surface.at_corner(corner);
    let a = surface.at_corner(topology.next(corner)) - p;
    let b = surface.at_corner(topology.previous(corner)) - p;
    a.cross(b).length().atan2(a.dot(b))
}

/// Heights hᵢ = ⟨δᵢ, nᵢ⟩ of displacements along vertex normals, model units, positive outwards; 0 without a normal. #V
///
/// The normals are those that the GPU has, in single precision: a height must belong to the very vector that it is applied
/// along.
pub fn heights(deltas: &[DVec3], normals: &[Vec3]) -> Vec<f64> {
    deltas.par_iter().zip(normals).map(|(delta, n)| delta.dot(n.as_dvec3())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn the_normal_of_a_cube_corner_is_along_its_diagonal_whatever_the_triangulation() {
        let cube = shapes::cube();
        let n = vertex_normals(&cube, FaceWeight::Angle);
        for (n, p) in n.iter().zip(cube.positions()) {
            assert!(n.distance((*p - 0.5).normalize()) < 1e-15, "{n} at {p}");
        }
    }

    #[test]
    fn sphere_normals_are_radial() {
        let sphere = shapes::sphere(4);
        for weight in [FaceWeight::Uniform, FaceWeight::Area, FaceWeight::Angle] {
            for (n, p) in vertex_normals(&sphere, weight).iter().zip(sphere.positions()) {
                // Triangles of different size side by side tilt the mean by a fraction of the edge length, 0.07.
                assert!(n.distance(*p) < 0.01, "{weight:?}: {n} at {p}");
            }
        }
    }

    #[test]
    fn heights_are_positive_where_the_noise_lifted() {
        let h = heights(&[DVec3::new(0.0, 2.0, 1.0)], &[Vec3::Z]);
        assert_eq!(h, [1.0]);
    }
}
