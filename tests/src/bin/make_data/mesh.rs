//! The plainest triangle mesh: positions and index triples.

use glam::DVec3;
use std::collections::HashMap;

/// A triangle mesh; triangles run counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) triangles: Vec<[usize; 3]>,
}

impl Mesh {
    pub(crate) fn corners(&self, triangle: [usize; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.positions[v])
    }
}

/// Twice the area of a triangle, along its outward normal.
pub(crate) fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The three directed edges of a triangle.
pub(crate) fn directed_edges([a, b, c]: [usize; 3]) -> [[usize; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// The triangle across each edge, edges in the order of [`directed_edges`]; the mesh is closed.
pub(crate) fn faces_across(triangles: &[[usize; 3]]) -> Vec<[usize; 3]> {
    let edges = triangles.iter().enumerate();
    let face_of: HashMap<_, _> = edges.flat_map(|(f, &t)| directed_edges(t).map(|edge| (edge, f))).collect();
    triangles.iter().map(|&t| directed_edges(t).map(|[a, b]| face_of[&[b, a]])).collect()
}
