//! Normals, areas and centroids of triangles, and a filter of the normals.

use super::triangle_mesh::TriangleMesh;
use crate::mesh::jagged::{Index, Ragged};
use glam::DVec3;
use rayon::prelude::*;

/// Normal, area and centroid of each triangle of a mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct FaceGeometry {
    /// Unit normal of each triangle; zero for a triangle without area. #T×3
    pub(super) normals: Vec<DVec3>,
    /// Area of each triangle, square model units. #T
    pub(super) areas: Vec<f64>,
    /// Centroid of each triangle. #T×3, model units
    pub(super) centroids: Vec<DVec3>,
}

/// Smallest number of triangles that a thread treats at a time.
const CHUNK: usize = 2048;

impl FaceGeometry {
    pub(super) fn of(mesh: &TriangleMesh, positions: &[DVec3]) -> Self {
        let count = mesh.face_count();
        let [normals, centroids] = [vec![DVec3::ZERO; count], vec![DVec3::ZERO; count]];
        let mut geometry = Self { normals, areas: vec![0.0; count], centroids };
        geometry.update(mesh, positions);
        geometry
    }

    /// Computes everything anew for other positions (#V×3) of the same mesh, without allocating.
    pub(super) fn update(&mut self, mesh: &TriangleMesh, positions: &[DVec3]) {
        let slots = self.normals.par_iter_mut().zip(&mut self.areas).zip(&mut self.centroids);
        slots.zip(&mesh.triangles).with_min_len(CHUNK).for_each(|(((normal, area), centroid), t)| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let doubled = (b - a).cross(c - a);
            *normal = doubled.normalize_or_zero();
            *area = doubled.length() / 2.0;
            *centroid = (a + b + c) / 3.0;
        });
    }

    /// Mean distance between the centroids of triangles that share an edge, model units; the square root of the mean area if
    /// that distance is zero or there are no such triangles.
    pub(super) fn mean_centroid_distance(&self, mesh: &TriangleMesh) -> f64 {
        let distance = |&[f, g]: &[Index; 2]| self.centroids[f as usize].distance(self.centroids[g as usize]);
        let mean = mesh.edge_faces.iter().map(distance).sum::<f64>() / mesh.edge_faces.len() as f64;
        if mean > 0.0 {
            return mean;
        }
        let mean_area = self.areas.iter().sum::<f64>() / self.areas.len() as f64;
        if mean_area > 0.0 { mean_area.sqrt() } else { 1.0 }
    }

    /// Mean absolute dihedral angle (between the normals of triangles that share an edge), radians; 0 without any.
    pub(super) fn mean_dihedral_angle(&self, mesh: &TriangleMesh) -> f64 {
        let angle = |&[f, g]: &[Index; 2]| {
            let [a, b] = [f, g].map(|f| self.normals[f as usize]);
            a.cross(b).length().atan2(a.dot(b))
        };
        mesh.edge_faces.iter().map(angle).sum::<f64>() / mesh.edge_faces.len().max(1) as f64
    }
}

/// Replaces each normal by the weighted mean of its neighbours' as a unit vector, or keeps it where that mean is zero.
/// `weight(f, k, g)` is the weight of neighbour g, item k of all lists, for face f. The result goes to `filtered`. #T×3
pub(super) fn filter_normals(
    neighbours: &Ragged<Index>,
    normals: &[DVec3],
    filtered: &mut [DVec3],
    weight: impl Fn(usize, usize, usize) -> f64 + Sync,
) {
    filtered.par_iter_mut().enumerate().with_min_len(CHUNK / 4).for_each(|(f, out)| {
        let sum = neighbours.range(f as Index).fold(DVec3::ZERO, |sum, k| {
            let g = neighbours.items()[k] as usize;
            sum + normals[g] * weight(f, k, g)
        });
        *out = sum.try_normalize().unwrap_or(normals[f]);
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::surface::Surface;
    use crate::mesh::topology::Topology;

    /// Mean distance between the centroids of triangles with these corners, three for each.
    fn distance(corners: &[DVec3], triangles: &[[Index; 3]]) -> f64 {
        let faces = triangles.iter().map(|t| t.to_vec()).collect();
        let surface = Surface::new(Topology::new(corners.len(), faces), corners.to_vec());
        let mesh = TriangleMesh::of(&surface);
        FaceGeometry::of(&mesh, surface.positions()).mean_centroid_distance(&mesh)
    }

    #[test]
    fn a_mesh_without_neighbours_or_without_area_has_a_length_all_the_same() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        // The centroids are at (2/3, 1/3) and (1/3, 2/3).
        assert!((distance(&square, &[[0, 1, 2], [0, 2, 3]]) - 2f64.sqrt() / 3.0).abs() < 1e-12);
        // One triangle has no neighbour: the root of its area.
        assert_eq!(distance(&square, &[[0, 1, 2]]), 0.5f64.sqrt());
        // Neighbours at one place: the root of the mean area, if there is any.
        assert_eq!(distance(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Y], &[[0, 1, 2], [1, 0, 3]]), 0.5f64.sqrt());
        assert_eq!(distance(&[DVec3::ONE; 4], &[[0, 1, 2], [0, 2, 3]]), 1.0);
    }
}
