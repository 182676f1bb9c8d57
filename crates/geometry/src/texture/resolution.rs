//! How fine a map must be for a layout, and where a layout is too crowded for any.

use super::{HeightMap, Size};
use crate::atlas::{self, Atlas};
use crate::displacement::Bits;
use crate::progress::{Cancelled, Progress};
use crate::ragged::Index;
use glam::DVec2;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;
use std::num::NonZero;

/// Bilinear sampling reads two by two texels. Vertices that are not this many texels apart share some of them, and
/// then a map cannot give each its own height.
pub const TEXELS_APART: f64 = 2.0;

/// Share of the vertices that a size chosen automatically has to resolve.
pub const RESOLVED_SHARE: f64 = 0.99;

/// Smallest and largest size that is chosen automatically.
pub const AUTOMATIC: std::ops::RangeInclusive<u32> = 64..=4096;

/// Distances between the places at which vertices are sampled.
#[derive(Clone, Debug)]
pub struct Spacing {
    /// To the nearest other vertex's place, in units of the texture's side; ascending. One for each vertex with a place.
    distances: Vec<f64>,
}

impl Spacing {
    /// Measures the dominant uv vertices of a layout.
    pub fn new(atlas: &Atlas) -> Self {
        let vertices = 0..atlas.wedges().len() as Index;
        let places: Vec<[f64; 2]> =
            vertices.filter_map(|v| atlas.dominant(v)).map(|uv| atlas.uvs()[uv as usize].to_array()).collect();
        let Ok(tree) = ImmutableKdTree::<f64, 2>::new_from_slice(&places) else {
            return Self { distances: Vec::new() };
        };
        const TWO: NonZero<usize> = NonZero::new(2).expect("two is not zero");
        // The nearest one is the place itself, or a twin at distance zero; either way the second is the answer.
        let second = |p: &[f64; 2]| {
            tree.query(p).nearest_n::<SquaredEuclidean<f64>>(TWO).execute().get(1).map(|n| n.distance.sqrt())
        };
        let mut distances: Vec<f64> = places.par_iter().map(|p| second(p).unwrap_or(f64::INFINITY)).collect();
        distances.sort_unstable_by(f64::total_cmp);
        Self { distances }
    }
    /// Vertices that are nearer than [`TEXELS_APART`] to another one in a square map.
    pub fn crowded(&self, side: u32) -> usize {
        self.distances.partition_point(|d| d * f64::from(side) < TEXELS_APART)
    }
    /// The smallest distance in a square map, texels.
    pub fn smallest(&self, side: u32) -> f64 {
        self.distances.first().map_or(f64::INFINITY, |d| d * f64::from(side))
    }
    /// The smallest power of two in [`AUTOMATIC`] at which all but 1 % of the vertices are far enough apart, or the
    /// largest one where none is enough.
    pub fn choose(&self) -> Choice {
        let allowed = (self.distances.len() as f64 * (1.0 - RESOLVED_SHARE)).floor() as usize;
        let enough = sizes().find(|&size| self.crowded(size) <= allowed);
        let side = enough.unwrap_or(*AUTOMATIC.end());
        let reason = if enough.is_some() { Reason::Spaced } else { Reason::Crowded };
        Choice { side, vertices: self.distances.len(), left: self.crowded(side), reason }
    }
    /// The smallest power of two in [`AUTOMATIC`] at which a fitted map gives each vertex its height (#V, model units);
    /// where there is none, as [`Self::choose`].
    pub fn choose_exact(
        &self,
        atlas: &Atlas,
        heights: &[f64],
        bits: Bits,
        progress: &dyn Progress,
    ) -> Result<Choice, Cancelled> {
        let spaced = self.choose();
        if spaced.reason == Reason::Crowded {
            return Ok(spaced);
        }
        let mut left = Vec::new();
        for side in sizes().filter(|&size| size >= spaced.side) {
            // What lies between the samples does not matter for whether they can be met.
            let size = Size::square(side);
            let mut flat = HeightMap { size, texels: vec![0.0; size.texels()] };
            left.push(super::fit(&mut flat, atlas, heights, bits, progress)?);
            if left.last() == Some(&0) {
                return Ok(Choice { side, left: 0, reason: Reason::Exact, ..spaced });
            }
        }
        Ok(Choice { left: left[0], reason: Reason::AlmostExact, ..spaced })
    }
}

fn sizes() -> impl Iterator<Item = u32> {
    (0..32).map(|e| 1u32 << e).filter(|size| AUTOMATIC.contains(size))
}

/// A size and the reason for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Texels on a side.
    pub side: u32,
    /// Vertices that have a place in the texture.
    pub vertices: usize,
    /// Vertices for which it is not enough.
    pub left: usize,
    /// Why.
    pub reason: Reason,
}

/// Why a size was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The smallest at which each vertex gets its height.
    Exact,
    /// The smallest at which 99 % of the vertices are far enough apart; no size gives each its height.
    AlmostExact,
    /// The smallest at which 99 % of the vertices are far enough apart.
    Spaced,
    /// The largest: at none are they.
    Crowded,
}

impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { side, vertices, left, reason } = self;
        let (apart, largest) = (vertices - left, AUTOMATIC.end());
        match reason {
            Reason::Exact => write!(f, "{side} is the smallest power of two at which each vertex gets its height"),
            Reason::AlmostExact => {
                write!(
                    f,
                    "{side} gives all but {left} of {vertices} vertices their height; up to {largest} no size gives it to all"
                )
            }
            Reason::Spaced => {
                write!(
                    f,
                    "{side} is the smallest power of two at which 99 % of the vertices are two texels apart ({apart} of {vertices})"
                )
            }
            Reason::Crowded => {
                write!(
                    f,
                    "{side} is the largest size tried, and yet only {apart} of {vertices} vertices are two texels apart: the layout is crowded"
                )
            }
        }
    }
}

/// Vertices whose sampling place lies outside the unit square, where a map that does not repeat has nothing.
pub fn out_of_range(atlas: &Atlas) -> usize {
    let place = |v| atlas.dominant(v).map(|uv| atlas.uvs()[uv as usize]);
    let outside = |uv: DVec2| !atlas::in_unit_square(uv);
    (0..atlas.wedges().len() as Index).filter_map(place).filter(|uv| outside(*uv)).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use crate::shapes;
    use glam::DVec2;

    fn flat(cells: u32) -> Spacing {
        let grid = shapes::grid(cells);
        let corners = 0..grid.topology().faces().items().len() as Index;
        let uvs: Vec<_> = grid.positions().iter().map(|p| p.truncate()).collect();
        Spacing::new(&Atlas::new(&grid, &uvs, corners.map(|c| Some(grid.topology().vertex(c)))).unwrap())
    }

    #[test]
    fn a_regular_layout_needs_two_texels_an_edge() {
        let choice = flat(100).choose();
        assert_eq!((choice.side, choice.left, choice.reason), (256, 0, Reason::Spaced));
        assert!((flat(100).smallest(256) - 2.56).abs() < 1e-9);
    }

    #[test]
    fn one_pair_that_is_too_near_asks_for_a_larger_map() {
        let grid = shapes::grid(20);
        let corners = 0..grid.topology().faces().items().len() as Index;
        let mut uvs: Vec<_> = grid.positions().iter().map(|p| p.truncate()).collect();
        // A two-hundredth of the side: a third of a texel at 64, and of different heights.
        uvs[50] = uvs[51] - DVec2::new(0.005, 0.0);
        let atlas = Atlas::new(&grid, &uvs, corners.map(|c| Some(grid.topology().vertex(c)))).unwrap();
        let heights: Vec<f64> = (0..21 * 21).map(|v| f64::from(v == 50)).collect();
        let spacing = Spacing::new(&atlas);
        assert_eq!(spacing.choose().side, 64);
        let choice = spacing.choose_exact(&atlas, &heights, Bits::Sixteen, &Silent).unwrap();
        assert!(choice.side > 64 && choice.reason == Reason::Exact, "{choice}");
    }

    #[test]
    fn a_crowd_is_named() {
        let grid = shapes::grid(40);
        let corners = 0..grid.topology().faces().items().len() as Index;
        let uvs: Vec<_> = grid.positions().iter().map(|p| p.truncate() * 1e-5).collect();
        let atlas = Atlas::new(&grid, &uvs, corners.map(|c| Some(grid.topology().vertex(c)))).unwrap();
        let choice = Spacing::new(&atlas).choose();
        assert_eq!((choice.side, choice.left, choice.reason), (4096, 41 * 41, Reason::Crowded));
    }
}
