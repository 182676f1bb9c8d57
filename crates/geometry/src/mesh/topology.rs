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
use std::ops::Range;
use std::sync::OnceLock;

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

/// Edges of a mesh in ascending order.
#[derive(Clone, Debug, Default)]
struct Edges {
    ends: Vec<[Index; 2]>,
    corners: Ragged<Index>,
}

/// Face of each corner.
#[derive(Clone, Debug)]
enum CornerFaces {
    /// All faces are triangles, so a corner says by itself which face it has.
    Triangles,
    Polygons(Vec<Index>),
}

impl CornerFaces {
    fn of<T: Sync>(faces: &Ragged<T>) -> Self {
        if faces.items().len() == 3 * faces.len() && faces.iter().all(|face| face.len() == 3) {
            return Self::Triangles;
        }
        let of_face = |f: Index| faces.range(f).map(move |_| f);
        Self::Polygons((0..faces.len() as Index).flat_map(of_face).collect())
    }
    fn get(&self, corner: Index) -> Index {
        match self {
            Self::Triangles => corner / 3,
            Self::Polygons(faces) => faces[corner as usize],
        }
    }
}

/// Number of vertices of a task.
const CHUNK: usize = 8192;

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

    /// Edges with their corners.
    fn edge_list(&self) -> &Edges {
        if let Some(edges) = self.edges.get() {
            return edges;
        }
        // Not inside of the lock: a thread that waits for others takes up other work, which may ask for the edges too.
        let mut edges = Edges::default();
        for (ends, corners) in self.in_chunks(|vertices| self.edges_to_higher(vertices)) {
            edges.ends.extend(ends);
            edges.corners.append(&corners);
        }
        self.edges.get_or_init(|| edges)
    }

    /// Edges from vertices to their higher neighbours, each with the corners that run along it, in the order of the faces.
    fn edges_to_higher(&self, vertices: Range<Index>) -> (Vec<[Index; 2]>, Ragged<Index>) {
        let (mut ends, mut corners, mut halves) = (Vec::with_capacity(3 * CHUNK), Ragged::default(), Vec::new());
        for v in vertices {
            halves.clear();
            for &corner in self.corners(v) {
                let previous = self.previous(corner);
                halves.extend([(self.vertex(self.next(corner)), corner), (self.vertex(previous), previous)]);
            }
            halves.retain(|half| half.0 > v);
            halves.sort_unstable();
            for same in halves.chunk_by(|x, y| x.0 == y.0) {
                ends.push([v, same[0].0]);
                corners.push(same.iter().map(|half| half.1));
            }
        }
        (ends, corners)
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
    /// Number of edges of the kind [`EdgeKind::Misoriented`].
    pub fn misoriented_edges(&self) -> usize {
        self.misoriented
    }
    /// Corners of a vertex, ascending.
    pub fn corners(&self, vertex: Index) -> &[Index] {
        self.vertex_corners.get(vertex)
    }
    /// End points of each edge, the lower one first, in ascending order. #E×2
    pub fn edges(&self) -> &[[Index; 2]] {
        &self.edge_list().ends
    }
    /// Corners that run along each edge. #E lists
    pub fn edge_corners(&self) -> &Ragged<Index> {
        &self.edge_list().corners
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
        match *self.edge_corners().get(edge) {
            [_] => EdgeKind::Boundary,
            [c, d] if self.vertex(c) != self.vertex(d) => EdgeKind::Interior,
            [_, _] => EdgeKind::Misoriented,
            _ => EdgeKind::NonManifold,
        }
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

/// Faces that satisfy the invariant of [`Topology`], and the faces of the input that had to be left out.
#[derive(Clone, Debug, Default)]
pub struct TidyFaces {
    /// Vertices of each face. #F lists
    pub faces: Ragged<Index>,
    /// Faces of the input with fewer than three different vertices in a row, which were left out.
    pub degenerate: Vec<Index>,
    /// Faces of the input with the same vertices as an earlier one, which were left out: a second layer would count twice in
    /// a normal, or cancel it if it is flipped.
    pub duplicate: Vec<Index>,
    /// Face and corners of the input for each face and each corner; `None` if all are as in the input.
    source: Option<(Vec<Index>, Vec<Index>)>,
    /// Corners of each vertex, if they have not changed.
    vertex_corners: Option<Ragged<Index>>,
}

impl TidyFaces {
    /// Face of the input for a face.
    pub fn source_face(&self, face: Index) -> Index {
        self.source.as_ref().map_or(face, |(faces, _)| faces[face as usize])
    }
    /// Corner of the input for a corner of [`Self::faces`].
    pub fn source_corner(&self, corner: Index) -> Index {
        self.source.as_ref().map_or(corner, |(_, corners)| corners[corner as usize])
    }
    /// Builds the connectivity of the faces over `vertex_count` vertices, as many as they were made tidy with. It takes the faces away.
    pub fn connect(&mut self, vertex_count: usize) -> Topology {
        let faces = std::mem::take(&mut self.faces);
        match self.vertex_corners.take() {
            Some(corners) => Topology::with_corners(vertex_count, faces, corners),
            None => Topology::new(vertex_count, faces),
        }
    }
}

/// Drops repeated corners, collapsed faces, and second layers of faces.
///
/// # Panics
/// If a face names a vertex that does not exist.
pub fn tidy(vertex_count: usize, input: Ragged<Index>) -> TidyFaces {
    let vertex_corners = Ragged::by_key(vertex_count, input.items());
    let duplicate = duplicates(&vertex_corners, &input);
    let all = (0..input.len() as Index).into_par_iter();
    let is_clean = |face: &[Index]| kept(face).count() == face.len() && has_three_vertices(face);
    if duplicate.is_empty() && all.all(|f| is_clean(input.get(f))) {
        return TidyFaces { faces: input, vertex_corners: Some(vertex_corners), ..TidyFaces::default() };
    }
    let mut out = TidyFaces::default();
    let (mut faces, mut corners) = (Vec::new(), Vec::new());
    for f in 0..input.len() as Index {
        let first = input.range(f).start as Index;
        let face = input.get(f);
        if kept(face).count() < 3 || !has_three_vertices(face) {
            out.degenerate.push(f);
        } else if duplicate.binary_search(&f).is_ok() {
            out.duplicate.push(f);
        } else {
            out.faces.push(kept(face).map(|k| face[k]));
            corners.extend(kept(face).map(|k| first + k as Index));
            faces.push(f);
        }
    }
    out.source = Some((faces, corners));
    out
}

/// Returns false for a face that goes to and fro between two vertices.
fn has_three_vertices(face: &[Index]) -> bool {
    let second = face.iter().find(|&&v| v != face[0]);
    second.is_some_and(|&second| face.iter().any(|&v| v != face[0] && v != second))
}

/// Corners of a face that do not repeat the previous one.
fn kept(face: &[Index]) -> impl Iterator<Item = usize> {
    (0..face.len()).filter(|&k| face[k] != face[if k == 0 { face.len() } else { k } - 1])
}

/// Faces whose vertices are those of an earlier face, ascending; `vertex_corners` are the corners of each vertex.
fn duplicates(vertex_corners: &Ragged<Index>, faces: &Ragged<Index>) -> Vec<Index> {
    let corner_faces = CornerFaces::of(faces);
    // A sum over the vertices tells almost all faces apart without sorting any.
    let mixed = |&v: &Index| u64::from(v).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let vertices = |f: Index| kept(faces.get(f)).map(move |k| &faces.get(f)[k]);
    let sum = |f: Index| vertices(f).map(mixed).fold(0u64, u64::wrapping_add);
    let sorted = |f: Index| {
        let mut sorted: Vec<_> = vertices(f).collect();
        sorted.sort_unstable();
        sorted
    };
    // Faces with the same vertices meet at the lowest of them.
    let at_lowest = |v: Index, keyed: &mut Vec<(u64, Index)>| {
        keyed.clear();
        let around = vertex_corners.get(v).iter().map(|&c| corner_faces.get(c));
        keyed.extend(around.filter(|&f| faces.get(f).iter().all(|&other| other >= v)).map(|f| (sum(f), f)));
        keyed.sort_unstable();
        // A face may pass a vertex twice.
        keyed.dedup();
        let mut found = Vec::new();
        for alike in keyed.chunk_by(|a, b| a.0 == b.0).filter(|alike| alike.len() > 1) {
            let is_known = |k: usize, f| alike[..k].iter().any(|e| sorted(e.1) == sorted(f));
            found.extend(alike.iter().enumerate().filter(|(k, (_, f))| is_known(*k, *f)).map(|(_, (_, f))| *f));
        }
        found
    };
    let all = (0..vertex_corners.len() as Index).into_par_iter().with_min_len(CHUNK);
    let mut duplicates: Vec<Index> = all.map_init(Vec::new, |keyed, v| at_lowest(v, keyed)).flatten_iter().collect();
    duplicates.par_sort_unstable();
    duplicates
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
        let tidy = tidy(5, input);
        assert_eq!(tidy.faces.iter().collect::<Vec<_>>(), [&[0, 1, 2][..], &[1, 3, 2]]);
        assert_eq!(tidy.degenerate, [1, 5]);
        assert_eq!(tidy.duplicate, [2, 3]);
        assert_eq!([0, 1].map(|f| tidy.source_face(f)), [0, 4]);
        assert_eq!([0, 1, 2, 3, 4, 5].map(|c| tidy.source_corner(c)), [0, 1, 2, 13, 14, 15]);
    }
}
