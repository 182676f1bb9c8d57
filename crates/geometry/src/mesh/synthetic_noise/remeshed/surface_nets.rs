//! Surfaces in grids of numbers, by naive surface nets (Gibson 1998, Constrained Elastic Surface Nets, without the relaxation).
//!
//! A cell whose corners have both signs gets a vertex at the mean of the zeros along its edges. An edge of the grid whose ends have
//! different signs gets a quad between the four cells around it.

use super::{RemeshError, cell_count};
use crate::mesh::jagged::Index;
use glam::DVec3;

/// Nodes of a grid in space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Position of the first node.
    pub(super) low: DVec3,
    /// Distance of neighbouring nodes, model units.
    pub(super) step: f64,
    /// Number of nodes along each axis.
    pub(super) size: [usize; 3],
}

impl Grid {
    /// Covers a box, with `margin` nodes around it. `offset` in 0..1 shifts the nodes by a part of a step.
    pub(super) fn around([low, high]: [DVec3; 2], step: f64, margin: f64, offset: DVec3) -> Result<Self, RemeshError> {
        let sides = ((high - low) / step).ceil() + 2.0 * margin + 2.0;
        cell_count(&sides.to_array())?;
        Ok(Self { low: low - (offset + margin) * step, step, size: sides.to_array().map(|side| side as usize) })
    }
    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.size.iter().product()
    }
    /// Index of a node.
    pub(super) fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.size[1] + j) * self.size[0] + i
    }
    /// Node with an index.
    pub(super) fn node(&self, index: usize) -> [usize; 3] {
        let rest = index / self.size[0];
        [index % self.size[0], rest % self.size[1], rest / self.size[1]]
    }
    /// Position of a node.
    pub(super) fn position(&self, node: [usize; 3]) -> DVec3 {
        self.low + DVec3::from_array(node.map(|x| x as f64)) * self.step
    }
}

/// Positions (#V×3) and triangles of the surface between negative values, which are inside, and others. Cells with a value that is
/// not a number have no surface.
pub(super) fn surface(grid: &Grid, values: &[f32]) -> (Vec<DVec3>, Vec<[Index; 3]>) {
    let mut positions = Vec::new();
    let mut number = |index| {
        let Some(position) = cell_vertex(grid, values, grid.node(index)) else { return Index::MAX };
        positions.push(position);
        positions.len() as Index - 1
    };
    let vertex_of: Vec<Index> = (0..grid.len()).map(&mut number).collect();
    let mut faces = Vec::new();
    for index in 0..grid.len() {
        let node = grid.node(index);
        for axis in 0..3 {
            faces.extend(quad(grid, values, &vertex_of, node, axis).into_iter().flatten());
        }
    }
    (positions, faces)
}

/// Vertex of the cell whose lowest corner is a node; `None` without one.
fn cell_vertex(grid: &Grid, values: &[f32], node: [usize; 3]) -> Option<DVec3> {
    if (0..3).any(|axis| node[axis] + 1 >= grid.size[axis]) {
        return None;
    }
    let corner = |bits: usize| [0, 1, 2].map(|axis| node[axis] + (bits >> axis & 1));
    let corners: [f32; 8] = std::array::from_fn(|bits| values[grid.index(corner(bits))]);
    let negative = corners.iter().filter(|value| **value < 0.0).count();
    if negative == 0 || negative == 8 || corners.iter().any(|value| value.is_nan()) {
        return None;
    }
    let (mut sum, mut count) = (DVec3::ZERO, 0);
    for (bits, axis) in (0..8).flat_map(|bits| (0..3).map(move |axis| (bits, axis))) {
        let other = bits | 1 << axis;
        if other != bits && (corners[bits] < 0.0) != (corners[other] < 0.0) {
            let [a, b] = [bits, other].map(|bits| f64::from(corners[bits]));
            let [p, q] = [bits, other].map(|bits| grid.position(corner(bits)));
            sum += p + (q - p) * (a / (a - b));
            count += 1;
        }
    }
    Some(sum / f64::from(count))
}

/// Two triangles around the edge from a node along an axis; `None` if the surface does not cross it or a cell has no vertex.
fn quad(grid: &Grid, values: &[f32], vertex_of: &[Index], node: [usize; 3], axis: usize) -> Option<[[Index; 3]; 2]> {
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    if node[axis] + 1 >= grid.size[axis] || node[u] == 0 || node[v] == 0 {
        return None;
    }
    let mut end = node;
    end[axis] += 1;
    let is_inside = [node, end].map(|node| values[grid.index(node)] < 0.0);
    if is_inside[0] == is_inside[1] {
        return None;
    }
    // Counter-clockwise around the axis.
    let around = [[1, 1], [0, 1], [0, 0], [1, 0]].map(|[du, dv]| {
        let mut cell = node;
        cell[u] -= du;
        cell[v] -= dv;
        vertex_of[grid.index(cell)]
    });
    if around.contains(&Index::MAX) {
        return None;
    }
    let [a, b, c, d] = around;
    // The normal points out of the inside.
    Some(if is_inside[0] { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] })
}
