//! Connectivity of a triangle mesh as the estimates of noise and surface need it.

use super::bilaplacian::Umbrella;
use super::triangle_mesh::TriangleMesh;
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use glam::DVec3;
use rayon::prelude::*;

/// Faces, half-edges, corners and the umbrella operator of a surface.
pub(super) struct Connectivity {
    pub(super) mesh: TriangleMesh,
    pub(super) umbrella: Umbrella,
    /// Half-edges of each face whose edge has two faces: index of the edge in [`TriangleMesh::edge_faces`], and the other face.
    pub(super) half_edges: Ragged<(Index, Index)>,
    /// Corners at each vertex: the triangle, and which of its three corners it is.
    pub(super) corners: Ragged<(Index, u8)>,
}

impl Connectivity {
    pub(super) fn of(surface: &Surface) -> Self {
        let mesh = TriangleMesh::of(surface);
        let both = (0..).zip(&mesh.edge_faces).flat_map(|(e, &[f, g])| [(f, (e, g)), (g, (e, f))]);
        let half_edges = Ragged::group(mesh.face_count(), both);
        let all = (0..).zip(&mesh.triangles).flat_map(|(f, t)| (0..3u8).map(move |k| (t[usize::from(k)], (f, k))));
        let corners = Ragged::group(surface.positions().len(), all);
        Self { mesh, umbrella: Umbrella::of(surface), half_edges, corners }
    }

    /// Faces that share an edge with `face`.
    pub(super) fn edge_neighbours(&self, face: usize) -> impl Iterator<Item = usize> + '_ {
        self.half_edges.get(face as Index).iter().map(|half_edge| half_edge.1 as usize)
    }

    /// Area-weighted unit normals of the vertices; zero where a vertex has no area around it. #V×3
    pub(super) fn vertex_normals(&self, positions: &[DVec3]) -> Vec<DVec3> {
        let doubled: Vec<DVec3> = self.mesh.triangles.par_iter().map(|t| doubled_area(t, positions)).collect();
        let sum = |v: usize| self.mesh.vertex_faces.get(v as Index).iter().map(|&f| doubled[f as usize]).sum::<DVec3>();
        (0..positions.len()).into_par_iter().with_min_len(1024).map(|v| sum(v).normalize_or_zero()).collect()
    }
}

/// Twice the area of a triangle, along its normal.
pub(super) fn doubled_area(triangle: &[Index; 3], positions: &[DVec3]) -> DVec3 {
    let [a, b, c] = triangle.map(|v| positions[v as usize]);
    (b - a).cross(c - a)
}
