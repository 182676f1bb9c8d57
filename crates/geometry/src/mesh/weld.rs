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

use crate::mesh::jagged::Index;
use crate::mesh::union_find::UnionFind;
use glam::DVec3;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

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
            Welding::Exact => {
                let mut seen = FxHashMap::default();
                seen.reserve(positions.len());
                let first_equal = |(i, p): (Index, &DVec3)| *seen.entry(exact_key(*p)).or_insert(i);
                Self::from_representatives((0..).zip(positions).map(first_equal).collect())
            }
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

    /// Vertex that each source vertex became. #v
    pub fn vertex_of(&self) -> &[Index] {
        &self.vertex_of
    }
    /// First source vertex of each vertex, whose position the vertex has. #V
    pub fn first(&self) -> &[Index] {
        &self.first
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
    fn no_welding_keeps_twins_apart() {
        assert_eq!(Weld::new(&[DVec3::ZERO; 3], Welding::None).vertex_of(), [0, 1, 2]);
    }
}
