//! How fine a map must be for a layout, and where a layout is too crowded for any.

use crate::atlas::{self, Atlas};
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
        let sizes = (0..32).map(|e| 1u32 << e).filter(|size| AUTOMATIC.contains(size));
        let allowed = (self.distances.len() as f64 * (1.0 - RESOLVED_SHARE)).floor() as usize;
        let enough = sizes.clone().find(|&size| self.crowded(size) <= allowed);
        let side = enough.or(sizes.max()).unwrap_or(*AUTOMATIC.end());
        Choice { side, crowded: self.crowded(side), vertices: self.distances.len(), resolved: enough.is_some() }
    }
}

/// A size and the reason for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Texels on a side.
    pub side: u32,
    /// Vertices that are too near to another one even so.
    pub crowded: usize,
    /// Vertices that have a place in the texture.
    pub vertices: usize,
    /// Whether the size is enough; otherwise it is the largest allowed.
    pub resolved: bool,
}

impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { side, crowded, vertices, resolved } = self;
        let apart = vertices - crowded;
        if *resolved {
            write!(
                f,
                "{side} is the smallest power of two at which 99 % of the vertices are two texels apart ({apart} of {vertices})"
            )
        } else {
            write!(
                f,
                "{side} is the largest size tried, and yet only {apart} of {vertices} vertices are two texels apart: the layout is crowded"
            )
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
    use crate::shapes;

    fn flat(cells: u32) -> Spacing {
        let grid = shapes::grid(cells);
        let corners = 0..grid.topology().faces().items().len() as Index;
        let uvs: Vec<_> = grid.positions().iter().map(|p| p.truncate()).collect();
        Spacing::new(&Atlas::new(&grid, &uvs, corners.map(|c| Some(grid.topology().vertex(c)))).unwrap())
    }

    #[test]
    fn a_regular_layout_needs_two_texels_an_edge() {
        let choice = flat(100).choose();
        assert_eq!((choice.side, choice.crowded, choice.resolved), (256, 0, true));
        assert!((flat(100).smallest(256) - 2.56).abs() < 1e-9);
    }

    #[test]
    fn a_crowd_is_named() {
        let grid = shapes::grid(40);
        let corners = 0..grid.topology().faces().items().len() as Index;
        let uvs: Vec<_> = grid.positions().iter().map(|p| p.truncate() * 1e-5).collect();
        let atlas = Atlas::new(&grid, &uvs, corners.map(|c| Some(grid.topology().vertex(c)))).unwrap();
        let choice = Spacing::new(&atlas).choose();
        assert_eq!((choice.side, choice.crowded, choice.resolved), (4096, 41 * 41, false));
    }
}
