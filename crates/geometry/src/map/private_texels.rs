//! Private texels: texels in the free room of a map for vertices whose own texture coordinates cannot give them their height,
//! because charts overlap or are crowded, or because the vertices have no texture coordinates.
//!
//! The other vertices stay where they are. The fit leaves out as few vertices as it can: of those that contradict each other it
//! gives up the one with the largest error, and tries again with the rest. A private texel is read by one vertex alone, which
//! samples its centre; no other sample blends it in.

use super::fit::{self, Rank};
use super::sampling::Footprint;
use super::{Coverage, Exactness, HeightMap, Size};
use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::Index;
use crate::progress::{Cancelled, Progress};
use rustc_hash::FxHashSet;

/// Texels that may become private.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Room {
    /// Texels outside of the charts and of a margin around them, so that the map between the vertices stays as it is.
    OutsideCharts,
    /// Every texel that no vertex samples.
    Anywhere,
}

/// Distance from the charts that private texels keep outside of them, texels: a filter blends two by two texels, and a chart
/// may reach half a texel beyond the centres that it covers.
const MARGIN: usize = 2;

/// Rounds in which contradictions are resolved one by one. Vertices that are unmet after them all get private texels.
const ROUNDS: usize = 8;

/// Texture coordinates in the same cell of a grid, this many to a texel, count as one place: only texels that differ far more
/// than the heights could tell them apart.
const CELLS: f32 = 32.0;

/// Fits channels (#V each, model units) as [`fit`](super::fit()) does, and gives the vertices that cannot be met private
/// texels. `maps` are the interpolated channels.
///
/// Returns pairs of a vertex and its texel, counted row by row from the top, ascending; `None`, with arbitrary maps, if there is
/// not enough room.
pub(crate) fn fit_with_private_texels(
    maps: &mut [HeightMap],
    layout: Layout,
    channels: &[Vec<f64>],
    exactness: Exactness,
    progress: &dyn Progress,
) -> Result<Option<Vec<[Index; 2]>>, Cancelled> {
    let Layout { atlas, coverage, is_used, room } = layout;
    let size = coverage.size();
    let start: Vec<Vec<f32>> = maps.iter().map(|map| map.texels.clone()).collect();
    let vertices = 0..atlas.wedges().len() as Index;
    let mut left_out: Vec<bool> = vertices.map(|v| atlas.dominant(v).is_none()).collect();
    for round in 0.. {
        let mut unmet = vec![0.0f64; left_out.len()];
        for ((map, start), channel) in maps.iter_mut().zip(&start).zip(channels) {
            map.texels.clone_from(start);
            let (vertices, mut samples) = super::samples(atlas, channel);
            for (sample, v) in samples.iter_mut().zip(&vertices) {
                if left_out[*v as usize] {
                    sample.rank = Rank::Secondary;
                }
            }
            for (i, error) in fit::unmet(&mut map.texels, size, &samples, exactness, progress)? {
                if samples[i].rank == Rank::Dominant {
                    let unmet = &mut unmet[vertices[i] as usize];
                    *unmet = unmet.max(error);
                }
            }
        }
        let unmet: Vec<(Index, f64)> = (0..).zip(unmet).filter(|(_, error)| *error > 0.0).collect();
        if unmet.is_empty() {
            break;
        }
        let given_up = match round {
            // Nothing is left out as long as all may go well; then what is hopeless leaves first.
            0 => at_places_of_others(atlas, size),
            1..=ROUNDS => worst_of_neighbours(unmet, atlas, size),
            _ => vertices_of(unmet),
        };
        given_up.into_iter().for_each(|v| left_out[v as usize] = true);
    }
    let vertices = (0..).zip(&left_out).filter(|(v, left_out)| **left_out && is_used(*v)).map(|(v, _)| v);
    let vertices: Vec<Index> = vertices.collect();
    let free = free_texels(atlas, coverage, room);
    if free.len() < vertices.len() {
        return Ok(None);
    }
    let private: Vec<[Index; 2]> = vertices.into_iter().zip(free).map(|(v, texel)| [v, texel]).collect();
    for (map, channel) in maps.iter_mut().zip(channels) {
        for &[v, texel] in &private {
            map.texels[texel as usize] = channel[v as usize] as f32;
        }
    }
    Ok(Some(private))
}

/// Returns false if there is not even room for the vertices without texture coordinates and for all but one at each place: then a
/// fit is not worth its time.
pub(crate) fn may_have_room(layout: Layout) -> bool {
    let Layout { atlas, coverage, is_used, room } = layout;
    let vertices = 0..atlas.wedges().len() as Index;
    let unmapped = vertices.filter(|&v| is_used(v) && atlas.dominant(v).is_none()).count();
    let needed = unmapped + at_places_of_others(atlas, coverage.size()).len();
    needed <= free_texels(atlas, coverage, room).len()
}

/// A layout with room for private texels.
#[derive(Clone, Copy)]
pub(crate) struct Layout<'a> {
    /// Texture coordinates of the corners.
    pub(crate) atlas: &'a Atlas,
    /// Texels of the charts.
    pub(crate) coverage: &'a Coverage,
    /// True for vertices that some face uses; no other vertex is displaced.
    pub(crate) is_used: &'a dyn Fn(Index) -> bool,
    /// Texels that may become private.
    pub(crate) room: Room,
}

/// Vertices at the place of one before them.
fn at_places_of_others(atlas: &Atlas, size: Size) -> Vec<Index> {
    let mut places = FxHashSet::default();
    let is_other = |v: &Index| {
        atlas.dominant(*v).is_some_and(|uv| {
            let at = size.texel_from_uv(atlas.uvs()[uv as usize]).as_vec2() * CELLS;
            !places.insert([at.x.floor() as i64, at.y.floor() as i64])
        })
    };
    (0..atlas.wedges().len() as Index).filter(is_other).collect()
}

/// Of vertices that share texels those with the largest error: none of the vertices returned shares a texel with another one.
fn worst_of_neighbours(mut unmet: Vec<(Index, f64)>, atlas: &Atlas, size: Size) -> Vec<Index> {
    unmet.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut taken = FxHashSet::default();
    let is_first = |v: &Index| {
        let Some(uv) = atlas.dominant(*v) else { return true };
        let footprint = Footprint::new(atlas.uvs()[uv as usize].as_vec2(), size);
        let is_free = footprint.weights().all(|(texel, _)| !taken.contains(&texel));
        if is_free {
            taken.extend(footprint.weights().map(|(texel, _)| texel));
        }
        is_free
    };
    vertices_of(unmet).into_iter().filter(is_first).collect()
}

fn vertices_of(unmet: Vec<(Index, f64)>) -> Vec<Index> {
    unmet.into_iter().map(|(v, _)| v).collect()
}

/// Texels that may become private, row by row from the top.
fn free_texels(atlas: &Atlas, coverage: &Coverage, room: Room) -> Vec<Index> {
    let size = coverage.size();
    let mut taken = vec![false; size.texels()];
    for uv in atlas.wedges().items() {
        for (texel, _) in Footprint::new(atlas.uvs()[*uv as usize].as_vec2(), size).weights() {
            taken[texel] = true;
        }
    }
    if room == Room::OutsideCharts {
        widen(&mut taken, coverage);
    }
    (0..).zip(taken).filter(|(_, taken)| !taken).map(|(texel, _)| texel).collect()
}

/// Marks the texels of the charts and of the margin around them.
fn widen(taken: &mut [bool], coverage: &Coverage) {
    let Size { width, height } = coverage.size();
    let (width, height) = (width as usize, height as usize);
    // First along rows, then along columns.
    let mut rows = vec![false; taken.len()];
    for (row, near) in rows.chunks_exact_mut(width).enumerate() {
        for column in (0..width).filter(|&column| coverage.owner(column, row).is_some()) {
            near[column.saturating_sub(MARGIN)..(column + MARGIN + 1).min(width)].fill(true);
        }
    }
    for row in 0..height {
        for near in row.saturating_sub(MARGIN)..(row + MARGIN + 1).min(height) {
            let source = &rows[row * width..(row + 1) * width];
            let target = &mut taken[near * width..(near + 1) * width];
            target.iter_mut().zip(source).for_each(|(taken, near)| *taken |= near);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::mesh::surface::Surface;
    use crate::progress::Silent;
    use glam::DVec2;

    const EXACTNESS: Exactness = Exactness { quantum: 1.0 / 65535.0, tolerance: 1.0 };

    fn height(v: usize) -> f64 {
        f64::from((v as u32).wrapping_mul(2_654_435_761) >> 8 & 0xffff) / 65535.0
    }

    fn layout(uv: impl Fn(DVec2) -> DVec2) -> (Surface, Atlas) {
        let grid = shapes::grid(8);
        let corners = 0..grid.topology().faces().items().len() as Index;
        let uvs: Vec<_> = grid.positions().iter().map(|p| uv(p.truncate())).collect();
        let atlas = Atlas::new(&grid, &uvs, corners.map(|c| Some(grid.topology().vertex(c)))).unwrap();
        (grid, atlas)
    }

    /// Fits heights that differ from vertex to vertex, and checks that each vertex gets its own.
    fn private(surface: &Surface, atlas: &Atlas, side: u32, room: Room) -> Option<Vec<[Index; 2]>> {
        let size = Size::square(side);
        let coverage = Coverage::new(surface, atlas, size, &Silent).unwrap();
        let heights: Vec<f64> = (0..surface.positions().len()).map(height).collect();
        let mut maps = [HeightMap { size, texels: vec![0.5; size.texels()] }];
        let layout = Layout { atlas, coverage: &coverage, is_used: &|_| true, room };
        let may_have_room = may_have_room(layout);
        let channels = std::slice::from_ref(&heights);
        let private = fit_with_private_texels(&mut maps, layout, channels, EXACTNESS, &Silent).unwrap();
        assert!(may_have_room || private.is_none());
        let private = private?;
        let texels = &maps[0].texels;
        for (v, height) in (0..).zip(&heights) {
            let sampled = match private.iter().find(|pair| pair[0] == v) {
                Some(pair) => texels[pair[1] as usize],
                None => {
                    let uv = atlas.uvs()[atlas.dominant(v).unwrap() as usize];
                    Footprint::new(uv.as_vec2(), size).sample(texels)
                }
            };
            assert!(
                (f64::from(sampled) - height).abs() < EXACTNESS.quantum / 2.0,
                "vertex {v}: {sampled} for {height}"
            );
        }
        Some(private)
    }

    #[test]
    fn a_layout_with_space_needs_none() {
        let (grid, atlas) = layout(|p| p * 0.9 + 0.05);
        assert_eq!(private(&grid, &atlas, 64, Room::OutsideCharts), Some(Vec::new()));
    }

    #[test]
    fn of_two_vertices_at_one_place_one_keeps_it() {
        // Folded along the middle: 4 of 9 columns lie on others.
        let (grid, atlas) = layout(|p| DVec2::new((p.x - 0.5).abs(), p.y * 0.9 + 0.05));
        let private = private(&grid, &atlas, 64, Room::OutsideCharts).unwrap();
        assert_eq!(private.len(), 4 * 9);
        let outside = |texel: Index| texel % 64 >= 34 || [0, 63].contains(&(texel / 64));
        assert!(private.iter().all(|pair| outside(pair[1])), "{private:?}");
    }

    #[test]
    fn crowded_vertices_leave_and_the_others_stay() {
        // One corner of the grid is squeezed into a fraction of a texel.
        let (grid, atlas) = layout(|p| if p.x + p.y < 0.4 { p * 0.002 + 0.1 } else { p * 0.8 + 0.1 });
        let private = private(&grid, &atlas, 64, Room::OutsideCharts).unwrap();
        assert!((4..=10).contains(&private.len()), "{private:?}");
        assert!(private.windows(2).all(|pair| pair[0][0] < pair[1][0] && pair[0][1] < pair[1][1]));
    }

    #[test]
    fn without_room_outside_there_may_be_room_between_the_vertices() {
        let (grid, atlas) = layout(|p| DVec2::new((2.0 * p.x - 1.0).abs(), p.y));
        assert_eq!(private(&grid, &atlas, 32, Room::OutsideCharts), None);
        assert_eq!(private(&grid, &atlas, 32, Room::Anywhere).unwrap().len(), 4 * 9);
        assert_eq!(private(&grid, &atlas, 8, Room::Anywhere), None);
    }
}
