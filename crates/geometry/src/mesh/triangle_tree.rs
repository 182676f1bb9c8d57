//! Nearest points on a surface.

use crate::mesh::jagged::Index;
use glam::DVec3;
use rayon::prelude::*;
use rstar::{AABB, PointDistance, RTree, RTreeObject};

/// Search tree (R-tree) of triangles, which finds the nearest triangle to a point.
#[derive(Clone, Debug)]
pub(crate) struct TriangleTree(RTree<Triangle>);

impl TriangleTree {
    /// Builds the tree of triangles (#T×3) over positions (#V×3, model units).
    pub(crate) fn new(positions: &[DVec3], faces: impl IntoIterator<Item = [Index; 3]>) -> Self {
        let triangles = faces.into_iter().map(|t| Triangle(t.map(|v| positions[v as usize])));
        // A triangle without area adds no point to the surface, because its edges belong to others as well.
        Self(RTree::bulk_load(triangles.filter(Triangle::has_area).collect()))
    }

    /// Distance of each point (#P×3) to the nearest triangle; NaN without triangles. #P, model units
    pub(crate) fn distances(&self, points: &[DVec3]) -> Vec<f64> {
        let nearest =
            |p: &DVec3| self.0.nearest_neighbor_with_distance_2(p.to_array()).map_or(f64::NAN, |(_, d2)| d2.sqrt());
        points.par_iter().map(nearest).collect()
    }

    /// Nearest point of the surface for each point (#P×3); the point itself without triangles. #P×3, model units
    pub(crate) fn nearest(&self, points: &[DVec3]) -> Vec<DVec3> {
        let nearest = |p: &DVec3| self.0.nearest_neighbor(p.to_array()).map_or(*p, |t| closest_point(*p, t.0));
        points.par_iter().map(nearest).collect()
    }
}

#[derive(Clone, Debug)]
struct Triangle([DVec3; 3]);

impl Triangle {
    fn has_area(&self) -> bool {
        let [a, b, c] = self.0;
        (b - a).cross(c - a) != DVec3::ZERO
    }
}

impl RTreeObject for Triangle {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        let [a, b, c] = self.0;
        AABB::from_corners(a.min(b).min(c).to_array(), a.max(b).max(c).to_array())
    }
}

impl PointDistance for Triangle {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        let p = DVec3::from(*point);
        closest_point(p, self.0).distance_squared(p)
    }
}

/// Point of a triangle nearest to `p`, by Voronoi regions (Ericson, Real-Time Collision Detection, 5.1.5).
fn closest_point(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let scale = 1.0 / (va + vb + vc);
    a + ab * (vb * scale) + ac * (vc * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_region_of_a_triangle_answers() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for (p, q) in [
            ((-1.0, -1.0, 1.0), (0.0, 0.0, 0.0)),
            ((2.0, -0.5, 0.0), (1.0, 0.0, 0.0)),
            ((-0.5, 3.0, 0.0), (0.0, 1.0, 0.0)),
            ((0.3, -2.0, 1.0), (0.3, 0.0, 0.0)),
            ((-2.0, 0.4, 1.0), (0.0, 0.4, 0.0)),
            ((1.0, 1.0, 5.0), (0.5, 0.5, 0.0)),
            ((0.2, 0.3, 7.0), (0.2, 0.3, 0.0)),
        ] {
            assert!(closest_point(p.into(), t).distance(q.into()) < 1e-15);
        }
    }
}
