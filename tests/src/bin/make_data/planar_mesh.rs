//! Fills a flat region with nearly equilateral triangles.
//!
//! A triangular lattice inside, then Laplacian smoothing over a constrained Delaunay triangulation
//! that is made anew each time: more uniform than refinement, which only bounds the angles.

use glam::DVec2;
use spade::{ConstrainedDelaunayTriangulation, InsertionError, Point2, Triangulation};

const SMOOTHING_ROUNDS: usize = 12;
/// Smallest distance of a lattice point to the boundary, in edge lengths.
const CLEARANCE: f64 = 0.62;

/// Triangles over the loops' points, in their order, and then over the new inner points.
pub(crate) struct Filling {
    pub(crate) inner: Vec<DVec2>,
    pub(crate) triangles: Vec<[usize; 3]>,
}

/// Fills the region inside an odd number of the closed `loops` and leaves their edges whole.
pub(crate) fn fill(loops: &[Vec<DVec2>], edge_length: f64) -> Result<Filling, InsertionError> {
    let rim: Vec<DVec2> = loops.concat();
    let mut points = rim.clone();
    points.extend(lattice(loops, edge_length));
    let mut triangles = triangulate(loops, &points)?;
    for _ in 0..SMOOTHING_ROUNDS {
        let mut sums = vec![(DVec2::ZERO, 0.0); points.len()];
        for t in &triangles {
            for k in 0..3 {
                // Around an inner point each neighbour is the next corner of one triangle.
                let sum = &mut sums[t[k]];
                *sum = (sum.0 + points[t[(k + 1) % 3]], sum.1 + 1.0);
            }
        }
        for v in rim.len()..points.len() {
            points[v] = sums[v].0 / sums[v].1;
        }
        triangles = triangulate(loops, &points)?;
    }
    Ok(Filling { inner: points.split_off(rim.len()), triangles })
}

/// Points of a triangular lattice inside the region that keep clear of its boundary.
fn lattice(loops: &[Vec<DVec2>], edge_length: f64) -> Vec<DVec2> {
    let rim = || loops.iter().flatten();
    let low = rim().fold(DVec2::INFINITY, |low, p| low.min(*p));
    let high = rim().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
    let step = DVec2::new(edge_length, edge_length * 0.75f64.sqrt());
    let half = ((high - low) / (2.0 * step)).ceil().as_ivec2();
    let mut points = Vec::new();
    for j in -half.y..=half.y {
        let offset = if j % 2 == 0 { 0.0 } else { 0.5 };
        for i in -half.x..=half.x {
            let p = low.midpoint(high) + DVec2::new(f64::from(i) + offset, f64::from(j)) * step;
            let clear = sides(loops).all(|side| distance(p, side) > CLEARANCE * edge_length);
            if clear && is_inside(loops, p) {
                points.push(p);
            }
        }
    }
    points
}

fn triangulate(loops: &[Vec<DVec2>], points: &[DVec2]) -> Result<Vec<[usize; 3]>, InsertionError> {
    let mut delaunay = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut handles = Vec::with_capacity(points.len());
    for p in points {
        handles.push(delaunay.insert(Point2::new(p.x, p.y))?);
    }
    let mut first = 0;
    for boundary in loops {
        for k in 0..boundary.len() {
            delaunay.add_constraint(handles[first + k], handles[first + (k + 1) % boundary.len()]);
        }
        first += boundary.len();
    }
    let faces = delaunay.inner_faces().map(|face| face.vertices().map(|v| v.fix().index()));
    let is_filled = |t: &[usize; 3]| is_inside(loops, t.iter().map(|&v| points[v]).sum::<DVec2>() / 3.0);
    Ok(faces.filter(is_filled).collect())
}

fn sides(loops: &[Vec<DVec2>]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    loops.iter().flat_map(|points| (0..points.len()).map(|k| [points[k], points[(k + 1) % points.len()]]))
}

/// Even-odd rule.
fn is_inside(loops: &[Vec<DVec2>], p: DVec2) -> bool {
    let crosses =
        |[a, b]: &[DVec2; 2]| (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x);
    sides(loops).filter(crosses).count() % 2 == 1
}

fn distance(p: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a.lerp(b, along))
}
