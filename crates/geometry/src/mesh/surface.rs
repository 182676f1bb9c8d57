//! Polygon meshes with positions.
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::mesh::{surface::Surface, topology::Topology};
//!
//! // The corner of a cube with edges of length 1.
//! let faces = [vec![0, 2, 1], vec![0, 1, 3], vec![0, 3, 2], vec![1, 2, 3]];
//! let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let corner = Surface::new(Topology::new(4, faces.into_iter().collect()), positions);
//! assert!((corner.volume() - 1.0 / 6.0).abs() < 1e-12);
//! assert!((corner.area() - (1.5 + 0.75f64.sqrt())).abs() < 1e-12);
//! ```

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::polygon;
use crate::mesh::topology::Topology;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::OnceLock;

/// A polygon mesh in space.
///
/// Invariant: there is one position for each vertex, and the corners of a triangle belong to one face.
#[derive(Clone, Debug)]
pub struct Surface {
    topology: Topology,
    positions: Vec<DVec3>,
    /// Triangles, from the first use on.
    triangles: OnceLock<Vec<[Index; 3]>>,
    /// Mean edge length, from the first use on.
    mean_edge: OnceLock<f64>,
}

impl Surface {
    /// Combines connectivity and positions (#V×3, model units), which decide how polygons are triangulated.
    ///
    /// # Panics
    /// If there is not one position for each vertex.
    pub fn new(topology: Topology, positions: Vec<DVec3>) -> Self {
        assert_eq!(positions.len(), topology.vertex_count(), "one position for each vertex");
        Self { topology, positions, triangles: OnceLock::new(), mean_edge: OnceLock::new() }
    }
    /// Returns the mesh with other positions (#V×3, model units); its triangulation stays.
    ///
    /// # Panics
    /// If there is not one position for each vertex.
    pub fn at(&self, positions: Vec<DVec3>) -> Self {
        assert_eq!(positions.len(), self.positions.len(), "one position for each vertex");
        if !self.topology.is_triangular() {
            self.triangle_corners();
        }
        let (topology, triangles) = (self.topology.clone(), self.triangles.clone());
        Self { topology, positions, triangles, mean_edge: OnceLock::new() }
    }
    /// Positions p − δ, where denoising with displacements δ (#V×3, model units) puts the vertices. #V×3, model units
    pub fn moved_by(&self, deltas: &[DVec3]) -> Vec<DVec3> {
        self.positions.par_iter().zip(deltas).map(|(p, delta)| *p - *delta).collect()
    }
    /// Connectivity of the mesh.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }
    /// Positions of the vertices. #V×3, model units
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }
    /// Position at a corner.
    pub fn at_corner(&self, corner: Index) -> DVec3 {
        self.positions[self.topology.vertex(corner) as usize]
    }
    /// Corners of each triangle, face after face. A corner names a vertex in [`Self::topology`] and a uv vertex in
    /// an [`Atlas`](crate::mesh::atlas::Atlas).
    pub fn triangle_corners(&self) -> &[[Index; 3]] {
        self.triangles.get_or_init(|| triangulate(self.topology.faces(), &self.positions))
    }
    /// Vertices of each triangle. #T×3
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [Index; 3]> + Clone + '_ {
        self.triangle_corners().iter().map(|t| t.map(|c| self.topology.vertex(c)))
    }
    /// Twice the area times the unit normal of each triangle. #T×3
    fn doubled_areas(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.triangles().map(|t| {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            (b - a).cross(c - a)
        })
    }
    /// Newell vector of each face: unit normal times twice the area. #F×3
    pub fn face_vectors(&self) -> Vec<DVec3> {
        let faces = (0..self.topology.faces().len() as Index).into_par_iter();
        let at = |v: &Index| self.positions[*v as usize];
        faces.map(|f| polygon::newell(self.topology.faces().get(f).iter().map(at))).collect()
    }
    /// Area of all triangles, square model units.
    pub fn area(&self) -> f64 {
        self.doubled_areas().map(DVec3::length).sum::<f64>() / 2.0
    }
    /// Mean of the positions of the vertices that faces use, model units; zero without any.
    pub fn centroid(&self) -> DVec3 {
        let (mut sum, mut count) = (DVec3::ZERO, 0usize);
        for (_, p) in self.used() {
            sum += *p;
            count += 1;
        }
        sum / count.max(1) as f64
    }
    /// Indices and positions of the vertices that faces use.
    fn used(&self) -> impl Iterator<Item = (Index, &DVec3)> {
        (0..).zip(&self.positions).filter(|(v, _)| !self.topology.is_isolated(*v))
    }
    /// Signed volume enclosed by the triangles, cubic model units; about the centroid of the surface, which
    /// matters for a surface with a boundary only.
    pub fn volume(&self) -> f64 {
        let centre = self.centroid();
        let six = self.triangles().map(|t| {
            let [a, b, c] = t.map(|v| self.positions[v as usize] - centre);
            a.dot(b.cross(c))
        });
        six.sum::<f64>() / 6.0
    }
    /// Mean length of the edges, model units; 0 without any.
    pub fn mean_edge(&self) -> f64 {
        if let Some(mean) = self.mean_edge.get() {
            return *mean;
        }
        // Not inside of the lock: a thread that waits for others takes up other work, which may ask for the length too.
        let mean = self.measured_mean_edge();
        *self.mean_edge.get_or_init(|| mean)
    }
    /// Mean length of the edges: that of lengths which are measured in parallel and added up in the order of the edges.
    fn measured_mean_edge(&self) -> f64 {
        const VERTICES: usize = 8192;
        const CHUNKS: usize = 16;
        let rings = self.topology.rings();
        let lengths = |vertices: &[DVec3], first: usize| -> Vec<f64> {
            let of_vertex = |(v, p): (usize, &DVec3)| {
                let higher = rings.get(v as Index).iter().filter(move |&&n| n as usize > v);
                let p = *p;
                higher.map(move |&n| p.distance(self.positions[n as usize]))
            };
            (first..).zip(vertices).flat_map(of_vertex).collect()
        };
        let (mut sum, mut count) = (-0.0, 0);
        for (round, vertices) in self.positions.chunks(VERTICES * CHUNKS).enumerate() {
            let first = |chunk: usize| round * VERTICES * CHUNKS + chunk * VERTICES;
            let chunks = vertices.par_chunks(VERTICES).enumerate();
            let chunks: Vec<_> = chunks.map(|(chunk, vertices)| lengths(vertices, first(chunk))).collect();
            for length in chunks.iter().flatten() {
                sum += length;
                count += 1;
            }
        }
        sum / count.max(1) as f64
    }
    /// Bounding box, lowest and highest corner, of the vertices that faces use.
    pub fn bounds(&self) -> [DVec3; 2] {
        self.used().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], (_, p)| [low.min(*p), high.max(*p)])
    }
}

fn triangulate(faces: &Ragged<Index>, positions: &[DVec3]) -> Vec<[Index; 3]> {
    let mut triangles = Vec::with_capacity(faces.items().len() - 2 * faces.len());
    let mut points = Vec::new();
    for f in 0..faces.len() as Index {
        let first = faces.range(f).start as Index;
        points.clear();
        points.extend(faces.get(f).iter().map(|&v| positions[v as usize]));
        polygon::triangulate(&points, |t| triangles.push(t.map(|k| first + k as Index)));
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use std::f64::consts::PI;

    #[test]
    fn a_fine_sphere_has_the_area_and_volume_of_one() {
        let sphere = shapes::sphere(5);
        // Chords of length e leave e²/8 to the radius: second order, e = 0.03.
        assert!((sphere.area() / (4.0 * PI) - 1.0).abs() < 1e-3, "{}", sphere.area());
        assert!((sphere.volume() / (4.0 / 3.0 * PI) - 1.0).abs() < 1e-3, "{}", sphere.volume());
    }

    #[test]
    fn vertices_that_no_face_uses_take_no_part() {
        let sphere = shapes::sphere(2);
        for far in [1e8, f64::from(f32::MAX), 1e308] {
            let mut positions = sphere.positions().to_vec();
            positions.extend([DVec3::splat(far), DVec3::splat(-far)]);
            let topology = Topology::new(positions.len(), sphere.topology().faces().clone());
            let strewn = Surface::new(topology, positions);
            assert_eq!((strewn.volume(), strewn.bounds()), (sphere.volume(), sphere.bounds()), "{far}");
        }
    }

    #[test]
    fn volume_does_not_depend_on_the_position() {
        let sphere = shapes::sphere(2);
        let moved = sphere.at(sphere.positions().iter().map(|p| *p + 1e6).collect());
        // Coordinates near 1e6 are good to 1e-10.
        assert!((sphere.volume() - moved.volume()).abs() < 1e-8);
    }
}
