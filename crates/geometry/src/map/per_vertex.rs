//! The per-vertex layout, which has one texel for each source vertex: it is exact and needs no texture coordinates.
//!
//! Texel (i mod W, i div W) belongs to the i-th source vertex, with row 0 on top. W is a power of two, so that the centres
//! of texels are exact in single precision, and there bilinear sampling returns just that texel, whatever the precision
//! of its weights.
//!
//! ```
//! use glam::Vec2;
//! use planish_geometry::map::{Size, per_vertex};
//!
//! // Five source vertices, of which the last two were welded to the first.
//! let map = per_vertex::bake(&[0.5, 1.0, 2.0], &[0, 1, 2, 0, 0]);
//! assert_eq!((map.size, &map.texels[..5]), (Size::square(4), &[0.5, 1.0, 2.0, 0.5, 0.5][..]));
//! // The fifth one has the first texel of the second row.
//! assert_eq!(per_vertex::uv(4, map.size), Vec2::new(0.125, 0.625));
//! ```

use super::{HeightMap, Size};
use crate::mesh::jagged::Index;
use glam::Vec2;

/// Size of the smallest square with a texel for each source vertex whose side is a power of two.
pub fn size(source_vertices: usize) -> Size {
    let mut side = 1u32;
    while Size::square(side).texels() < source_vertices {
        side *= 2;
    }
    Size::square(side)
}

/// Writes the value of its vertex (#V, model units) to the texel of each source vertex; `vertex_of` is the vertex of each
/// (#v). The texels after the last one get the value nearest to zero that is in the range of the others.
pub fn bake(values: &[f64], vertex_of: &[Index]) -> HeightMap {
    let size = size(vertex_of.len());
    let mut texels: Vec<f32> = vertex_of.iter().map(|&v| values[v as usize] as f32).collect();
    let [low, high] = texels.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[l, h], t| [l.min(*t), h.max(*t)]);
    texels.resize(size.texels(), if low <= high { 0f32.clamp(low, high) } else { 0.0 });
    HeightMap { size, texels }
}

/// Texture coordinate (v up) of the centre of the texel of a source vertex; it is exact.
pub fn uv(source_vertex: Index, size: Size) -> Vec2 {
    let (column, row) = (source_vertex % size.width, source_vertex / size.width);
    size.uv_from_texel(column as usize, row as usize).as_vec2()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::displacement::{Displacement, Encoding, MapKind, SampleAt, TexelFormat, Weights};

    #[test]
    fn the_side_is_the_smallest_power_of_two_that_is_enough() {
        for (lines, side) in [(0, 1), (1, 1), (2, 2), (4, 2), (5, 4), (16, 4), (17, 8), (2930, 64), (1_000_000, 1024)] {
            assert_eq!(size(lines), Size::square(side), "{lines}");
        }
    }

    #[test]
    fn every_kind_of_sampling_gives_the_same_bits() {
        for lines in [1, 5, 1000, 70_000] {
            let values: Vec<f64> = (0..lines).map(|i| f64::from(i as u32).mul_add(0.37, 1.0).sin()).collect();
            let vertex_of: Vec<Index> = (0..lines as Index).collect();
            let map = bake(&values, &vertex_of);
            let size = map.size;
            let map = Displacement::encode(&[map], MapKind::Scalar, Encoding::covering(-1.0, 1.0, TexelFormat::Png16));
            for line in vertex_of {
                let height = map.height_at(SampleAt::Texel(line), Weights::Exact).to_bits();
                for weights in [Weights::Exact, Weights::EightBits] {
                    assert_eq!(
                        map.height_at(SampleAt::Uv(uv(line, size)), weights).to_bits(),
                        height,
                        "{line} of {lines}"
                    );
                }
            }
        }
    }

    #[test]
    fn texels_after_the_last_vertex_do_not_widen_the_range() {
        let map = bake(&[2.0, 3.0, 5.0], &[0, 1, 2, 1, 0]);
        assert_eq!(map.texels[..5], [2.0, 3.0, 5.0, 3.0, 2.0]);
        assert_eq!(map.range(), [2.0, 5.0]);
    }
}
