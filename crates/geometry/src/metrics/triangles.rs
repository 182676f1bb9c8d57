//! Meshes as they are compared: triangles, what is needed of each, and their edges.

use super::CompareError;
use super::distance::{Distances, TriangleTree};
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::polygon;
use crate::source::MeshData;
use glam::DVec3;
use std::sync::OnceLock;

/// Triangles in space, exactly as a source has them: nothing is welded or left out.
#[derive(Clone, Debug)]
pub struct Triangles {
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: Vec<[Index; 3]>,
    /// The faces of the source where not all are triangles: noise may make a polygon fall into other triangles.
    polygons: Option<Ragged<Index>>,
    /// Made when distances to this mesh are first asked for: whoever compares many meshes with it pays once.
    tree: OnceLock<TriangleTree>,
}

impl From<&MeshData> for Triangles {
    fn from(mesh: &MeshData) -> Self {
        let mut triangles = Vec::new();
        let mut points = Vec::new();
        for face in mesh.faces().iter() {
            points.clear();
            points.extend(face.iter().map(|c| mesh.positions()[c.position as usize]));
            polygon::triangulate(&points, |t| triangles.push(t.map(|k| face[k].position)));
        }
        let polygons = mesh.faces().iter().any(|face| face.len() > 3).then(|| {
            let mut polygons = Ragged::default();
            mesh.faces().iter().for_each(|face| polygons.push(face.iter().map(|corner| corner.position)));
            polygons
        });
        Self { positions: mesh.positions().to_vec(), triangles, polygons, tree: OnceLock::new() }
    }
}

impl Triangles {
    #[cfg(test)]
    pub(super) fn of(surface: &crate::mesh::surface::Surface) -> Self {
        let (positions, triangles) = (surface.positions().to_vec(), surface.triangles().collect());
        Self { positions, triangles, polygons: None, tree: OnceLock::new() }
    }
    /// #V×3, model units.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }
    /// Three indices of vertices each.
    pub fn triangles(&self) -> &[[Index; 3]] {
        &self.triangles
    }
    /// The same triangles with their vertices elsewhere.
    ///
    /// # Panics
    /// If there are more or fewer positions than vertices.
    pub fn at(&self, positions: Vec<DVec3>) -> Self {
        assert_eq!(positions.len(), self.positions.len(), "one position for each vertex");
        let (triangles, polygons) = (self.triangles.clone(), self.polygons.clone());
        Self { positions, triangles, polygons, tree: OnceLock::new() }
    }

    /// Distance of each point (#P×3) to this mesh. #P, model units.
    pub(super) fn distances(&self, points: &[DVec3]) -> Distances {
        self.tree.get_or_init(|| TriangleTree::new(&self.positions, &self.triangles)).distances(points)
    }

    /// Whether another mesh joins the same vertices, in any order and from any first corner.
    pub(super) fn check_connectivity(&self, other: &Self) -> Result<(), CompareError> {
        let counts = |mesh: &Self| (mesh.positions.len(), mesh.triangles.len());
        if counts(self) != counts(other) {
            let ((clean_vertices, clean_faces), (vertices, faces)) = (counts(self), counts(other));
            return Err(CompareError::Counts { clean_vertices, clean_faces, vertices, faces });
        }
        let same_polygons = self.polygons.is_some() && self.polygons == other.polygons;
        if same_polygons || self.triangles == other.triangles {
            return Ok(());
        }
        let canonical = |mesh: &Self| {
            let lowest_first =
                |[a, b, c]: [Index; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or([a, b, c]);
            let mut all: Vec<_> = mesh.triangles.iter().enumerate().map(|(i, t)| (lowest_first(*t), i)).collect();
            all.sort_unstable();
            all
        };
        let (ours, theirs) = (canonical(self), canonical(other));
        let different = ours.iter().zip(&theirs).find(|(a, b)| a.0 != b.0);
        different.map_or(Ok(()), |(_, b)| Err(CompareError::Connectivity(b.1)))
    }
}

/// What is needed of each triangle.
pub(super) struct Shapes {
    /// Unit; zero where there is none.
    pub(super) normals: Vec<DVec3>,
    pub(super) areas: Vec<f64>,
    smallest_angles: Vec<f64>,
}

impl Shapes {
    pub(super) fn of(positions: &[DVec3], faces: &[[Index; 3]]) -> Self {
        let corners = || faces.iter().map(|t| t.map(|v| positions[v as usize]));
        let vectors: Vec<DVec3> = corners().map(|[a, b, c]| (b - a).cross(c - a)).collect();
        let angle = |a: DVec3, b: DVec3, c: DVec3| degrees(b - a, c - a);
        Self {
            normals: vectors
                .iter()
                .map(|n| *n / n.length())
                .map(|n| if n.is_finite() { n } else { DVec3::ZERO })
                .collect(),
            areas: vectors.iter().map(|n| n.length() / 2.0).collect(),
            smallest_angles: corners()
                .map(|[a, b, c]| angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b)))
                .collect(),
        }
    }
    /// Degrees from the clean normal of each face to its normal here; without one it counts as 90° off.
    pub(super) fn angles_from(&self, clean: &Self) -> Vec<f64> {
        let angle = |f: usize| if self.areas[f] > 0.0 { degrees(clean.normals[f], self.normals[f]) } else { 90.0 };
        (0..self.areas.len()).map(angle).collect()
    }
    pub(super) fn is_sliver(&self, face: usize, mean_clean_area: f64) -> bool {
        self.areas[face] < 1e-6 * mean_clean_area || self.smallest_angles[face] < 0.5
    }
    /// Whether two faces lie on each other, or nearly: more than 150° between their normals.
    pub(super) fn is_fold(&self, [f, g]: [usize; 2]) -> bool {
        self.normals[f].dot(self.normals[g]).clamp(-1.0, 1.0).acos().to_degrees() > 150.0
    }
}

/// Angle between two vectors, accurate for small ones, degrees.
fn degrees(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// Edges of a list of triangles.
pub(super) struct Edges {
    pub(super) ends: Vec<[Index; 2]>,
    /// The two triangles of each edge that has two.
    pub(super) pairs: Vec<[usize; 2]>,
    pub(super) closed: bool,
}

impl Edges {
    pub(super) fn of(faces: &[[Index; 3]]) -> Self {
        let sides =
            |(f, &[a, b, c]): (usize, &[Index; 3])| [(a, b), (b, c), (c, a)].map(|(i, j)| ([i.min(j), i.max(j)], f));
        let mut halves: Vec<_> = faces.iter().enumerate().flat_map(sides).collect();
        halves.sort_unstable();
        let mut out = Self { ends: Vec::new(), pairs: Vec::new(), closed: true };
        for same in halves.chunk_by(|a, b| a.0 == b.0) {
            out.ends.push(same[0].0);
            match same {
                [a, b] => out.pairs.push([a.1, b.1]),
                _ => out.closed = false,
            }
        }
        out
    }
    /// Mean length, model units.
    pub(super) fn mean(&self, positions: &[DVec3]) -> f64 {
        let lengths = self.ends.iter().map(|[a, b]| positions[*a as usize].distance(positions[*b as usize]));
        lengths.sum::<f64>() / self.ends.len() as f64
    }
}
