//! A closed triangle mesh under edge splits, collapses and flips.
//!
//! The operations keep it a closed manifold or refuse; whether they make it better is for
//! [`remesh`](crate::remesh) to judge.

use crate::mesh::{Mesh, directed_edges};
use glam::DVec3;

/// A closed manifold that may change; removed faces and vertices leave holes in the numbering.
pub(crate) struct EditableMesh {
    pub(crate) positions: Vec<DVec3>,
    faces: Vec<Option<[usize; 3]>>,
    /// Faces around each vertex, in no order; empty for a removed vertex.
    rings: Vec<Vec<usize>>,
}

impl EditableMesh {
    pub(crate) fn new(mesh: Mesh) -> Self {
        let mut rings = vec![Vec::new(); mesh.positions.len()];
        for (f, triangle) in mesh.triangles.iter().enumerate() {
            for &v in triangle {
                rings[v].push(f);
            }
        }
        let faces = mesh.triangles.into_iter().map(Some).collect();
        Self { positions: mesh.positions, faces, rings }
    }

    /// The mesh without the holes in its numbering.
    pub(crate) fn into_mesh(self) -> Mesh {
        let mut new_index = vec![usize::MAX; self.positions.len()];
        let mut positions = Vec::new();
        for (v, position) in self.positions.iter().enumerate() {
            if !self.rings[v].is_empty() {
                new_index[v] = positions.len();
                positions.push(*position);
            }
        }
        let triangles = self.faces.iter().flatten().map(|t| t.map(|v| new_index[v])).collect();
        Mesh { positions, triangles }
    }

    /// Vertices in use.
    pub(crate) fn vertices(&self) -> Vec<usize> {
        (0..self.positions.len()).filter(|&v| !self.rings[v].is_empty()).collect()
    }

    /// Undirected edges, lower vertex first.
    pub(crate) fn edges(&self) -> Vec<[usize; 2]> {
        let edges = self.faces.iter().flatten().flat_map(|&t| directed_edges(t));
        edges.filter(|[a, b]| a < b).collect()
    }

    /// Triangles around `v`.
    pub(crate) fn ring(&self, v: usize) -> impl Iterator<Item = [usize; 3]> + '_ {
        self.rings[v].iter().filter_map(|&f| self.faces[f])
    }

    /// Vertices joined to `v`: in a closed mesh each follows `v` in exactly one triangle.
    pub(crate) fn neighbours(&self, v: usize) -> impl Iterator<Item = usize> + '_ {
        self.ring(v).map(move |triangle| rotate_to(triangle, v)[1])
    }

    pub(crate) fn valence(&self, v: usize) -> usize {
        self.rings[v].len()
    }

    pub(crate) fn has_edge(&self, a: usize, b: usize) -> bool {
        self.neighbours(a).any(|v| v == b)
    }

    /// The vertices facing edge `ab`: to the left of a→b, then to the right.
    pub(crate) fn facing(&self, a: usize, b: usize) -> Option<[usize; 2]> {
        let left = self.face_at(a, b)?;
        let right = self.face_at(b, a)?;
        Some([self.third(left, a, b), self.third(right, a, b)])
    }

    /// Puts a new vertex on edge `ab`.
    pub(crate) fn split(&mut self, [a, b]: [usize; 2], position: DVec3) {
        let (Some(left), Some(right)) = (self.face_at(a, b), self.face_at(b, a)) else { return };
        let [c, d] = [self.third(left, a, b), self.third(right, a, b)];
        let middle = self.positions.len();
        self.positions.push(position);
        self.rings.push(Vec::new());
        self.set_face(left, [a, middle, c]);
        self.set_face(right, [a, d, middle]);
        self.add_face([middle, b, c]);
        self.add_face([middle, d, b]);
    }

    /// Whether merging `a` and `b` leaves a manifold: the link condition, and no valence below 3.
    pub(crate) fn can_collapse(&self, [a, b]: [usize; 2]) -> bool {
        let Some(facing) = self.facing(a, b) else { return false };
        let shared = self.neighbours(a).filter(|&v| self.has_edge(v, b)).count();
        shared == 2 && facing.iter().all(|&v| self.valence(v) > 3)
    }

    /// Merges `b` into `a`, which moves to `position`. Asks for [`Self::can_collapse`].
    pub(crate) fn collapse(&mut self, [a, b]: [usize; 2], position: DVec3) {
        for f in self.rings[b].clone() {
            let Some(triangle) = self.faces[f] else { continue };
            if triangle.contains(&a) {
                self.remove_face(f);
            } else {
                self.set_face(f, triangle.map(|v| if v == b { a } else { v }));
            }
        }
        self.positions[a] = position;
    }

    /// Turns edge `ab` into the other diagonal `cd` of its quadrilateral, unless that exists.
    pub(crate) fn flip(&mut self, [a, b]: [usize; 2]) -> bool {
        let (Some(left), Some(right)) = (self.face_at(a, b), self.face_at(b, a)) else {
            return false;
        };
        let [c, d] = [self.third(left, a, b), self.third(right, a, b)];
        if self.has_edge(c, d) {
            return false;
        }
        self.set_face(left, [a, d, c]);
        self.set_face(right, [d, b, c]);
        true
    }

    fn face_at(&self, a: usize, b: usize) -> Option<usize> {
        let has_edge = |f: &&usize| self.faces[**f].is_some_and(|t| rotate_to(t, a)[1] == b);
        self.rings[a].iter().find(has_edge).copied()
    }

    fn third(&self, face: usize, a: usize, b: usize) -> usize {
        let triangle = self.faces[face].unwrap_or_default();
        triangle[0] + triangle[1] + triangle[2] - a - b
    }

    fn add_face(&mut self, triangle: [usize; 3]) {
        self.faces.push(None);
        self.set_face(self.faces.len() - 1, triangle);
    }

    fn set_face(&mut self, face: usize, triangle: [usize; 3]) {
        self.remove_face(face);
        self.faces[face] = Some(triangle);
        for v in triangle {
            self.rings[v].push(face);
        }
    }

    fn remove_face(&mut self, face: usize) {
        for v in self.faces[face].take().into_iter().flatten() {
            self.rings[v].retain(|&f| f != face);
        }
    }
}

/// The same triangle, starting at `v`.
fn rotate_to([a, b, c]: [usize; 3], v: usize) -> [usize; 3] {
    if v == a {
        [a, b, c]
    } else if v == b {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
