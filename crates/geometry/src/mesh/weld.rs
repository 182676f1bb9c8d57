//! Welding: merges source vertices at the same position. Exporters split a vertex at UV seams, and denoising must not see
//! such a cut.
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::mesh::weld::{Weld, Welding};
//!
//! let positions = [DVec3::X, DVec3::Y, DVec3::X, DVec3::Y + 1e-6];
//! assert_eq!(Weld::new(&positions, Welding::Exact).vertex_of(), [0, 1, 0, 2]);
//! let weld = Weld::new(&positions, Welding::Epsilon(1e-5));
//! assert_eq!(weld.vertex_of(), [0, 1, 0, 1]);
//! assert_eq!(weld.spread(&["a", "b"]), ["a", "b", "a", "b"]);
//! ```

use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::union_find::UnionFind;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Rule by which two source vertices become one vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Welding {
    /// Source vertices with equal coordinates become one (−0 equals 0).
    #[default]
    Exact,
    /// Source vertices at most this far apart (model units) become one, transitively.
    Epsilon(f64),
    /// Source vertices stay apart.
    None,
}

/// Result of welding: the vertex that each source vertex became.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Weld {
    vertex_of: Vec<Index>,
    first: Vec<Index>,
}

impl Weld {
    /// Welds positions (#v×3, model units). Vertices are numbered in the order of their first source vertices.
    pub fn new(positions: &[DVec3], welding: Welding) -> Self {
        match welding {
            Welding::None => Self::from_representatives((0..positions.len() as Index).collect()),
            Welding::Exact => Self::from_representatives(first_equals(positions)),
            Welding::Epsilon(epsilon) => Self::from_representatives(merge_within(positions, epsilon)),
        }
    }

    /// Numbers the vertices; `representatives[i]` ≤ i is the first source vertex that is welded to source vertex i.
    fn from_representatives(representatives: Vec<Index>) -> Self {
        let mut first = Vec::new();
        let mut vertex_of = representatives;
        for i in 0..vertex_of.len() {
            vertex_of[i] = if vertex_of[i] as usize == i {
                first.push(i as Index);
                first.len() as Index - 1
            } else {
                vertex_of[vertex_of[i] as usize]
            };
        }
        Self { vertex_of, first }
    }

    /// Returns this welding with some source vertices (true in `is_apart`, #v) welded to one another only.
    #[must_use]
    pub fn split(&self, is_apart: &[bool]) -> Self {
        let mut first = vec![[Index::MAX; 2]; self.first.len()];
        let representative = |(i, (v, is_apart)): (Index, (&Index, &bool))| {
            let first = &mut first[*v as usize][usize::from(*is_apart)];
            *first = (*first).min(i);
            *first
        };
        Self::from_representatives((0..).zip(self.vertex_of.iter().zip(is_apart)).map(representative).collect())
    }
    /// Vertex that each source vertex became. #v
    pub fn vertex_of(&self) -> &[Index] {
        &self.vertex_of
    }
    /// First source vertex of each vertex, whose position the vertex has. #V
    pub fn first(&self) -> &[Index] {
        &self.first
    }
    /// Returns true if every source vertex is a vertex of its own.
    pub fn is_identity(&self) -> bool {
        self.first.len() == self.vertex_of.len()
    }
    /// Gives each source vertex (#v) the value of its vertex (#V), as [`Self::spread`] does, without a copy where these are the same.
    pub fn spread_from<'a, T: Copy>(&self, vertex_values: &'a [T]) -> Cow<'a, [T]> {
        if self.is_identity() { vertex_values.into() } else { self.spread(vertex_values).into() }
    }
    /// Gives each source vertex (#v) the value of its vertex (#V).
    pub fn spread<T: Copy>(&self, vertex_values: &[T]) -> Vec<T> {
        self.vertex_of.iter().map(|&v| vertex_values[v as usize]).collect()
    }
}

/// Bits of a position, with −0 replaced by 0.
fn exact_key(p: DVec3) -> [u64; 3] {
    (p + 0.0).to_array().map(f64::to_bits)
}

/// Number of tables of [`first_equals`], a power of two. Equal positions are in the same table.
const TABLES: usize = 64;
/// Number of positions that are dealt out to the tables at a time.
const DEALT: usize = 1 << 16;

/// Index of the first position that is equal to each.
fn first_equals(positions: &[DVec3]) -> Vec<Index> {
    let chunks = positions.par_chunks(DEALT).enumerate();
    let hashes: Vec<Ragged<(u32, Index)>> = chunks
        .map(|(chunk, positions)| {
            let first = (chunk * DEALT) as Index;
            let hashes: Vec<u64> = positions.iter().map(|p| hash(*p)).collect();
            let dealt =
                (first..).zip(&hashes).map(|(i, hash)| (*hash as Index % TABLES as Index, (table_hash(*hash), i)));
            Ragged::group(TABLES, dealt)
        })
        .collect();
    let later = (0..TABLES as Index).into_par_iter().map(|table| later_equals(positions, &hashes, table));
    let mut firsts: Vec<Index> = (0..positions.len() as Index).collect();
    for (later, first) in later.collect::<Vec<_>>().into_iter().flatten() {
        firsts[later as usize] = first;
    }
    firsts
}

/// Positions of one table that are equal to an earlier one, each with the first such.
fn later_equals(positions: &[DVec3], hashes: &[Ragged<(u32, Index)>], table: Index) -> Vec<(Index, Index)> {
    const FREE: Index = Index::MAX;
    let dealt = hashes.iter().flat_map(|hashes| hashes.get(table));
    let count: usize = hashes.iter().map(|hashes| hashes.get(table).len()).sum();
    let size = (2 * count + 1).next_power_of_two();
    let mut slots = vec![(0, FREE); size];
    let mut later = Vec::new();
    for &(hash, i) in dealt {
        let key = exact_key(positions[i as usize]);
        let is_same = |slot: &(u32, Index)| slot.0 == hash && exact_key(positions[slot.1 as usize]) == key;
        let mut at = hash as usize % size;
        while slots[at].1 != FREE && !is_same(&slots[at]) {
            at = (at + 1) % size;
        }
        match slots[at].1 {
            FREE => slots[at] = (hash, i),
            first => later.push((i, first)),
        }
    }
    later
}

/// Hash of a position; equal positions have the same.
fn hash(p: DVec3) -> u64 {
    let mixed = exact_key(p).into_iter().fold(0u64, |hash, bits| {
        let mixed = (hash.rotate_left(26) ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ (mixed >> 32)
    });
    mixed.wrapping_mul(0xff51_afd7_ed55_8ccd).rotate_left(32)
}

/// Bits of a hash that do not say which table it is in.
fn table_hash(hash: u64) -> u32 {
    (hash / TABLES as u64) as u32
}

/// Lowest index of the cluster of each position, where positions at most `epsilon` apart are joined.
fn merge_within(positions: &[DVec3], epsilon: f64) -> Vec<Index> {
    let mut sets = UnionFind::new(positions.len());
    let cell_of = |p: DVec3| (p / epsilon).floor().to_array().map(|x| x as i64);
    let mut cells: FxHashMap<[i64; 3], Vec<Index>> = FxHashMap::default();
    for (i, &p) in (0..).zip(positions) {
        let [x, y, z] = cell_of(p);
        for (dx, dy, dz) in neighbourhood() {
            let near = [x.saturating_add(dx), y.saturating_add(dy), z.saturating_add(dz)];
            for &j in cells.get(&near).map_or(&[][..], Vec::as_slice) {
                if positions[j as usize].distance(p) <= epsilon {
                    sets.join(i, j);
                }
            }
        }
        cells.entry([x, y, z]).or_default().push(i);
    }
    sets.into_lowest()
}

/// Offsets of the 27 cells that can hold a point within one cell size.
fn neighbourhood() -> impl Iterator<Item = (i64, i64, i64)> {
    (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| (x, y, z))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_has_no_sign() {
        let weld = Weld::new(&[DVec3::ZERO, -DVec3::ZERO, DVec3::X], Welding::Exact);
        assert_eq!(weld.vertex_of(), [0, 0, 1]);
        assert_eq!(weld.first(), [0, 2]);
    }

    #[test]
    fn epsilon_is_transitive_and_numbers_by_first_use() {
        let line: Vec<_> = [5.0, 0.0, 0.9, 1.8, 5.0, 2.9].map(|x| DVec3::X * x).to_vec();
        let weld = Weld::new(&line, Welding::Epsilon(1.0));
        assert_eq!(weld.vertex_of(), [0, 1, 1, 1, 0, 2]);
        assert_eq!(weld.spread(&['a', 'b', 'c']), ['a', 'b', 'b', 'b', 'a', 'c']);
    }

    #[test]
    fn a_cloud_of_many_twins_is_welded_as_a_hash_map_says() {
        // Coordinates of few bits, as scanners write them, in more than one chunk, with positions that repeat far apart.
        let count = DEALT + DEALT / 2;
        let at = |i: usize| DVec3::new((i % 151) as f64, (i % 83) as f64 / 8.0, -((i % 7) as f64)) * 0.5;
        let positions: Vec<DVec3> = (0..count).map(at).collect();
        let mut seen = FxHashMap::default();
        let expected: Vec<Index> =
            (0..).zip(&positions).map(|(i, p)| *seen.entry(exact_key(*p)).or_insert(i)).collect();
        assert!(seen.len() > 10_000 && seen.len() < count);
        assert_eq!(first_equals(&positions), expected);
    }

    #[test]
    fn split_vertices_are_welded_on_each_side() {
        let weld = Weld::new(&[DVec3::X, DVec3::Y, DVec3::X, DVec3::X, DVec3::X], Welding::Exact);
        let split = weld.split(&[false, false, true, false, true]);
        assert_eq!((split.vertex_of(), split.first()), (&[0, 1, 2, 0, 2][..], &[0, 1, 2][..]));
    }

    #[test]
    fn no_welding_keeps_twins_apart() {
        assert_eq!(Weld::new(&[DVec3::ZERO; 3], Welding::None).vertex_of(), [0, 1, 2]);
    }
}
