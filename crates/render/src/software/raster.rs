//! Samples that a triangle covers, found by exact integer arithmetic as in Direct3D's rasterisation rules: no
//! sample on a shared edge is drawn twice or left out.
//!
//! Juan Pineda. A parallel algorithm for polygon rasterization. SIGGRAPH 1988.

use glam::{DVec2, Vec4, Vec4Swizzles};
use std::ops::Range;

/// Corners are rounded to this many steps per sample.
const STEPS: i64 = 256;

/// The samples of a picture; row 0 is the top. Sample (x, y) lies in the middle of its cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Grid {
    fn size(self) -> DVec2 {
        DVec2::new(self.width as f64, self.height as f64)
    }

    /// Normalised device coordinates (−1..1, y up) of a sample.
    pub(super) fn ndc_from_sample(self, x: usize, y: usize) -> DVec2 {
        let unit = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / self.size();
        DVec2::new(2.0 * unit.x - 1.0, 1.0 - 2.0 * unit.y)
    }

    /// Steps from the top-left corner.
    fn steps_from_clip(self, clip: Vec4) -> [i64; 2] {
        let ndc = DVec2::new(f64::from(clip.x), f64::from(clip.y)) / f64::from(clip.w);
        let unit = DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
        (unit * self.size() * STEPS as f64).round().to_array().map(|s| s as i64)
    }
}

/// Whether a triangle in clip space is seen from the side from which it is counter-clockwise: the signed area on the picture is the
/// determinant of (x, y, w).
pub(super) fn is_front(clip_corners: [Vec4; 3]) -> bool {
    let [a, b, c] = clip_corners.map(Vec4Swizzles::xyw);
    a.dot(b.cross(c)) > 0.0
}

/// A triangle on the grid; which way round it was does not matter.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScreenTriangle {
    /// Steps; the area is positive.
    corners: [[i64; 2]; 3],
    /// Depths of the corners, 0..1, near to far; linear over the screen.
    depths: [f32; 3],
    /// Index of the triangle this is part of.
    pub(super) source: u32,
}

impl ScreenTriangle {
    /// Rounds a triangle to the grid; `None` if it has no area on the screen.
    pub(super) fn new(clip_corners: [Vec4; 3], source: u32, grid: Grid) -> Option<Self> {
        let [a, b, c] = clip_corners.map(|corner| grid.steps_from_clip(corner));
        let [da, db, dc] = clip_corners.map(|corner| corner.z / corner.w);
        match Edge::new(a, b).side(c) {
            0 => None,
            1.. => Some(Self { corners: [a, b, c], depths: [da, db, dc], source }),
            _ => Some(Self { corners: [a, c, b], depths: [da, dc, db], source }),
        }
    }

    /// Returns the rows of samples that the triangle may cover.
    pub(super) fn rows(&self, grid: Grid) -> Range<usize> {
        centres_between(self.corners.map(|[_, y]| y), grid.height)
    }

    /// Calls `visit(x, y, depth)` once for each sample that the triangle covers in these rows.
    pub(super) fn rasterise(&self, grid: Grid, rows: Range<usize>, mut visit: impl FnMut(usize, usize, f32)) {
        let [a, b, c] = self.corners;
        let opposite = [Edge::new(b, c), Edge::new(c, a), Edge::new(a, b)];
        let area = opposite[2].side(c) as f64;
        let own = self.rows(grid);
        let columns = centres_between(self.corners.map(|[x, _]| x), grid.width);
        for y in own.start.max(rows.start)..own.end.min(rows.end) {
            for x in columns.clone() {
                let sample = [centre(x), centre(y)];
                let sides = opposite.map(|edge| edge.side(sample));
                if opposite.iter().zip(sides).all(|(edge, side)| edge.owns(side)) {
                    let weighted = sides.iter().zip(self.depths).map(|(s, d)| *s as f64 * f64::from(d));
                    visit(x, y, (weighted.sum::<f64>() / area) as f32);
                }
            }
        }
    }
}

/// Steps to the middle of a cell.
fn centre(cell: usize) -> i64 {
    cell as i64 * STEPS + STEPS / 2
}

/// Cells of `0..count` whose centre is within the span of these coordinates.
fn centres_between(steps: [i64; 3], count: usize) -> Range<usize> {
    let [low, high] = [steps.iter().min(), steps.iter().max()].map(|s| s.copied().unwrap_or(0));
    let first_at_or_above = |s: i64| (s + STEPS / 2 - 1).div_euclid(STEPS).clamp(0, count as i64) as usize;
    first_at_or_above(low)..first_at_or_above(high + 1)
}

/// A directed line; the triangle lies on its positive side.
#[derive(Clone, Copy)]
struct Edge {
    origin: [i64; 2],
    direction: [i64; 2],
}

impl Edge {
    fn new([ax, ay]: [i64; 2], [bx, by]: [i64; 2]) -> Self {
        Self { origin: [ax, ay], direction: [bx - ax, by - ay] }
    }

    /// Twice the signed area with a point. The guard band keeps it far from the end of i64.
    fn side(self, [x, y]: [i64; 2]) -> i64 {
        self.direction[0] * (y - self.origin[1]) - self.direction[1] * (x - self.origin[0])
    }

    /// Whether a sample on this side counts as inside. On the line itself only top and left edges count,
    /// as if the sample were moved right by an infinitely small step, and down by a smaller one.
    fn owns(self, side: i64) -> bool {
        let [dx, dy] = self.direction;
        side > 0 || (side == 0 && (dy < 0 || (dy == 0 && dx > 0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    const GRID: Grid = Grid { width: 8, height: 8 };

    /// Places a point given in samples from the top-left corner.
    fn at(x: f32, y: f32, depth: f32) -> Vec4 {
        let ndc = Vec2::new(x / 4.0 - 1.0, 1.0 - y / 4.0);
        ndc.extend(depth).extend(1.0)
    }

    fn visits(triangles: &[[Vec4; 3]]) -> Vec<u32> {
        let mut counts = vec![0; GRID.width * GRID.height];
        for triangle in triangles.iter().filter_map(|t| ScreenTriangle::new(*t, 0, GRID)) {
            triangle.rasterise(GRID, 0..GRID.height, |x, y, _| counts[y * GRID.width + x] += 1);
        }
        counts
    }

    /// A fan about `hub` that tiles the square from (0, 0) to (8, 8); every other triangle is turned round.
    fn fan(hub: [f32; 2]) -> Vec<[Vec4; 3]> {
        let boundary =
            [[0, 0], [4, 0], [8, 0], [8, 4], [8, 8], [4, 8], [0, 8], [0, 4]].map(|[x, y]| [x as f32, y as f32]);
        (0..8)
            .map(|i| {
                let (a, b) = (boundary[i], boundary[(i + 1) % 8]);
                let [a, b, c] = [hub, a, b].map(|[x, y]| at(x, y, 0.5));
                if i % 2 == 0 { [a, b, c] } else { [a, c, b] }
            })
            .collect()
    }

    #[test]
    fn triangles_that_tile_a_square_cover_each_sample_once() {
        // At half-integers the hub is a sample, and edges run through samples.
        for hub in [[4.5, 4.5], [0.5, 7.5], [4.0, 4.0], [2.5, 4.0], [3.37, 5.91], [0.0, 0.0]] {
            assert_eq!(visits(&fan(hub)), [1; 64], "hub {hub:?}");
        }
    }

    #[test]
    fn top_and_left_edges_own_their_samples() {
        let square = [
            [at(1.5, 1.5, 0.0), at(3.5, 1.5, 0.0), at(1.5, 3.5, 0.0)],
            [at(3.5, 1.5, 0.0), at(1.5, 3.5, 0.0), at(3.5, 3.5, 0.0)],
        ];
        let covered: Vec<_> =
            visits(&square).iter().enumerate().filter(|(_, n)| **n > 0).map(|(i, _)| (i % 8, i / 8)).collect();
        assert_eq!(covered, [(1, 1), (2, 1), (1, 2), (2, 2)]);
    }

    #[test]
    fn depth_is_that_of_the_plane() {
        let depth = |x: f32, y: f32| 0.1 + 0.05 * x + 0.02 * y;
        let corners = [[-3.0, 1.0], [7.5, -2.0], [5.0, 9.0]].map(|[x, y]| at(x, y, depth(x, y)));
        let triangle = ScreenTriangle::new(corners, 0, GRID).unwrap();
        triangle.rasterise(GRID, 0..8, |x, y, found| {
            assert!((found - depth(x as f32 + 0.5, y as f32 + 0.5)).abs() < 1e-6, "({x}, {y}): {found}");
        });
    }

    #[test]
    fn what_has_no_area_is_not_drawn() {
        assert!(ScreenTriangle::new([at(1.0, 1.0, 0.0), at(3.0, 3.0, 0.0), at(2.0, 2.0, 0.0)], 0, GRID).is_none());
    }
}
