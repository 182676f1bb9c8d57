//! A piece of a mesh with its own flat coordinates.

use glam::DVec2;

/// A connected piece of a mesh, flattened. Each vertex has one flat place per chart.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    /// Which group of the file the chart belongs to.
    pub(crate) group: usize,
    /// Vertices of the mesh that the chart touches.
    pub(crate) vertices: Vec<usize>,
    /// Flat place of each of them, in model units until packed, then in the atlas.
    pub(crate) uvs: Vec<DVec2>,
    /// Indices into the two lists above.
    pub(crate) triangles: Vec<[usize; 3]>,
}

impl Chart {
    pub(crate) fn corners(&self, triangle: [usize; 3]) -> [DVec2; 3] {
        triangle.map(|v| self.uvs[v])
    }

    pub(crate) fn area(&self) -> f64 {
        self.triangles.iter().map(|&t| signed_area(self.corners(t))).sum()
    }
}

/// Area of a flat triangle, negative when it runs clockwise.
pub(crate) fn signed_area([a, b, c]: [DVec2; 3]) -> f64 {
    0.5 * (b - a).perp_dot(c - a)
}
