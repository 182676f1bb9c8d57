//! Lists of what is around a point, which are as long as they need to be and no longer.
//!
//! A mesh may have a vertex with a hundred thousand faces, or so many slivers that as many lie within a radius. Filters average over
//! the faces around each face, and would do so for each of these faces: with the square of their number. The nearest ones say as much.

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::nearest::NearestPoints;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

pub(super) use crate::mesh::nearest::Found;

/// Number of items up to which a list counts as a whole: ten times the six triangles around a vertex of an even mesh.
pub(super) const MOST_IN_LIST: usize = 64;

/// Lists of items, each of which has a point. Of a long list those items that are nearest to a point can be had.
pub(super) struct NearLists<'a> {
    lists: &'a Ragged<Index>,
    /// Points of the items. #P×3
    points: &'a [DVec3],
    /// Index of each long list among `trees`, ascending by list.
    long: Vec<Index>,
    trees: Vec<NearestPoints>,
}

impl<'a> NearLists<'a> {
    pub(super) fn new(lists: &'a Ragged<Index>, points: &'a [DVec3]) -> Self {
        let is_long = |list: &Index| lists.range(*list).len() > MOST_IN_LIST;
        let long: Vec<Index> = (0..lists.len() as Index).filter(is_long).collect();
        let tree =
            |list: &Index| NearestPoints::new(lists.get(*list).iter().map(|&item| (points[item as usize], item)));
        let trees = long.par_iter().map(tree).collect();
        Self { lists, points, long, trees }
    }

    /// Calls `visit` with the items of a list, or with those nearest to `centre` if there are many. `heap` is scratch memory.
    pub(super) fn visit(&self, list: Index, centre: DVec3, heap: &mut BinaryHeap<Found>, mut visit: impl FnMut(Index)) {
        if self.lists.range(list).len() <= MOST_IN_LIST {
            return self.lists.get(list).iter().for_each(|&item| visit(item));
        }
        if let Ok(k) = self.long.binary_search(&list) {
            self.trees[k].nearest(centre, MOST_IN_LIST, heap);
            heap.iter().for_each(|found| visit(found.item));
        }
    }
}

/// Appends to an empty `list` the `seed` and whatever is reached from it over neighbours that are `inside`, breadth first. Gives up
/// and returns false as soon as that becomes more than `most` items, or if it takes too many looks.
pub(super) fn flood_fill<'a>(
    seed: Index,
    list: &mut Vec<Index>,
    most: usize,
    neighbours: impl Fn(Index) -> &'a [Index],
    inside: impl Fn(Index) -> bool,
) -> bool {
    // Short lists are the rule, and for them a linear search is the fastest; the set is for the others.
    const SHORT: usize = 48;
    // Looks at neighbours for each item that is wanted. Meshes of one piece need 12.
    const LOOKS: usize = 64;
    let mut seen = FxHashSet::default();
    list.push(seed);
    let (mut next, mut looks) = (0, 0);
    while next < list.len() {
        let around = neighbours(list[next]);
        looks += around.len();
        if looks > LOOKS * most {
            return false;
        }
        for &candidate in around {
            if !inside(candidate) {
                continue;
            }
            if list.len() == SHORT && seen.is_empty() {
                seen.extend(list.iter().copied());
            }
            let fresh = if seen.is_empty() { !list.contains(&candidate) } else { seen.insert(candidate) };
            if fresh {
                list.push(candidate);
            }
        }
        if list.len() > most {
            return false;
        }
        next += 1;
    }
    true
}

/// Room for [`fill_nearest`].
#[derive(Default)]
pub(super) struct Room {
    near: BinaryHeap<Found>,
    queue: BinaryHeap<Reverse<Found>>,
    seen: FxHashSet<Index>,
    used: FxHashSet<Index>,
}

/// Puts into `list` the `seed` and the items nearest to it that are reached from it over items that are `inside`, `most` in all. Item i
/// reaches all in the lists `lists_of(i)`. Items come by their distance, and for equal ones by their number.
pub(super) fn fill_nearest<const N: usize>(
    seed: Index,
    list: &mut Vec<Index>,
    most: usize,
    near: &NearLists,
    lists_of: impl Fn(Index) -> [Index; N],
    inside: impl Fn(Index) -> bool,
    room: &mut Room,
) {
    let Room { near: heap, queue, seen, used } = room;
    seen.clear();
    used.clear();
    queue.clear();
    list.clear();
    let centre = near.points[seed as usize];
    seen.insert(seed);
    queue.push(Reverse(Found { squared: 0.0, item: seed }));
    while let Some(Reverse(Found { item, .. })) = queue.pop() {
        list.push(item);
        if list.len() == most {
            break;
        }
        for lists in lists_of(item) {
            // What a list has to give is the same whoever asks.
            if used.insert(lists) {
                near.visit(lists, centre, heap, |other| {
                    if inside(other) && seen.insert(other) {
                        let squared = near.points[other as usize].distance_squared(centre);
                        queue.push(Reverse(Found { squared, item: other }));
                    }
                });
            }
        }
    }
}
