//! Rasterisation of a texture layout: which triangle each texel belongs to.
//!
//! A texel belongs to a triangle if its centre lies inside; a centre exactly on an edge belongs to the triangle for
//! which the edge is a top edge (horizontal, above the triangle) or a left edge, as on GPUs. Signs are exact
//! (Shewchuk's adaptive predicates), so of two triangles that share an edge exactly one gets each centre on it.

use super::Size;
use crate::mesh::atlas::Atlas;
use crate::mesh::jagged::{Index, Ragged};
use crate::mesh::surface::Surface;
use crate::progress::{Cancelled, Parts, Progress};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use robust::{Coord, orient2d};

/// Numbers of rows that one thread rasterises at a time: the first one with which triangles lie in few bands. Slivers lie in all.
const BANDS: [usize; 4] = [16, 64, 256, 1024];

/// Mean number of bands that triangles may lie in.
const BANDS_EACH: usize = 8;

/// The triangle of each texel.
#[derive(Clone, Debug)]
pub struct Coverage {
    size: Size,
    /// Corners of each triangle in texel space; `None` for a triangle without texture coordinates. #T
    triangles: Vec<Option<[DVec2; 3]>>,
    owners: Vec<Index>,
    /// True for texels that lie in several triangles. One entry a texel
    shared: Vec<bool>,
    overlaps: usize,
}

impl Coverage {
    const NOBODY: Index = Index::MAX;

    /// Rasterises the layout of a surface. Where triangles overlap, the first one wins.
    pub fn new(surface: &Surface, atlas: &Atlas, size: Size, progress: &dyn Progress) -> Result<Self, Cancelled> {
        progress.stage("rasterising");
        let texel = |c: &Index| atlas.at_corner(*c).map(|uv| size.texel_from_uv(uv));
        let triangle = |t: &[Index; 3]| Some([texel(&t[0])?, texel(&t[1])?, texel(&t[2])?]);
        let triangles: Vec<_> = surface.triangle_corners().par_iter().map(triangle).collect();
        Self::of_triangles(triangles, size, progress)
    }

    fn of_triangles(
        triangles: Vec<Option<[DVec2; 3]>>,
        size: Size,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let band_rows = band_rows(&triangles, size);
        let bands = (size.height as usize).div_ceil(band_rows);
        let in_bands = triangles.iter().zip(0..).filter_map(|(t, i)| Some((t.as_ref()?, i)));
        let in_bands = in_bands.flat_map(|(t, i)| bands_of(t, band_rows, size).map(move |band| (band as Index, i)));
        let by_band = Ragged::group(bands, in_bands);
        let mut owners = vec![Self::NOBODY; size.texels()];
        let mut shared = vec![false; size.texels()];
        let parts = Parts::new(progress, bands);
        let band_texels = size.width as usize * band_rows;
        let overlaps = owners
            .par_chunks_mut(band_texels)
            .zip(shared.par_chunks_mut(band_texels))
            .enumerate()
            .map(|(band, (owners, shared))| {
                parts.run(|| {
                    let members = by_band.get(band as Index);
                    let drawn = members.iter().map(|&i| match &triangles[i as usize] {
                        Some(t) => draw(t, i, band * band_rows, (owners, shared), size),
                        None => 0,
                    });
                    drawn.sum::<usize>()
                })
            })
            .sum::<Result<usize, Cancelled>>()?;
        Ok(Self { size, triangles, owners, shared, overlaps })
    }

    /// Size of the image.
    pub fn size(&self) -> Size {
        self.size
    }
    /// Triangle that covers a texel.
    pub fn owner(&self, column: usize, row: usize) -> Option<Index> {
        let owner = self.owners[row * self.size.width as usize + column];
        (owner != Self::NOBODY).then_some(owner)
    }
    /// Returns true if a texel lies in several triangles, of which the first owns it.
    pub fn is_shared(&self, column: usize, row: usize) -> bool {
        self.shared[row * self.size.width as usize + column]
    }
    /// A triangle with the barycentric coordinates of a texel's centre in it.
    pub fn weights(&self, triangle: Index, column: usize, row: usize) -> (Index, DVec3) {
        // Only triangles with corners own texels.
        let [a, b, c] = self.triangles[triangle as usize].unwrap_or_default();
        let p = DVec2::new(column as f64, row as f64) + 0.5;
        let area = (b - a).perp_dot(c - a);
        let (wa, wb) = ((b - p).perp_dot(c - p) / area, (c - p).perp_dot(a - p) / area);
        (triangle, DVec3::new(wa, wb, 1.0 - wa - wb))
    }
    /// Sum of the areas of the triangles within the unit square, estimated from their bounding boxes: how many layers of charts
    /// there are, if they fill the square. The time for rasterising grows with it.
    pub fn layers(surface: &Surface, atlas: &Atlas) -> f64 {
        let layer = |t: &[Index; 3]| {
            let [a, b, c] = [atlas.at_corner(t[0])?, atlas.at_corner(t[1])?, atlas.at_corner(t[2])?];
            let [low, high] = [a.min(b).min(c), a.max(b).max(c)];
            let clipped = (high.min(DVec2::ONE) - low.max(DVec2::ZERO)).max(DVec2::ZERO);
            let part = clipped.element_product() / (high - low).element_product();
            let area = (b - a).perp_dot(c - a).abs() / 2.0 * part;
            // Half of a box at most; what is not finite has no area or is far larger than the square.
            Some(if area.is_finite() { area.min(clipped.element_product()) } else { 0.0 })
        };
        let layers: Vec<f64> = surface.triangle_corners().par_iter().map(|t| layer(t).unwrap_or(0.0)).collect();
        layers.iter().sum()
    }
    /// Number of times that a texel's centre lay in a further triangle besides the first.
    pub fn overlaps(&self) -> usize {
        self.overlaps
    }
    /// Number of texels that lie in several triangles.
    pub fn shared(&self) -> usize {
        self.shared.iter().filter(|shared| **shared).count()
    }
    /// Fraction of the texels that lie in charts, 0..=1.
    pub fn covered_fraction(&self) -> f64 {
        let owned = self.owners.iter().filter(|&&owner| owner != Self::NOBODY).count();
        owned as f64 / self.size.texels() as f64
    }
}

/// Indices whose centre can lie in a range of coordinates.
fn centres(low: f64, high: f64, count: u32) -> std::ops::Range<usize> {
    // Saturating: texture coordinates may be anything finite.
    let first = (low - 0.5).ceil().max(0.0) as usize;
    let end = ((high - 0.5).floor() + 1.0).clamp(0.0, f64::from(count)) as usize;
    first.min(end)..end
}

fn rows_of(t: &[DVec2; 3], size: Size) -> std::ops::Range<usize> {
    let [a, b, c] = t.map(|p| p.y);
    centres(a.min(b).min(c), a.max(b).max(c), size.height)
}

/// Bands of so many rows that a triangle has rows in.
fn bands_of(t: &[DVec2; 3], band_rows: usize, size: Size) -> std::ops::Range<usize> {
    let rows = rows_of(t, size);
    if rows.is_empty() { 0..0 } else { rows.start / band_rows..(rows.end - 1) / band_rows + 1 }
}

/// Number of rows of a band, the smallest with which the lists of what lies in each are short.
fn band_rows(triangles: &[Option<[DVec2; 3]>], size: Size) -> usize {
    let is_short = |band: &&usize| {
        let total = triangles.par_iter().flatten_iter().map(|t| bands_of(t, **band, size).len()).sum::<usize>();
        total <= BANDS_EACH * triangles.len()
    };
    *BANDS.iter().find(is_short).unwrap_or(&BANDS[BANDS.len() - 1])
}

/// Columns whose centres can lie in a triangle, in a row: a slim triangle covers few of those of its bounding box, and a sliver none in
/// most rows.
fn columns_of([a, b, c]: [DVec2; 3], row: usize, size: Size) -> std::ops::Range<usize> {
    let [low, high] = [a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x)];
    // With coordinates far outside the image, the rounding of the intersections could be more than the margin.
    if [a, b, c].iter().any(|p| p.abs().max_element() > FAR) {
        return centres(low, high, size.width);
    }
    let y = row as f64 + 0.5;
    let [mut left, mut right] = [f64::INFINITY, f64::NEG_INFINITY];
    for (p, q) in [(a, b), (b, c), (c, a)] {
        if p.y.max(q.y) < y || p.y.min(q.y) > y {
            continue;
        }
        let at = p.x + (q.x - p.x) * ((y - p.y) / (q.y - p.y)).clamp(0.0, 1.0);
        // A horizontal edge is all in the row.
        let ends = if p.y == q.y { [p.x, q.x] } else { [at, at] };
        left = left.min(ends[0]).min(ends[1]);
        right = right.max(ends[0]).max(ends[1]);
    }
    centres((left - MARGIN).max(low), (right + MARGIN).min(high), size.width)
}

/// Distance in texels above the rounding of an intersection of coordinates up to [`FAR`].
const MARGIN: f64 = 1e-6;

/// Coordinates in texels above which a triangle is far outside of any image.
const FAR: f64 = 1e6;

/// Assigns the free texels of a band to a triangle and returns the number of its texels that were taken already.
fn draw(
    t: &[DVec2; 3],
    index: Index,
    first_row: usize,
    (owners, shared): (&mut [Index], &mut [bool]),
    size: Size,
) -> usize {
    let side = |a: DVec2, b: DVec2, p: DVec2| orient2d(coord(a), coord(b), coord(p));
    let [a, mut b, mut c] = *t;
    let orientation = side(a, b, c);
    if orientation == 0.0 {
        return 0;
    }
    if orientation < 0.0 {
        (b, c) = (c, b);
    }
    // Clockwise on the screen now: an edge to the right is a top edge, one upwards a left edge.
    let edges = [(a, b), (b, c), (c, a)].map(|(a, b)| {
        let d = b - a;
        (a, b, d.y < 0.0 || (d.y == 0.0 && d.x > 0.0))
    });
    let inside = |p: DVec2| {
        edges.iter().all(|&(a, b, owns_its_line)| {
            let side = side(a, b, p);
            side > 0.0 || (side == 0.0 && owns_its_line)
        })
    };
    let band_rows = owners.len() / size.width as usize;
    let rows = rows_of(t, size);
    let mut taken = 0;
    for row in rows.start.max(first_row)..rows.end.min(first_row + band_rows) {
        for column in columns_of([a, b, c], row, size) {
            if inside(DVec2::new(column as f64, row as f64) + 0.5) {
                let texel = (row - first_row) * size.width as usize + column;
                if owners[texel] == Coverage::NOBODY {
                    owners[texel] = index;
                } else {
                    shared[texel] = true;
                    taken += 1;
                }
            }
        }
    }
    taken
}

fn coord(p: DVec2) -> Coord<f64> {
    Coord { x: p.x, y: p.y }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;

    fn coverage(triangles: &[[[f64; 2]; 3]], size: u32) -> Coverage {
        let triangles = triangles.iter().map(|t| Some(t.map(DVec2::from))).collect();
        Coverage::of_triangles(triangles, Size::square(size), &Silent).unwrap()
    }

    fn owned(coverage: &Coverage, triangle: Index) -> Vec<(usize, usize)> {
        let n = coverage.size.width as usize;
        let all = (0..n * n).map(|i| (i % n, i / n));
        all.filter(|&(column, row)| coverage.owner(column, row) == Some(triangle)).collect()
    }

    #[test]
    fn centres_on_top_and_left_edges_are_in_and_on_others_are_not() {
        // Its corners are the centres of texels (0, 0), (2, 0) and (0, 2).
        let triangle = [[0.5, 0.5], [2.5, 0.5], [0.5, 2.5]];
        let [a, b, c] = triangle;
        let expected = vec![(0, 0), (1, 0), (0, 1)];
        for reordered in [[a, b, c], [b, c, a], [a, c, b]] {
            assert_eq!(owned(&coverage(&[reordered], 4), 0), expected);
        }
    }

    #[test]
    fn a_fan_around_a_centre_covers_each_texel_once() {
        let ring = [[0.5, 0.5], [3.5, 0.5], [6.5, 0.5], [6.5, 3.5], [6.5, 6.5], [3.5, 6.5], [0.5, 6.5], [0.5, 3.5]];
        let fan: Vec<_> = (0..8).map(|k| [[3.5, 3.5], ring[k], ring[(k + 1) % 8]]).collect();
        let found = coverage(&fan, 8);
        let total: usize = (0..8).map(|t| owned(&found, t).len()).sum();
        // A square of six by six texels: its top and left borders are in, the others out.
        assert_eq!((total, found.overlaps()), (36, 0));
    }

    #[test]
    fn no_centre_in_a_triangle_is_passed_over() {
        let random = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 8 & 0xffff) / 65535.0;
        for i in 0..300 {
            // Slim and broad ones, some with corners outside the image.
            let at = |k: u32| [40.0 * random(6 * i + k) - 4.0, 40.0 * random(6 * i + k + 1) * random(i) - 2.0];
            let triangle = [at(0), at(2), at(4)];
            let found = owned(&coverage(&[triangle], 32), 0);
            let [a, mut b, mut c] = triangle.map(DVec2::from);
            if (b - a).perp_dot(c - a) < 0.0 {
                (b, c) = (c, b);
            }
            let inside = |p: DVec2| [(a, b), (b, c), (c, a)].iter().all(|(a, b)| (*b - *a).perp_dot(p - *a) > 0.0);
            let all = (0..32 * 32).map(|i| (i % 32, i / 32));
            let expected = all.filter(|&(x, y)| inside(DVec2::new(x as f64, y as f64) + 0.5));
            assert_eq!(found, expected.collect::<Vec<_>>(), "{triangle:?}");
        }
    }

    #[test]
    fn an_odd_grid_is_covered_exactly_once() {
        // Coordinates that are not representable, shared by neighbours.
        let at = |i: usize, j: usize| [8.0 * (i as f64 / 7.0), 8.0 * (j as f64 / 7.0 + 0.01 * (i as f64).sin())];
        let mut triangles = Vec::new();
        for (i, j) in (0..7).flat_map(|i| (0..7).map(move |j| (i, j))) {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
        let found = coverage(&triangles, 8);
        assert_eq!(found.overlaps(), 0);
        assert_eq!(found.covered_fraction(), 1.0);
    }

    #[test]
    fn overlaps_are_counted_and_the_first_wins() {
        let t = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]];
        let found = coverage(&[t, t], 4);
        assert_eq!(owned(&found, 0).len(), found.overlaps());
        assert!((0..16).all(|i| found.is_shared(i % 4, i / 4) == found.owner(i % 4, i / 4).is_some()));
        assert!(owned(&found, 1).is_empty());
    }

    #[test]
    fn triangles_outside_the_image_do_no_harm() {
        let found =
            coverage(&[[[-9.0, -9.0], [1e30, -5.0], [-9.0, 1e30]], [[50.0, 50.0], [60.0, 50.0], [50.0, 60.0]]], 4);
        assert_eq!(found.covered_fraction(), 1.0);
    }

    #[test]
    fn weights_reproduce_the_centre() {
        let t = [[0.3, 0.1], [7.7, 1.9], [2.2, 7.4]];
        let found = coverage(&[t], 8);
        for (column, row) in owned(&found, 0) {
            let (_, w) = found.weights(0, column, row);
            let p = t.map(DVec2::from);
            let centre = p[0] * w.x + p[1] * w.y + p[2] * w.z;
            assert!(centre.distance(DVec2::new(column as f64, row as f64) + 0.5) < 1e-13);
            assert!(w.min_element() >= 0.0);
        }
    }

    #[test]
    fn slivers_are_in_few_lists_and_take_few_looks() {
        let size = Size::square(4096);
        // Each goes through all rows and is a hundredth of a texel wide.
        let sliver = |k: u32| {
            let x = f64::from(k) * 0.83 + 0.3;
            [DVec2::new(x, 0.0), DVec2::new(x + 0.01, 0.0), DVec2::new(x + 40.0, 4096.0)]
        };
        let slivers: Vec<_> = (0..4000).map(|k| Some(sliver(k))).collect();
        let rows = band_rows(&slivers, size);
        let lists: usize = slivers.iter().flatten().map(|t| bands_of(t, rows, size).len()).sum();
        assert!(lists <= BANDS_EACH * slivers.len(), "{lists}");
        let looks = |t: &[DVec2; 3]| rows_of(t, size).map(|row| columns_of(*t, row, size).len()).sum::<usize>();
        let looks: usize = slivers.iter().flatten().step_by(100).map(looks).sum();
        assert!(looks < 40 * 4096 / 50, "{looks}");
        // Common triangles stay in bands of few rows, which threads share better.
        assert_eq!(band_rows(&[Some([DVec2::ZERO, DVec2::X * 9.0, DVec2::Y * 9.0])], size), BANDS[0]);
    }
}
