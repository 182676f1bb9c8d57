//! Points with integer coordinates inside of triangles.

use crate::mesh::jagged::Index;
use glam::DVec2;

/// Calls `visit` with each point of the lattice ℤ² in a triangle and its barycentric coordinates. `ids` name the corners: exactly one
/// of the triangles that meet at a point, on an edge or at a corner, has it.
pub(super) fn scan(points: [DVec2; 3], ids: [Index; 3], mut visit: impl FnMut([i64; 2], [f64; 3])) {
    let [a, b, c] = points;
    let low = a.min(b).min(c).ceil();
    let high = a.max(b).max(c).floor();
    for j in low.y as i64..=high.y as i64 {
        for i in low.x as i64..=high.x as i64 {
            let p = DVec2::new(i as f64, j as f64);
            let sides = [[1, 2], [2, 0], [0, 1]].map(|[k, l]| side(points, ids, [k, l], p));
            let total: f64 = sides.iter().map(|side| side.0).sum();
            if sides.iter().all(|side| side.1 == sides[0].1) && total != 0.0 {
                visit([i, j], sides.map(|side| side.0 / total));
            }
        }
    }
}

/// Twice the signed area that the edge from corner k to corner l spans with a point, and whether the point is to the left. The edge
/// is measured from its lower vertex, so that both of its triangles get the same number. A point on the edge counts as if it were
/// shifted by an infinitely small step along x, and a still smaller one along y.
fn side(points: [DVec2; 3], ids: [Index; 3], [k, l]: [usize; 2], p: DVec2) -> (f64, bool) {
    let of_edge = |a: DVec2, b: DVec2| {
        let area = (b - a).perp_dot(p - a);
        (area, area > 0.0 || area == 0.0 && (b.y < a.y || b.y == a.y && b.x > a.x))
    };
    if ids[k] < ids[l] {
        of_edge(points[k], points[l])
    } else {
        let (area, is_left) = of_edge(points[l], points[k]);
        (-area, !is_left)
    }
}
