//! Triangle meshes for comparisons: positions, triangles, geometry of the triangles, and edges.

use super::CompareError;
use super::distance::Distances;
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::polygon;
use crate::mesh::triangle_tree::TriangleTree;
use crate::source::MeshData;
use glam::DVec3;
use std::sync::OnceLock;

/// Triangle mesh exactly as a source has it: nothing is welded or left out.
#[derive(Clone, Debug)]
pub struct Triangles {
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: Vec<[Index; 3]>,
    /// Vertices of the faces of the source; `None` if all are triangles. Polygons are compared as they are, because noise may
    /// change how they are cut into triangles.
    polygons: Option<Ragged<Index>>,
    /// Search tree, which is built when it is first needed, so that a mesh that many are compared with has it built once.
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
    /// Positions of the vertices. #V×3, model units
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }
    /// Vertices of each triangle. #T×3
    pub fn triangles(&self) -> &[[Index; 3]] {
        &self.triangles
    }
    /// Returns the mesh with other positions (#V×3, model units).
    ///
    /// # Panics
    /// If there is not one position for each vertex.
    pub fn at(&self, positions: Vec<DVec3>) -> Self {
        assert_eq!(positions.len(), self.positions.len(), "one position for each vertex");
        let (triangles, polygons) = (self.triangles.clone(), self.polygons.clone());
        Self { positions, triangles, polygons, tree: OnceLock::new() }
    }

    /// Distance of each point (#P×3) to the mesh. #P, model units
    pub(super) fn distances(&self, points: &[DVec3]) -> Distances {
        let tree = || TriangleTree::new(&self.positions, self.triangles.iter().copied());
        Distances(self.tree.get_or_init(tree).distances(points))
    }

    /// Returns an error unless the triangles of another mesh join the same vertices, in any order and from any first corner.
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

/// Geometry of each triangle.
pub(super) struct FaceGeometry {
    /// Unit normals; zero at triangles without one. #T×3
    pub(super) normals: Vec<DVec3>,
    /// Areas, square model units. #T
    pub(super) areas: Vec<f64>,
    /// Smallest angle of each triangle, degrees. #T
    smallest_angles: Vec<f64>,
}

impl FaceGeometry {
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
    /// Angle between the clean normal of each triangle and its normal here, degrees; 90 if it has no normal here. #T
    pub(super) fn angles_from(&self, clean: &Self) -> Vec<f64> {
        let angle = |f: usize| if self.areas[f] > 0.0 { degrees(clean.normals[f], self.normals[f]) } else { 90.0 };
        (0..self.areas.len()).map(angle).collect()
    }
    /// Returns true if a triangle has an area below 1e-6 of the mean, or an angle below half a degree.
    pub(super) fn is_sliver(&self, face: usize, mean_clean_area: f64) -> bool {
        self.areas[face] < 1e-6 * mean_clean_area || self.smallest_angles[face] < 0.5
    }
    /// Returns true if two triangles are folded onto each other: more than 150° between their normals.
    pub(super) fn is_fold(&self, [f, g]: [usize; 2]) -> bool {
        self.normals[f].dot(self.normals[g]).clamp(-1.0, 1.0).acos().to_degrees() > 150.0
    }
}

/// Angle between two vectors, degrees; accurate for small angles.
fn degrees(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// Edges of a list of triangles.
pub(super) struct Edges {
    /// End points of each edge, the lower one first, in ascending order. #E×2
    pub(super) ends: Vec<[Index; 2]>,
    /// Both triangles of each edge that has two.
    pub(super) pairs: Vec<[usize; 2]>,
    /// True if each edge has two triangles.
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
    /// Mean length of the edges, model units.
    pub(super) fn mean(&self, positions: &[DVec3]) -> f64 {
        let lengths = self.ends.iter().map(|[a, b]| positions[*a as usize].distance(positions[*b as usize]));
        lengths.sum::<f64>() / self.ends.len() as f64
    }
}
