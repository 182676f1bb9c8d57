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

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::union_find::UnionFind;
use rayon::prelude::*;

/// Connectivity of polygons over vertices.
///
/// Invariant: no face names a vertex twice in a row, and each has at least three corners.
#[derive(Clone, Debug)]
pub struct Topology {
    vertex_count: usize,
    faces: Ragged<Index>,
    corner_face: Vec<Index>,
    vertex_corners: Ragged<Index>,
    edges: Vec<[Index; 2]>,
    edge_corners: Ragged<Index>,
    rings: Ragged<Index>,
    boundary: Vec<bool>,
}

/// Kind of an edge by the faces that use it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// The edge has one face.
    Boundary,
    /// The edge has two faces with consistent orientation: they run along it in opposite directions.
    Interior,
    /// The edge has two faces that run along it in the same direction: one of them is flipped.
    Misoriented,
    /// The edge has three or more faces.
    NonManifold,
}

impl Topology {
    /// Builds the connectivity of `faces` over `vertex_count` vertices.
    ///
    /// # Panics
    /// If a face breaks the invariant or names a vertex that does not exist; [`tidy`] makes faces that fit.
    pub fn new(vertex_count: usize, faces: Ragged<Index>) -> Self {
        for face in faces.iter() {
            let twice = (0..face.len()).any(|k| face[k] == face[(k + 1) % face.len()]);
            assert!(face.len() >= 3 && !twice, "face {face:?} is degenerate");
        }
        let corner_face = (0..faces.len() as Index).flat_map(|f| faces.range(f).map(move |_| f));
        let corner_face: Vec<Index> = corner_face.collect();
        let corners = 0..faces.items().len() as Index;
        let by_vertex = corners.map(|c| (faces.items()[c as usize], c));
        let (vertex_corners, (edges, edge_corners)) =
            rayon::join(|| Ragged::group(vertex_count, by_vertex), || find_edges(vertex_count, &faces));
        // Edges are sorted, so a vertex gets its lower neighbours in order, then its higher ones.
        let rings = Ragged::group(vertex_count, edges.iter().flat_map(|&[a, b]| [(b, a), (a, b)]));
        let mut boundary = vec![false; vertex_count];
        for (ends, corners) in edges.iter().zip(edge_corners.iter()) {
            if corners.len() == 1 {
                ends.iter().for_each(|&v| boundary[v as usize] = true);
            }
        }
        Self { vertex_count, faces, corner_face, vertex_corners, edges, edge_corners, rings, boundary }
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
        self.corner_face[corner as usize]
    }
    /// Next corner of the same face.
    pub fn next(&self, corner: Index) -> Index {
        let range = self.faces.range(self.face(corner));
        if corner as usize + 1 == range.end { range.start as Index } else { corner + 1 }
    }
    /// Previous corner of the same face.
    pub fn previous(&self, corner: Index) -> Index {
        let range = self.faces.range(self.face(corner));
        if corner as usize == range.start { range.end as Index - 1 } else { corner - 1 }
    }
    /// Corners of a vertex, ascending.
    pub fn corners(&self, vertex: Index) -> &[Index] {
        self.vertex_corners.get(vertex)
    }
    /// End points of each edge, the lower one first, in ascending order. #E×2
    pub fn edges(&self) -> &[[Index; 2]] {
        &self.edges
    }
    /// Corners that run along each edge. #E lists
    pub fn edge_corners(&self) -> &Ragged<Index> {
        &self.edge_corners
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
    /// Kind of an edge.
    pub fn edge_kind(&self, edge: Index) -> EdgeKind {
        match *self.edge_corners.get(edge) {
            [_] => EdgeKind::Boundary,
            [c, d] if self.vertex(c) != self.vertex(d) => EdgeKind::Interior,
            [_, _] => EdgeKind::Misoriented,
            _ => EdgeKind::NonManifold,
        }
    }
    /// Non-manifold vertices, ascending: their faces do not form one fan, as at a bow tie or at an end of a non-manifold edge.
    pub fn non_manifold_vertices(&self) -> Vec<Index> {
        let mut singular = vec![false; self.vertex_count];
        for (&[a, b], corners) in self.edges.iter().zip(self.edge_corners.iter()) {
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

/// Edges sorted by their end points, each with the corners that run along it, in the order of the faces.
fn find_edges(vertex_count: usize, faces: &Ragged<Index>) -> (Vec<[Index; 2]>, Ragged<Index>) {
    let halves = faces.iter().zip(0..).flat_map(|(face, f)| {
        let first = faces.range(f).start as Index;
        (0..face.len()).map(move |k| {
            let (a, b) = (face[k], face[(k + 1) % face.len()]);
            (a.min(b), (a.max(b), first + k as Index))
        })
    });
    let mut halves = Ragged::group(vertex_count, halves);
    halves.for_each_mut(<[_]>::sort_unstable);
    let (mut edges, mut edge_corners) = (Vec::new(), Ragged::default());
    for (low, halves) in (0..).zip(halves.iter()) {
        for same in halves.chunk_by(|x, y| x.0 == y.0) {
            edges.push([low, same[0].0]);
            edge_corners.push(same.iter().map(|half| half.1));
        }
    }
    (edges, edge_corners)
}

/// Faces that satisfy the invariant of [`Topology`], and the faces of the input that had to be left out.
#[derive(Clone, Debug, Default)]
pub struct TidyFaces {
    /// Vertices of each face. #F lists
    pub faces: Ragged<Index>,
    /// Corner of the input for each corner of `faces`.
    pub source_corners: Vec<Index>,
    /// Face of the input for each face. #F
    pub source_faces: Vec<Index>,
    /// Faces of the input with fewer than three different vertices in a row, which were left out.
    pub degenerate: Vec<Index>,
    /// Faces of the input with the same vertices as an earlier one, which were left out: a second layer would count twice in
    /// a normal, or cancel it if it is flipped.
    pub duplicate: Vec<Index>,
}

/// Drops repeated corners, collapsed faces, and second layers of faces.
pub fn tidy(vertex_count: usize, input: &Ragged<Index>) -> TidyFaces {
    let mut out = TidyFaces::default();
    let duplicate = duplicates(vertex_count, input);
    for f in 0..input.len() as Index {
        let first = input.range(f).start as Index;
        let face = input.get(f);
        if kept(face).count() < 3 || !has_three_vertices(face) {
            out.degenerate.push(f);
        } else if duplicate[f as usize] {
            out.duplicate.push(f);
        } else {
            out.faces.push(kept(face).map(|k| face[k]));
            out.source_corners.extend(kept(face).map(|k| first + k as Index));
            out.source_faces.push(f);
        }
    }
    out
}

/// Returns false for a face that goes to and fro between two vertices.
fn has_three_vertices(face: &[Index]) -> bool {
    let second = face.iter().find(|&&v| v != face[0]);
    second.is_some_and(|&second| face.iter().any(|&v| v != face[0] && v != second))
}

/// Corners of a face that do not repeat the previous one.
fn kept(face: &[Index]) -> impl Iterator<Item = usize> {
    (0..face.len()).filter(|&k| face[k] != face[(k + face.len() - 1) % face.len()])
}

/// Marks faces whose vertices are those of an earlier face.
fn duplicates(vertex_count: usize, faces: &Ragged<Index>) -> Vec<bool> {
    let lowest = |f: Index| faces.get(f).iter().copied().min().unwrap_or(0);
    let by_lowest = Ragged::group(vertex_count, (0..faces.len() as Index).map(|f| (lowest(f), f)));
    // A sum over the vertices tells almost all faces apart without sorting any.
    let mixed = |&v: &Index| u64::from(v).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let vertices = |f: Index| kept(faces.get(f)).map(move |k| faces.get(f)[k]);
    let sum = |f: Index| vertices(f).fold(0u64, |sum, v| sum.wrapping_add(mixed(&v)));
    let sorted = |f: Index| {
        let mut sorted: Vec<_> = vertices(f).collect();
        sorted.sort_unstable();
        sorted
    };
    let mut duplicate = vec![false; faces.len()];
    let mut keyed = Vec::new();
    for bucket in by_lowest.iter().filter(|bucket| bucket.len() > 1) {
        keyed.clear();
        keyed.extend(bucket.iter().map(|&f| (sum(f), f)));
        keyed.sort_unstable();
        for alike in keyed.chunk_by(|a, b| a.0 == b.0).filter(|alike| alike.len() > 1) {
            for (k, &(_, f)) in alike.iter().enumerate() {
                duplicate[f as usize] = alike[..k].iter().any(|e| sorted(e.1) == sorted(f));
            }
        }
    }
    duplicate
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

    #[test]
    fn tidying_keeps_what_can_be_kept() {
        let input: Ragged<Index> =
            [vec![0, 1, 2, 2], vec![3, 3, 4], vec![2, 0, 1], vec![0, 2, 1], vec![1, 3, 2], vec![0, 1, 0, 1]]
                .into_iter()
                .collect();
        let tidy = tidy(5, &input);
        assert_eq!(tidy.faces.iter().collect::<Vec<_>>(), [&[0, 1, 2][..], &[1, 3, 2]]);
        assert_eq!(tidy.degenerate, [1, 5]);
        assert_eq!(tidy.duplicate, [2, 3]);
        assert_eq!(tidy.source_faces, [0, 4]);
        assert_eq!(tidy.source_corners, [0, 1, 2, 13, 14, 15]);
    }
}
