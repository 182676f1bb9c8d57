//! Edges of a mesh, which are made when they are first asked for, and their kinds.

use super::{CHUNK, Topology};
use crate::mesh::jagged::{Index, Ragged};
use std::ops::Range;

/// Edges of a mesh in ascending order.
#[derive(Clone, Debug, Default)]
pub(super) struct Edges {
    ends: Vec<[Index; 2]>,
    corners: Ragged<Index>,
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

    /// Number of edges of the kind [`EdgeKind::Misoriented`].
    pub fn misoriented_edges(&self) -> usize {
        self.misoriented
    }
    /// End points of each edge, the lower one first, in ascending order. #E×2
    pub fn edges(&self) -> &[[Index; 2]] {
        &self.edge_list().ends
    }
    /// Corners that run along each edge. #E lists
    pub fn edge_corners(&self) -> &Ragged<Index> {
        &self.edge_list().corners
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
}
