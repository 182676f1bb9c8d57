//! Nearest points of a set, in a k-d tree that cannot degenerate: many points at one place, or on one line, are searched as fast as
//! any others.

use super::jagged::Index;
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Points with a number each. The tree is implicit: the middle of a range of `points` divides it, along the axis at its place.
pub(crate) struct NearestPoints {
    points: Vec<(DVec3, Index)>,
    axes: Vec<u8>,
}

/// Number of points that are looked at one by one.
const LEAF: usize = 8;

/// A point that was found: its squared distance and number.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Found {
    pub(crate) squared: f64,
    pub(crate) item: Index,
}

impl Eq for Found {}

impl Ord for Found {
    fn cmp(&self, other: &Self) -> Ordering {
        self.squared.total_cmp(&other.squared).then(self.item.cmp(&other.item))
    }
}

impl PartialOrd for Found {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl NearestPoints {
    pub(crate) fn new(points: impl Iterator<Item = (DVec3, Index)>) -> Self {
        let mut points: Vec<_> = points.collect();
        let mut axes = vec![0; points.len()];
        divide(&mut points, &mut axes);
        Self { points, axes }
    }

    /// Puts the `count` points that are nearest to `centre` into `found`, which is emptied before, in no certain order. Which ones of
    /// equally near points are taken depends on the set and on `centre` alone. Returns the number of points that were looked at.
    pub(crate) fn nearest(&self, centre: DVec3, count: usize, found: &mut BinaryHeap<Found>) -> usize {
        found.clear();
        if count == 0 { 0 } else { self.search(0..self.points.len(), centre, count, found) }
    }

    fn search(
        &self,
        range: std::ops::Range<usize>,
        centre: DVec3,
        count: usize,
        found: &mut BinaryHeap<Found>,
    ) -> usize {
        if range.len() <= LEAF {
            for &(p, item) in &self.points[range.clone()] {
                offer(Found { squared: p.distance_squared(centre), item }, count, found);
            }
            return range.len();
        }
        let middle = range.start + range.len() / 2;
        let (p, item) = self.points[middle];
        let axis = usize::from(self.axes[middle]);
        let beyond = centre[axis] - p[axis];
        let [low, high] = [range.start..middle, middle + 1..range.end];
        let (near, far) = if beyond < 0.0 { (low, high) } else { (high, low) };
        let mut looked = 1 + self.search(near, centre, count, found);
        offer(Found { squared: p.distance_squared(centre), item }, count, found);
        // Points as far as the farthest one found would not be better, which bounds the search where all are at one place.
        let is_worth = found.len() < count || found.peek().is_some_and(|farthest| beyond * beyond < farthest.squared);
        if is_worth {
            looked += self.search(far, centre, count, found);
        }
        looked
    }
}

/// Takes a point if it is among the nearest ones so far.
fn offer(point: Found, count: usize, found: &mut BinaryHeap<Found>) {
    if found.len() < count {
        found.push(point);
    } else if let Some(mut farthest) = found.peek_mut()
        && point < *farthest
    {
        *farthest = point;
    }
}

/// Divides points at the median along the axis in which they are widest apart, and the halves again.
fn divide(points: &mut [(DVec3, Index)], axes: &mut [u8]) {
    if points.len() <= LEAF {
        return;
    }
    let bounds = |pick: fn(DVec3, DVec3) -> DVec3| points.iter().map(|p| p.0).reduce(pick).unwrap_or_default();
    let size = bounds(DVec3::max) - bounds(DVec3::min);
    let axis = (0..3).fold(0, |widest, k| if size[k] > size[widest] { k } else { widest });
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    axes[middle] = axis as u8;
    let (low, high) = points.split_at_mut(middle);
    let (low_axes, high_axes) = axes.split_at_mut(middle);
    divide(low, low_axes);
    divide(&mut high[1..], &mut high_axes[1..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(points: &[DVec3], centre: DVec3, count: usize) -> (Vec<Found>, usize) {
        let tree = NearestPoints::new(points.iter().copied().zip(0..));
        let mut heap = BinaryHeap::new();
        let looked = tree.nearest(centre, count, &mut heap);
        (heap.into_sorted_vec(), looked)
    }

    #[test]
    fn the_nearest_points_are_those_of_a_search_through_all() {
        let scattered = |k: u32| DVec3::from_array([1, 2, 3].map(|m| f64::from(k * k % 1013 * m * 7919 % 1013)));
        let points: Vec<DVec3> = (0..500).map(scattered).collect();
        for count in [0, 1, 7, 64, 499, 500, 501] {
            let centre = DVec3::new(300.5, 200.25, 700.125);
            let mut all: Vec<Found> =
                (0..).zip(&points).map(|(item, p)| Found { squared: p.distance_squared(centre), item }).collect();
            all.sort_unstable();
            all.truncate(count);
            let distances = |list: &[Found]| list.iter().map(|f| f.squared).collect::<Vec<_>>();
            assert_eq!(distances(&found(&points, centre, count).0), distances(&all), "{count}");
        }
    }

    #[test]
    fn points_at_one_place_or_on_a_line_take_no_more_looks_than_others() {
        let count = 20_000;
        let place = found(&vec![DVec3::ONE; count], DVec3::ONE, 16);
        let line: Vec<DVec3> = (0..count).map(|k| DVec3::X * k as f64).collect();
        let line = found(&line, DVec3::X * 777.0, 16);
        assert_eq!((place.0.len(), line.0.len()), (16, 16));
        assert!(place.1 < 400 && line.1 < 400, "{} {}", place.1, line.1);
    }
}
