//! Area and triangulation of one polygon in space.
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::mesh::polygon;
//!
//! // A dart, whose second corner points inwards: a fan at its first corner would leave it.
//! let dart = [[-1.0, 0.0, 0.0], [0.0, 0.5, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(DVec3::from_array);
//! let mut triangles = Vec::new();
//! polygon::triangulate(&dart, |triangle| triangles.push(triangle));
//! assert!(triangles.len() == 2 && triangles.iter().all(|t| t.contains(&1) && t.contains(&3)));
//! assert_eq!(polygon::newell(dart.into_iter()), DVec3::Z);
//! ```

use glam::{DVec2, DVec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Vector area of a polygon (Newell 1972): normal of its best plane, with twice its area as length.
pub fn newell(points: impl ExactSizeIterator<Item = DVec3> + Clone) -> DVec3 {
    let origin = points.clone().next().unwrap_or(DVec3::ZERO);
    let next = points.clone().cycle().skip(1);
    // Relative to the first point: far from the origin the products of coordinates would cancel.
    points.zip(next).fold(DVec3::ZERO, |sum, (a, b)| sum + (a - origin).cross(b - origin))
}

/// Cuts a polygon (n points) into n − 2 triangles of indices 0..n, which keep its orientation.
///
/// A convex polygon becomes a fan at its first corner, as in most readers. Any other is cut by ear clipping (Meisters 1975) in
/// the plane of the Newell normal, where the ear of the best shape goes first. A polygon that crosses itself may have no
/// valid ear left; it is cut all the same, and each of its corners is in a triangle.
pub fn triangulate(points: &[DVec3], mut emit: impl FnMut([usize; 3])) {
    if points.len() == 3 {
        return emit([0, 1, 2]);
    }
    let normal = newell(points.iter().copied());
    let (u, v) = normal.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
    // `any_orthonormal_pair` promises no handedness of (u, v, n); counter-clockwise must stay so.
    let v = if u.cross(v).dot(normal) < 0.0 { -v } else { v };
    let flat: Vec<DVec2> = points.iter().map(|p| *p - points[0]).map(|p| DVec2::new(p.dot(u), p.dot(v))).collect();
    if is_convex(&flat) {
        return (2..points.len()).for_each(|k| emit([0, k - 1, k]));
    }
    Remainder::new(&flat).clip(&mut emit);
}

/// Twice the signed area of a triangle, positive if counter-clockwise.
fn doubled_area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Returns true if all corners are convex and all triangles of the fan at the first corner counter-clockwise.
fn is_convex(flat: &[DVec2]) -> bool {
    let n = flat.len();
    (0..n).all(|k| doubled_area(flat[k], flat[(k + 1) % n], flat[(k + 2) % n]) > 0.0)
        && (2..n).all(|k| doubled_area(flat[0], flat[k - 1], flat[k]) > 0.0)
}

/// Number of corners that may be looked at in vain before a polygon without an ear is taken for nonsense, as a multiple of its own
/// corners and at least: it bounds the time for a polygon that crosses itself.
const VAIN: (usize, usize) = (8, 1 << 22);

/// The part of a polygon that is not cut up yet, as a ring of corners.
struct Remainder<'a> {
    flat: &'a [DVec2],
    next: Vec<usize>,
    previous: Vec<usize>,
    is_left: Vec<bool>,
    left: usize,
    /// Quality of the ear at each corner, as it was when it was computed last.
    quality: Vec<f64>,
    /// Corners by the quality of their ears, the lowest index first among equals. Entries with another quality than in `quality` are
    /// out of date.
    queue: BinaryHeap<Ear>,
    grid: Grid,
}

/// An entry of the queue.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ear {
    quality: f64,
    corner: usize,
}

impl Eq for Ear {}

impl Ord for Ear {
    fn cmp(&self, other: &Self) -> Ordering {
        self.quality.total_cmp(&other.quality).then(other.corner.cmp(&self.corner))
    }
}

impl PartialOrd for Ear {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<'a> Remainder<'a> {
    fn new(flat: &'a [DVec2]) -> Self {
        let n = flat.len();
        let mut new = Self {
            flat,
            next: (0..n).map(|k| (k + 1) % n).collect(),
            previous: (0..n).map(|k| (k + n - 1) % n).collect(),
            is_left: vec![true; n],
            left: n,
            quality: vec![0.0; n],
            queue: BinaryHeap::new(),
            grid: Grid::new(flat),
        };
        new.look_again();
        new
    }

    /// Cuts off the best ear until a triangle is left.
    fn clip(mut self, emit: &mut impl FnMut([usize; 3])) {
        let (factor, least) = VAIN;
        let mut vain = (factor * self.flat.len()).max(least);
        while self.left > 3 {
            let mut best = self.best();
            if best.quality <= 0.0 {
                // Corners that were blocked by others may have become ears; ears stay ears.
                if vain < self.left {
                    return self.fan(emit);
                }
                vain -= self.left;
                self.look_again();
                best = self.best();
            }
            let corner = best.corner;
            let [before, after] = [self.previous[corner], self.next[corner]];
            emit([before, corner, after]);
            (self.next[before], self.previous[after]) = (after, before);
            self.is_left[corner] = false;
            self.left -= 1;
            self.grid.remove(corner, self.flat);
            for neighbour in [before, after] {
                self.look_at(neighbour);
            }
        }
        self.fan(emit);
    }

    /// Cuts what is left into a fan at its lowest corner.
    fn fan(&self, emit: &mut impl FnMut([usize; 3])) {
        let Some(first) = self.is_left.iter().position(|left| *left) else { return };
        let mut corner = self.next[first];
        while self.next[corner] != first {
            emit([first, corner, self.next[corner]]);
            corner = self.next[corner];
        }
    }

    fn best(&mut self) -> Ear {
        while let Some(ear) = self.queue.peek() {
            if self.is_left[ear.corner] && self.quality[ear.corner].to_bits() == ear.quality.to_bits() {
                return *ear;
            }
            self.queue.pop();
        }
        // Every corner that is left has an entry.
        Ear { quality: -1.0, corner: self.is_left.iter().position(|left| *left).unwrap_or(0) }
    }

    fn look_again(&mut self) {
        let all: Vec<Ear> = (0..self.flat.len())
            .filter(|&k| self.is_left[k])
            .map(|corner| Ear { quality: self.ear_quality(corner), corner })
            .collect();
        all.iter().for_each(|ear| self.quality[ear.corner] = ear.quality);
        self.queue = all.into();
    }

    fn look_at(&mut self, corner: usize) {
        let quality = self.ear_quality(corner);
        self.quality[corner] = quality;
        self.queue.push(Ear { quality, corner });
    }

    /// Quality of the ear at a corner: area over the sum of squared edge lengths; negative if the corner is no ear.
    fn ear_quality(&self, corner: usize) -> f64 {
        let ear = [self.previous[corner], corner, self.next[corner]];
        let [a, b, c] = ear.map(|i| self.flat[i]);
        let area = doubled_area(a, b, c);
        if area <= 0.0 {
            return -1.0;
        }
        let inside =
            |p: DVec2| doubled_area(a, b, p) >= 0.0 && doubled_area(b, c, p) >= 0.0 && doubled_area(c, a, p) >= 0.0;
        let is_in_the_way = |i: usize| {
            let p = self.flat[i];
            !ear.contains(&i) && ![a, b, c].contains(&p) && inside(p)
        };
        if self.grid.any_in(a.min(b).min(c), a.max(b).max(c), is_in_the_way) {
            return -0.5;
        }
        area / (a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a))
    }
}

/// Corners by square cells of the plane, about one to a cell, so that only those near an ear are looked at.
struct Grid {
    low: DVec2,
    cell: f64,
    columns: usize,
    rows: usize,
    cells: Vec<Vec<usize>>,
}

impl Grid {
    fn new(flat: &[DVec2]) -> Self {
        let start = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let [low, high] = flat.iter().fold(start, |[low, high], p| [low.min(*p), high.max(*p)]);
        let extent = high - low;
        let cell = (extent.x * extent.y / flat.len() as f64).sqrt().max(extent.max_element() / flat.len() as f64);
        let count = |length: f64| if cell > 0.0 { ((length / cell) as usize + 1).min(flat.len() + 1) } else { 1 };
        let (columns, rows) = (count(extent.x), count(extent.y));
        let mut new = Self { low, cell, columns, rows, cells: vec![Vec::new(); columns * rows] };
        for (i, p) in flat.iter().enumerate() {
            let cell = new.cell_of(*p);
            new.cells[cell[1] * columns + cell[0]].push(i);
        }
        new
    }

    fn cell_of(&self, p: DVec2) -> [usize; 2] {
        // Saturating; where the cells have no size, there is one only.
        let index = |x: f64, count: usize| ((x / self.cell) as usize).min(count - 1);
        let p = p - self.low;
        [index(p.x, self.columns), index(p.y, self.rows)]
    }

    fn remove(&mut self, corner: usize, flat: &[DVec2]) {
        let [column, row] = self.cell_of(flat[corner]);
        self.cells[row * self.columns + column].retain(|&i| i != corner);
    }

    /// Returns true if a corner in the cells of a rectangle fulfils a condition.
    fn any_in(&self, low: DVec2, high: DVec2, condition: impl Fn(usize) -> bool) -> bool {
        let [low, high] = [self.cell_of(low), self.cell_of(high)];
        (low[1]..=high[1]).any(|row| {
            let cells = &self.cells[row * self.columns + low[0]..=row * self.columns + high[0]];
            cells.iter().flatten().any(|&i| condition(i))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(outline: &[[f64; 2]]) -> Vec<[usize; 3]> {
        let lifted: Vec<_> = outline.iter().map(|p| DVec3::new(p[0], 5.0, -p[1])).collect();
        let mut out = Vec::new();
        triangulate(&lifted, |t| out.push(t));
        out
    }

    fn signed_areas(outline: &[[f64; 2]]) -> Vec<f64> {
        let at = |i: usize| DVec2::from(outline[i]);
        triangles(outline).iter().map(|&[a, b, c]| doubled_area(at(a), at(b), at(c)) / 2.0).collect()
    }

    #[test]
    fn a_convex_polygon_is_fanned() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(triangles(&square), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn a_concave_polygon_is_covered_once() {
        // The fan at the first corner would leave the polygon.
        let dart = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [1.5, 1.0]];
        let comb = [
            [0.0, 0.0],
            [7.0, 0.0],
            [7.0, 4.0],
            [6.0, 4.0],
            [6.0, 1.0],
            [4.0, 1.0],
            [4.0, 4.0],
            [3.0, 4.0],
            [3.0, 1.0],
            [1.0, 1.0],
            [1.0, 4.0],
            [0.0, 4.0],
        ];
        for (outline, area) in [(&dart[..], 0.5), (&comb[..], 16.0)] {
            let areas = signed_areas(outline);
            assert_eq!(areas.len(), outline.len() - 2);
            assert!(areas.iter().all(|a| *a > 0.0), "{areas:?}");
            assert!((areas.iter().sum::<f64>() - area).abs() < 1e-12);
        }
    }

    #[test]
    fn corners_on_a_straight_edge_keep_their_triangle() {
        let edge = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let used: std::collections::BTreeSet<_> = triangles(&edge).into_iter().flatten().collect();
        assert_eq!(used.len(), 5);
        assert!(signed_areas(&edge).iter().all(|a| *a > 0.0));
    }

    /// The same cut, looking at every corner each time.
    fn slow(flat: &[DVec2]) -> Vec<[usize; 3]> {
        let ear_at = |rest: &[usize], k: usize| {
            let n = rest.len();
            [rest[(k + n - 1) % n], rest[k], rest[(k + 1) % n]]
        };
        let quality = |rest: &[usize], k: usize| {
            let ear = ear_at(rest, k);
            let [a, b, c] = ear.map(|i| flat[i]);
            let inside =
                |p: DVec2| doubled_area(a, b, p) >= 0.0 && doubled_area(b, c, p) >= 0.0 && doubled_area(c, a, p) >= 0.0;
            let in_the_way = |i: &usize| !ear.contains(i) && ![a, b, c].contains(&flat[*i]) && inside(flat[*i]);
            match doubled_area(a, b, c) {
                area if area <= 0.0 => -1.0,
                _ if rest.iter().any(in_the_way) => -0.5,
                area => area / (a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a)),
            }
        };
        let mut rest: Vec<usize> = (0..flat.len()).collect();
        let mut known: Vec<f64> = (0..rest.len()).map(|k| quality(&rest, k)).collect();
        let best = |known: &[f64]| (0..known.len()).rev().max_by(|&j, &k| known[j].total_cmp(&known[k])).unwrap();
        let mut out = Vec::new();
        while rest.len() > 3 {
            let mut k = best(&known);
            if known[k] <= 0.0 {
                known = (0..rest.len()).map(|k| quality(&rest, k)).collect();
                k = best(&known);
            }
            out.push(ear_at(&rest, k));
            rest.remove(k);
            known.remove(k);
            for j in [(k + rest.len() - 1) % rest.len(), k % rest.len()] {
                known[j] = quality(&rest, j);
            }
        }
        out.push([rest[0], rest[1], rest[2]]);
        out
    }

    /// A star with corners at random radii; with `cross` some of them change places, so that it crosses itself.
    fn star(n: u32, cross: bool) -> Vec<[f64; 2]> {
        let random = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 8 & 0xffff) / 65535.0;
        let corner = |i: u32| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            let r = 1.0 + 0.6 * random(i + n);
            [r * angle.cos(), r * angle.sin()]
        };
        let mut star: Vec<_> = (0..n).map(corner).collect();
        if cross {
            (0..n / 8).for_each(|i| star.swap((random(i) * f64::from(n - 1)) as usize, i as usize));
        }
        star
    }

    #[test]
    fn the_cut_is_that_of_looking_at_every_corner() {
        for n in [4, 5, 9, 40, 177] {
            for cross in [false, true] {
                let star = star(n, cross);
                let flat: Vec<DVec2> = star.iter().map(|p| DVec2::from(*p)).collect();
                let mut fast = Vec::new();
                Remainder::new(&flat).clip(&mut |t| fast.push(t));
                assert_eq!(fast, slow(&flat), "{n} {cross}");
            }
        }
    }

    #[test]
    fn a_polygon_of_very_many_corners_is_cut_up_whatever_it_is() {
        // Looking at every corner for every ear would take minutes.
        for cross in [false, true] {
            let star = star(200_000, cross);
            let cut = triangles(&star);
            assert_eq!(cut.len(), star.len() - 2);
            let mut used = vec![false; star.len()];
            cut.iter().flatten().for_each(|&i| used[i] = true);
            assert!(used.iter().all(|used| *used));
        }
        let same = vec![[1.0, 2.0]; 100_000];
        assert_eq!(triangles(&same).len(), same.len() - 2);
    }

    #[test]
    fn nonsense_is_cut_up_too() {
        let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(triangles(&bow).len(), 2);
        assert_eq!(triangles(&[[0.0, 0.0]; 6]).len(), 4);
    }
}
