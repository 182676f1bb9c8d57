//! Choice of the size of a map: how fine it must be for a layout, and whether the layout is too crowded for any size.
//!
//! ```
//! use glam::DVec2;
//! use planish_geometry::map::map_size::{self, MapSizeReason, Spacing};
//! use planish_geometry::mesh::{atlas::{Atlas, AtlasError}, shapes};
//!
//! // Vertices are a hundredth of the texture apart, so 128 texels are too few for two texels between them, and 256 are enough.
//! let sheet = shapes::grid(100);
//! let uvs: Vec<DVec2> = sheet.positions().iter().map(|p| p.truncate()).collect();
//! let atlas = Atlas::new(&sheet, &uvs, sheet.topology().faces().items().iter().map(|&v| Some(v)))?;
//! let choice = Spacing::new(&atlas).choose(&map_size::sides(map_size::LARGEST_SIDE));
//! assert_eq!((choice.side, choice.reason), (256, MapSizeReason::Spaced));
//! # Ok::<(), AtlasError>(())
//! ```

use super::fit::UnmetSamples;
use super::{Exactness, HeightMap, Size};
use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::Index;
use crate::progress::{Cancelled, Progress};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;
use std::num::NonZero;

/// Distance in texels from which on two vertices share no texel, because bilinear sampling reads two by two of them. If they
/// share texels, a map may be unable to give each its own height.
pub const TEXELS_APART: f64 = 2.0;

/// Fraction of the vertices that a size chosen automatically has to resolve.
pub const RESOLVED_FRACTION: f64 = 0.99;

/// Smallest side that is chosen automatically, texels.
pub const SMALLEST_SIDE: u32 = 64;
/// Largest side that is chosen automatically unless another limit is given, texels.
pub const LARGEST_SIDE: u32 = 4096;

/// Distances between the texture coordinates of the vertices.
#[derive(Clone, Debug)]
pub struct Spacing {
    /// Distance from each vertex with a texture coordinate to the nearest other one, ascending, in units of the texture's
    /// side.
    distances: Vec<f64>,
}

impl Spacing {
    /// Measures the dominant uv vertices of a layout.
    pub fn new(atlas: &Atlas) -> Self {
        let vertices = 0..atlas.wedges().len() as Index;
        // −0 equals 0.
        let uvs = vertices.filter_map(|v| atlas.dominant(v)).map(|uv| (atlas.uvs()[uv as usize] + 0.0).to_array());
        let mut uvs: Vec<[f64; 2]> = uvs.collect();
        uvs.par_sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        // Vertices at the same place are at distance 0, and would make the tree slow.
        let mut distances = Vec::with_capacity(uvs.len());
        let mut single = Vec::new();
        let mut places = Vec::new();
        for same in uvs.chunk_by(|a, b| a == b) {
            places.push(same[0]);
            match same {
                [one] => single.push(*one),
                several => distances.extend(several.iter().map(|_| 0.0)),
            }
        }
        let Ok(tree) = ImmutableKdTree::<f64, 2>::new_from_slice(&places) else {
            return Self { distances: Vec::new() };
        };
        const TWO: NonZero<usize> = NonZero::new(2).expect("two is not zero");
        // The nearest one is the point itself.
        let second = |p: &[f64; 2]| {
            tree.query(p).nearest_n::<SquaredEuclidean<f64>>(TWO).execute().get(1).map(|n| n.distance.sqrt())
        };
        distances.extend(single.par_iter().map(|p| second(p).unwrap_or(f64::INFINITY)).collect::<Vec<f64>>());
        distances.sort_unstable_by(f64::total_cmp);
        Self { distances }
    }
    /// Number of vertices that are nearer than [`TEXELS_APART`] to another one in a square map.
    pub fn crowded(&self, side: u32) -> usize {
        self.nearer(TEXELS_APART, side)
    }
    fn nearer(&self, texels: f64, side: u32) -> usize {
        self.distances.partition_point(|d| d * f64::from(side) < texels)
    }
    /// Returns true if so many vertices are less than one texel apart that a fit is not worth its time.
    pub(crate) fn is_hopeless(&self, side: u32) -> bool {
        self.nearer(1.0, side) as f64 > HOPELESS_FRACTION * self.distances.len() as f64
    }
    /// Smallest distance in a square map, texels.
    pub fn smallest(&self, side: u32) -> f64 {
        self.distances.first().map_or(f64::INFINITY, |d| d * f64::from(side))
    }
    /// The sides (ascending) from the one on beyond which hardly a vertex more, 1 % at most, gets a texel of its own.
    pub(crate) fn settled<'a>(&self, sides: &'a [u32]) -> &'a [u32] {
        let crowded = |side: &u32| self.nearer(1.0, *side);
        let allowed =
            sides.last().map_or(0, crowded) + (self.distances.len() as f64 * (1.0 - RESOLVED_FRACTION)) as usize;
        &sides[sides.partition_point(|side| crowded(side) > allowed)..]
    }
    /// Chooses the smallest of the sides (ascending) at which all but 1 % of the vertices are far enough apart, or the largest
    /// one if none is enough.
    pub fn choose(&self, sides: &[u32]) -> MapSizeChoice {
        let allowed = (self.distances.len() as f64 * (1.0 - RESOLVED_FRACTION)).floor() as usize;
        let enough = sides.iter().copied().find(|&side| self.crowded(side) <= allowed);
        let largest = sides.last().copied().unwrap_or(1);
        let side = enough.unwrap_or(largest);
        let reason = if enough.is_some() { MapSizeReason::Spaced } else { MapSizeReason::Crowded };
        MapSizeChoice { side, vertices: self.distances.len(), left: self.crowded(side), reason, largest }
    }
    /// Chooses the smallest of the sides at which fitted maps give each vertex its values (each channel #V, model units), at
    /// all of its texture coordinates if there is such a side, else at the dominant ones; without such a side, as
    /// [`Self::choose`].
    pub fn choose_exact(
        &self,
        atlas: &Atlas,
        channels: &[Vec<f64>],
        sides: &[u32],
        exactness: Exactness,
        progress: &dyn Progress,
    ) -> Result<MapSizeChoice, Cancelled> {
        let spaced = self.choose(sides);
        let (mut exact, mut left_at_spaced) = (None, None);
        for &side in sides.iter().filter(|&&side| !self.is_hopeless(side)) {
            // Texels between the samples make no difference to whether the samples can be met.
            let size = Size::square(side);
            let mut unmet = UnmetSamples::default();
            for channel in channels {
                let mut flat = HeightMap { size, texels: vec![0.0; size.texels()] };
                let unmet_in_channel = super::fit(&mut flat, atlas, channel, exactness, progress)?;
                unmet.dominant = unmet.dominant.max(unmet_in_channel.dominant);
                unmet.secondary = unmet.secondary.max(unmet_in_channel.secondary);
            }
            if unmet.dominant == 0 {
                let choice = MapSizeChoice { side, left: 0, reason: MapSizeReason::Exact, ..spaced };
                if unmet.secondary == 0 {
                    return Ok(choice);
                }
                exact.get_or_insert(choice);
            }
            if side == spaced.side {
                left_at_spaced = Some(unmet.dominant);
            }
        }
        Ok(exact.unwrap_or(match left_at_spaced {
            Some(left) if spaced.reason == MapSizeReason::Spaced => {
                MapSizeChoice { left, reason: MapSizeReason::AlmostExact, ..spaced }
            }
            _ => spaced,
        }))
    }
}

/// Fraction of vertices less than one texel from another one above which no fit is tried, because somewhere there are then
/// fewer texels than equations.
const HOPELESS_FRACTION: f64 = 0.1;

/// Powers of two from the smallest size that is chosen automatically up to a largest one.
pub fn sides(largest: u32) -> Vec<u32> {
    let smallest = SMALLEST_SIDE.min(largest.next_power_of_two());
    let powers = (0..32).map(|e| 1u32 << e).filter(|side| (smallest..=largest).contains(side));
    let powers: Vec<u32> = powers.collect();
    if powers.is_empty() { vec![largest] } else { powers }
}

/// A chosen size and the reason for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapSizeChoice {
    /// Number of texels on a side.
    pub side: u32,
    /// Number of vertices with a texture coordinate.
    pub vertices: usize,
    /// Number of vertices for which the size is not enough, or which have private texels.
    pub left: usize,
    /// Reason for the size.
    pub reason: MapSizeReason,
    /// Largest side that was allowed, texels.
    pub largest: u32,
}

/// Reason why a size was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapSizeReason {
    /// The size is the smallest one at which each vertex gets its height.
    Exact,
    /// The size is the smallest one at which 99 % of the vertices are far enough apart; no size gives each vertex its height.
    AlmostExact,
    /// The size is the smallest one at which 99 % of the vertices are far enough apart.
    Spaced,
    /// The size is the smallest one that has space for private texels and hardly more vertices that need them than the largest size.
    PrivateTexels,
    /// The size is the largest one; at none are 99 % of the vertices far enough apart.
    Crowded,
}

impl std::fmt::Display for MapSizeChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { side, vertices, left, reason, largest } = self;
        let apart = vertices - left;
        match reason {
            MapSizeReason::Exact => {
                write!(f, "{side} is the smallest power of two at which each vertex gets its height")
            }
            MapSizeReason::AlmostExact => {
                write!(
                    f,
                    "{side} gives all but {left} of {vertices} vertices their height; up to {largest} no size gives it to all"
                )
            }
            MapSizeReason::PrivateTexels => {
                write!(f, "{side} gives each vertex its height, {left} of {vertices} by private texels")
            }
            MapSizeReason::Spaced => {
                write!(
                    f,
                    "{side} is the smallest power of two at which 99 % of the vertices are two texels apart ({apart} of {vertices})"
                )
            }
            MapSizeReason::Crowded => {
                write!(
                    f,
                    "{side} is the largest size tried, but only {apart} of {vertices} vertices are two texels apart: the layout is crowded"
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::progress::Silent;
    use glam::DVec2;

    fn flat(cells: u32) -> Spacing {
        let grid = shapes::grid(cells);
        let corners = 0..grid.topology().faces().items().len() as Index;
        let uvs: Vec<_> = grid.positions().iter().map(|p| p.truncate()).collect();
        Spacing::new(&Atlas::new(&grid, &uvs, corners.map(|c| Some(grid.topology().vertex(c)))).unwrap())
    }

    #[test]
    fn a_regular_layout_needs_two_texels_an_edge() {
        let choice = flat(100).choose(&sides(LARGEST_SIDE));
        assert_eq!((choice.side, choice.left, choice.reason), (256, 0, MapSizeReason::Spaced));
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
        assert_eq!(spacing.choose(&sides(LARGEST_SIDE)).side, 64);
        let choice = spacing
            .choose_exact(
                &atlas,
                &[heights],
                &sides(LARGEST_SIDE),
                Exactness { quantum: 1.0 / 65535.0, tolerance: 1.0 },
                &Silent,
            )
            .unwrap();
        assert!(choice.side > 64 && choice.reason == MapSizeReason::Exact, "{choice}");
    }

    #[test]
    fn a_crowd_is_named() {
        let grid = shapes::grid(40);
        let corners = 0..grid.topology().faces().items().len() as Index;
        let uvs: Vec<_> = grid.positions().iter().map(|p| p.truncate() * 1e-5).collect();
        let atlas = Atlas::new(&grid, &uvs, corners.map(|c| Some(grid.topology().vertex(c)))).unwrap();
        let choice = Spacing::new(&atlas).choose(&sides(LARGEST_SIDE));
        assert_eq!((choice.side, choice.left, choice.reason), (4096, 41 * 41, MapSizeReason::Crowded));
    }
}
