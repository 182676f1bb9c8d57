//! Sets of cells of a square grid, one bit each.

use crate::chart::Chart;
use glam::DVec2;

/// A set of cells, kept as rows of 64-bit words; bit 0 of word 0 is column 0.
#[derive(Clone, Debug)]
pub(crate) struct Mask {
    pub(crate) width: usize,
    words_per_row: usize,
    words: Vec<u64>,
}

impl Mask {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        // One word more than needed, so that shifted rows have room to spill into.
        let words_per_row = width / 64 + 1;
        Self { width, words_per_row, words: vec![0; words_per_row * height] }
    }

    /// Cells touched by the chart, whose places are in cells and not negative.
    pub(crate) fn touched(chart: &Chart) -> Self {
        let size = chart.uvs.iter().fold(DVec2::ZERO, |size, uv| size.max(*uv)).as_usizevec2();
        let mut mask = Self::new(size.x + 1, size.y + 1);
        for &triangle in &chart.triangles {
            mask.touch(chart.corners(triangle));
        }
        mask
    }

    pub(crate) fn height(&self) -> usize {
        self.words.len() / self.words_per_row
    }

    /// The cells within `reach` columns and rows; grows by `reach` on every side.
    pub(crate) fn dilated(&self, reach: usize) -> Self {
        let mut wide = Self::new(self.width + 2 * reach, self.height() + 2 * reach);
        for shift in 0..=2 * reach {
            wide.insert(self, shift, reach);
        }
        let mut mask = Self::new(wide.width, wide.height());
        for y in 0..self.height() {
            let row = wide.row(y + reach).to_vec();
            for below in y..=y + 2 * reach {
                let start = below * mask.words_per_row;
                for (word, added) in mask.words[start..].iter_mut().zip(&row) {
                    *word |= added;
                }
            }
        }
        mask
    }

    /// Adds the cells of `other`, moved right and up.
    pub(crate) fn insert(&mut self, other: &Self, right: usize, up: usize) {
        for y in 0..other.height() {
            let start = (y + up) * self.words_per_row + right / 64;
            for (k, word) in shifted(other.row(y), right % 64).enumerate() {
                if word != 0 {
                    self.words[start + k] |= word;
                }
            }
        }
    }

    /// Whether any cell of `other`, moved right and up, is in this set.
    pub(crate) fn meets(&self, other: &Self, right: usize, up: usize) -> bool {
        (0..other.height()).any(|y| {
            let row = &self.row(y + up)[right / 64..];
            shifted(other.row(y), right % 64).zip(row).any(|(a, b)| a & b != 0)
        })
    }

    fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.words_per_row..][..self.words_per_row]
    }

    /// Adds the cells that a triangle touches.
    fn touch(&mut self, corners: [DVec2; 3]) {
        let low = corners[0].min(corners[1]).min(corners[2]).as_usizevec2();
        let high = corners[0].max(corners[1]).max(corners[2]).as_usizevec2();
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                if touches_cell(corners, centre) {
                    self.words[y * self.words_per_row + x / 64] |= 1 << (x % 64);
                }
            }
        }
    }
}

/// Separating-axis test of a counter-clockwise triangle against the unit square around `centre`.
/// The square's own two axes are the caller's bounding box.
fn touches_cell(corners: [DVec2; 3], centre: DVec2) -> bool {
    (0..3).all(|k| {
        let edge = corners[(k + 1) % 3] - corners[k];
        let half_extent = 0.5 * (edge.x.abs() + edge.y.abs());
        edge.perp_dot(centre - corners[k]) >= -half_extent
    })
}

/// Words of a row moved right by less than a word, with the word that spills over.
fn shifted(row: &[u64], bits: usize) -> impl Iterator<Item = u64> + '_ {
    let word = move |k: usize| row.get(k).copied().unwrap_or(0);
    (0..=row.len()).map(move |k| {
        let carried = if bits == 0 || k == 0 { 0 } else { word(k - 1) >> (64 - bits) };
        (word(k) << bits) | carried
    })
}
