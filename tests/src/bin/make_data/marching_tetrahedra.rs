//! A closed mesh of a signed distance field's zero set.
//!
//! Akio Doi, Akio Koide. An efficient method of triangulating equi-valued surfaces by using
//! tetrahedral cells. IEICE Transactions E74(1), 1991.
//!
//! Chosen over marching cubes and surface nets because it has no ambiguous case: the result is
//! always a manifold. Its slivers do not matter, they go in [`remesh`](crate::remesh).

use crate::mesh::{Mesh, area_vector};
use glam::{DVec3, USizeVec3};
use std::collections::HashMap;

/// Kuhn's six tetrahedra of a cube, which agree with the neighbour's on every shared side.
/// Corner number = x + 2y + 4z; each walks from corner 0 to corner 7 along one order of the axes.
const KUHN: [[usize; 4]; 6] = [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]];

/// Zero set of `field` inside the box `low..high`, which it must not touch.
pub(crate) fn polygonise(field: impl Fn(DVec3) -> f64, [low, high]: [DVec3; 2], step: f64) -> Mesh {
    let cells = ((high - low) / step).ceil().as_usizevec3();
    let corners = cells + USizeVec3::ONE;
    let index = |c: USizeVec3| c.x + corners.x * (c.y + corners.y * c.z);
    let place = |c: USizeVec3| low + c.as_dvec3() * step;
    let mut values = Vec::with_capacity(corners.element_product());
    // A corner on the surface would pull all its crossings onto itself; it counts as outside.
    let clear_of_zero = |value: f64| if value.abs() < 1e-3 * step { 1e-3 * step } else { value };
    for_each_cell(corners, |c| values.push(clear_of_zero(field(place(c)))));

    let mut mesh = Mesh::default();
    // Looked up only, never walked through: its order cannot reach the result.
    let mut vertex_on_edge = HashMap::new();
    for_each_cell(cells, |cell| {
        for tetrahedron in KUHN {
            let tetrahedron = tetrahedron.map(|k| cell + USizeVec3::new(k & 1, (k >> 1) & 1, (k >> 2) & 1));
            let (inside, outside): (Vec<_>, Vec<_>) = tetrahedron.into_iter().partition(|c| values[index(*c)] < 0.0);
            let mut crossing = |i: usize, o: usize| {
                let ends = [inside[i], outside[o]];
                let key = ends.map(index);
                let middle = (place(ends[0]) + place(ends[1])) * 0.5;
                let vertex = *vertex_on_edge.entry(key).or_insert_with(|| {
                    let [a, b] = key.map(|k| values[k]);
                    mesh.positions.push(place(ends[0]).lerp(place(ends[1]), a / (a - b)));
                    mesh.positions.len() - 1
                });
                (vertex, middle)
            };
            let polygon = match inside.len() {
                1 => vec![crossing(0, 0), crossing(0, 1), crossing(0, 2)],
                2 => vec![crossing(0, 0), crossing(0, 1), crossing(1, 1), crossing(1, 0)],
                3 => vec![crossing(0, 0), crossing(1, 0), crossing(2, 0)],
                _ => continue,
            };
            let outward = place(outside[0]) - place(inside[0]);
            for k in 2..polygon.len() {
                let triangle = [polygon[0], polygon[k - 1], polygon[k]];
                // Edge middles instead of crossings: never degenerate, same orientation.
                let flipped = area_vector(triangle.map(|(_, middle)| middle)).dot(outward) < 0.0;
                let [a, b, c] = triangle.map(|(vertex, _)| vertex);
                mesh.triangles.push(if flipped { [a, c, b] } else { [a, b, c] });
            }
        }
    });
    mesh
}

fn for_each_cell(size: USizeVec3, mut visit: impl FnMut(USizeVec3)) {
    for z in 0..size.z {
        for y in 0..size.y {
            for x in 0..size.x {
                visit(USizeVec3::new(x, y, z));
            }
        }
    }
}
