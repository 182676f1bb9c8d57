//! Connectivity of polygon meshes: which vertices, edges and faces are adjacent. It knows indices only, never a position.
//!
//! A corner is an index in the list of all face corners; it stands for its vertex and for the edge to the next corner of
//! its face (a half-edge). Nothing is refused: non-manifold edges and vertices are listed and left to the caller.
//!
//! ```
//! use planish_geometry::mesh::topology::{EdgeKind, Topology};
//!
//! // A square and a triangle at its edge 1–2.
//! let topology = Topology::new(5, [vec![0, 1, 2, 3], vec![2, 1, 4]].into_iter().collect());
//! assert_eq!(topology.rings().get(1), [0, 2, 4]);
//! let kinds = (0..).zip(topology.edges()).map(|(e, ends)| (*ends, topology.edge_kind(e)));
//! let inside: Vec<[u32; 2]> = kinds.filter(|(_, kind)| *kind == EdgeKind::Interior).map(|(ends, _)| ends).collect();
//! assert_eq!(inside, [[1, 2]]);
//! ```

mod corner_faces;
mod edges;
mod tidy_faces;

pub use edges::EdgeKind;
pub use tidy_faces::{TidyFaces, tidy};

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::union_find::UnionFind;
use corner_faces::CornerFaces;
use edges::Edges;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::OnceLock;
use tidy_faces::kept;

/// Connectivity of polygons over vertices.
///
/// Invariant: no face names a vertex twice in a row, and each has at least three corners.
#[derive(Clone, Debug)]
pub struct Topology {
    vertex_count: usize,
    faces: Ragged<Index>,
    corner_faces: CornerFaces,
    vertex_corners: Ragged<Index>,
    rings: Ragged<Index>,
    boundary: Vec<bool>,
    misoriented: usize,
    /// Edges, from the first use on: much of what is done to a mesh needs the rings alone.
    edges: OnceLock<Edges>,
}

/// Number of vertices of a task.
const CHUNK: usize = 8192;

impl Topology {
    /// Builds the connectivity of `faces` over `vertex_count` vertices.
    ///
    /// # Panics
    /// If a face breaks the invariant or names a vertex that does not exist; [`tidy`] makes faces that fit.
    pub fn new(vertex_count: usize, faces: Ragged<Index>) -> Self {
        let vertex_corners = Ragged::by_key(vertex_count, faces.items());
        Self::with_corners(vertex_count, faces, vertex_corners)
    }

    /// Builds the connectivity of `faces`, whose corners are known for each vertex.
    fn with_corners(vertex_count: usize, faces: Ragged<Index>, vertex_corners: Ragged<Index>) -> Self {
        let is_degenerate = |face: &[Index]| face.len() < 3 || kept(face).count() < face.len();
        let all = (0..faces.len() as Index).into_par_iter();
        if let Some(f) = all.find_any(|f| is_degenerate(faces.get(*f))) {
            panic!("face {:?} is degenerate", faces.get(f));
        }
        let mut topology = Self {
            vertex_count,
            corner_faces: CornerFaces::of(&faces),
            faces,
            vertex_corners,
            rings: Ragged::default(),
            boundary: Vec::with_capacity(vertex_count),
            misoriented: 0,
            edges: OnceLock::new(),
        };
        for (rings, boundary, misoriented) in topology.in_chunks(|vertices| topology.neighbours(vertices)) {
            topology.rings.append(&rings);
            topology.boundary.extend(boundary);
            topology.misoriented += misoriented;
        }
        topology
    }

    /// Results for all vertices in their order, chunk by chunk.
    fn in_chunks<T: Send>(&self, work: impl Fn(Range<Index>) -> T + Sync) -> Vec<T> {
        let chunks = (0..self.vertex_count.div_ceil(CHUNK)).into_par_iter();
        let vertices = |chunk: usize| (chunk * CHUNK) as Index..((chunk + 1) * CHUNK).min(self.vertex_count) as Index;
        chunks.map(|chunk| work(vertices(chunk))).collect()
    }

    /// Neighbours of each vertex, whether it is at the boundary, and the number of misoriented edges to higher neighbours.
    fn neighbours(&self, vertices: Range<Index>) -> (Ragged<Index>, Vec<bool>, usize) {
        let (mut rings, mut boundary, mut misoriented) = (Ragged::default(), Vec::with_capacity(CHUNK), 0);
        let [mut to, mut from] = [(); 2].map(|()| Vec::new());
        for v in vertices {
            // Edges that corners of this vertex run along, and those along which others run to it.
            to.clear();
            from.clear();
            for &corner in self.corners(v) {
                to.push(self.vertex(self.next(corner)));
                from.push(self.vertex(self.previous(corner)));
            }
            to.sort_unstable();
            from.sort_unstable();
            let mut is_boundary = false;
            if to == from && to.windows(2).all(|w| w[0] < w[1]) {
                to.iter().for_each(|&n| rings.extend_open(n));
            } else {
                let (mut to, mut from) = (&to[..], &from[..]);
                while let Some(&n) = to.first().into_iter().chain(from.first()).min() {
                    let counts = [&mut to, &mut from].map(|ends| {
                        let count = ends.iter().take_while(|&&end| end == n).count();
                        *ends = &ends[count..];
                        count
                    });
                    rings.extend_open(n);
                    match counts {
                        [1, 0] | [0, 1] => is_boundary = true,
                        [2, 0] | [0, 2] if v < n => misoriented += 1,
                        _ => {}
                    }
                }
            }
            rings.close();
            boundary.push(is_boundary);
        }
        (rings, boundary, misoriented)
    }

    /// Number of vertices, isolated ones included.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }
    /// Vertices of each face, counter-clockwise seen from outside. #F lists
    pub fn faces(&self) -> &Ragged<Index> {
        &self.faces
    }
    /// Vertex of a corner.
    pub fn vertex(&self, corner: Index) -> Index {
        self.faces.items()[corner as usize]
    }
    /// Face of a corner.
    pub fn face(&self, corner: Index) -> Index {
        self.corner_faces.get(corner)
    }
    /// Next corner of the same face.
    pub fn next(&self, corner: Index) -> Index {
        if self.is_triangular() {
            return if corner % 3 == 2 { corner - 2 } else { corner + 1 };
        }
        let range = self.faces.range(self.face(corner));
        if corner as usize + 1 == range.end { range.start as Index } else { corner + 1 }
    }
    /// Previous corner of the same face.
    pub fn previous(&self, corner: Index) -> Index {
        if self.is_triangular() {
            return if corner.is_multiple_of(3) { corner + 2 } else { corner - 1 };
        }
        let range = self.faces.range(self.face(corner));
        if corner as usize == range.start { range.end as Index - 1 } else { corner - 1 }
    }
    /// Returns true if all faces are triangles, so that corner c belongs to face c / 3.
    pub fn is_triangular(&self) -> bool {
        matches!(self.corner_faces, CornerFaces::Triangles)
    }
    /// Corners of a vertex, ascending.
    pub fn corners(&self, vertex: Index) -> &[Index] {
        self.vertex_corners.get(vertex)
    }
    /// Vertices that share an edge with each vertex (its one-ring), ascending. #V lists
    pub fn rings(&self) -> &Ragged<Index> {
        &self.rings
    }
    /// Returns true if a vertex lies on an edge with only one face.
    pub fn is_boundary(&self, vertex: Index) -> bool {
        self.boundary[vertex as usize]
    }
    /// Returns true if no face names the vertex.
    pub fn is_isolated(&self, vertex: Index) -> bool {
        self.corners(vertex).is_empty()
    }
    /// Non-manifold vertices, ascending: their faces do not form one fan, as at a bow tie or at an end of a non-manifold edge.
    pub fn non_manifold_vertices(&self) -> Vec<Index> {
        let mut singular = vec![false; self.vertex_count];
        for (&[a, b], corners) in self.edges().iter().zip(self.edge_corners().iter()) {
            if corners.len() > 2 {
                singular[a as usize] = true;
                singular[b as usize] = true;
            }
        }
        let vertices = (0..self.vertex_count as Index).into_par_iter();
        vertices.filter(|&v| singular[v as usize] || self.fans(v) > 1).collect()
    }

    /// Number of fans that the faces at a vertex form when they are joined along its edges.
    fn fans(&self, vertex: Index) -> usize {
        let ring = self.rings.get(vertex);
        let mut sheets = UnionFind::new(ring.len());
        // Both vertices are neighbours, so both are found in the ring.
        let index_in_ring = |corner| ring.partition_point(|&n| n < self.vertex(corner)) as Index;
        let joined = self
            .corners(vertex)
            .iter()
            .filter(|&&c| sheets.join(index_in_ring(self.next(c)), index_in_ring(self.previous(c))));
        ring.len() - joined.count()
    }
    /// Connected component of each vertex, and the number of components; an isolated vertex is a component of its own.
    pub fn components(&self) -> (Vec<Index>, usize) {
        let mut component = vec![Index::MAX; self.vertex_count];
        let mut count = 0;
        let mut stack = Vec::new();
        for seed in 0..self.vertex_count as Index {
            if component[seed as usize] != Index::MAX {
                continue;
            }
            component[seed as usize] = count;
            stack.push(seed);
            while let Some(v) = stack.pop() {
                for &n in self.rings.get(v) {
                    if component[n as usize] == Index::MAX {
                        component[n as usize] = count;
                        stack.push(n);
                    }
                }
            }
            count += 1;
        }
        (component, count as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topology(vertices: usize, faces: &[&[Index]]) -> Topology {
        Topology::new(vertices, faces.iter().map(|f| f.to_vec()).collect())
    }

    #[test]
    fn two_triangles_share_an_edge() {
        let t = topology(5, &[&[0, 1, 2], &[2, 1, 3]]);
        assert_eq!(t.edges(), [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]);
        assert_eq!(t.rings().get(1), [0, 2, 3]);
        assert_eq!(t.edge_kind(2), EdgeKind::Interior);
        assert!((0..4).all(|v| t.is_boundary(v)) && !t.is_boundary(4) && t.is_isolated(4));
        assert!(t.non_manifold_vertices().is_empty());
        assert_eq!(t.components().1, 2);
        assert_eq!((t.next(5), t.previous(3), t.face(4)), (3, 5, 1));
    }

    #[test]
    fn a_diagonal_of_a_quad_is_no_edge() {
        let t = topology(4, &[&[0, 1, 2, 3]]);
        assert_eq!(t.edges(), [[0, 1], [0, 3], [1, 2], [2, 3]]);
    }

    #[test]
    fn a_bow_tie_is_found() {
        let t = topology(5, &[&[0, 1, 2], &[0, 3, 4]]);
        assert_eq!(t.non_manifold_vertices(), [0]);
    }

    #[test]
    fn three_sheets_and_a_flipped_face_are_told_apart() {
        let t = topology(6, &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]]);
        assert_eq!(t.edge_kind(0), EdgeKind::NonManifold);
        assert_eq!(t.non_manifold_vertices(), [0, 1]);
        let t = topology(4, &[&[0, 1, 2], &[0, 1, 3]]);
        assert_eq!(t.edge_kind(0), EdgeKind::Misoriented);
    }
}
