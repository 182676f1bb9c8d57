//! Encoding of displacement maps in image files and back: height = bias + scale · texel, texel in 0..=1.
//!
//! ```
//! use planish_geometry::map::displacement::{Displacement, Encoding, MapKind, SampleAt, TexelFormat, Weights};
//! use planish_geometry::map::{HeightMap, Size};
//!
//! let heights = HeightMap { size: Size::square(2), texels: vec![-1.0, 0.25, 2.0, 3.0] };
//! let encoding = Encoding::covering(-1.0, 3.0, TexelFormat::Png16);
//! let bytes = Displacement::encode(&[heights], MapKind::Scalar, encoding).to_bytes()?;
//! let read = Displacement::decode(&bytes, MapKind::Scalar, Size::square(2), encoding)?;
//! let height = f64::from(read.height_at(SampleAt::Texel(1), Weights::Exact));
//! assert!((height - 0.25).abs() <= 0.51 * encoding.quantum());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod format;
mod image_file;

pub use crate::map::sampling::Weights;
pub use format::{FileFormat, TexelFormat};
pub use image_file::{DecodeError, EncodeError};

pub(crate) use image_file::png;

use crate::map::per_vertex;
use crate::map::sampling::{Footprint, HeightMap, Size};
use crate::mesh::jagged::Index;
use crate::named;
use format::Stored;
use glam::{Vec2, Vec3};
use half::f16;
use rayon::prelude::*;

named! {
    /// Kind of a displacement map: what its texels hold.
    #[derive(Default)]
    pub enum MapKind {
        /// Height along the normal: one channel.
        #[default]
        Scalar = "scalar",
        /// Displacement vector in the axes of the model: red, green and blue are x, y and z.
        VectorObject = "vector-object",
        /// Displacement vector in the tangent frame of the vertex: red along the tangent, green along the bitangent, blue
        /// along the normal.
        VectorTangent = "vector-tangent",
    }
}

impl MapKind {
    /// Number of channels of a texel.
    pub fn planes(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::VectorObject | Self::VectorTangent => 3,
        }
    }
}

/// Encoding of heights as texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoding {
    /// Format of a texel.
    pub texel: TexelFormat,
    /// Height at texel 0, model units.
    pub bias: f32,
    /// Height at texel 1 minus that at texel 0, model units; not negative.
    pub scale: f32,
}

impl Encoding {
    /// Covers a range of heights, model units. Bias and scale are rounded outwards to single precision, which is what
    /// clients compute in.
    pub fn covering(low: f64, high: f64, texel: TexelFormat) -> Self {
        let bias = if f64::from(low as f32) > low { (low as f32).next_down() } else { low as f32 };
        let base = f64::from(bias);
        let span = high - base;
        // What the difference lost by rounding (Knuth 1969): all of the smaller end, where the other one is huge.
        let part = span - high;
        let lost = (high - (span - part)) - (base + part);
        let span = if lost > 0.0 { span.next_up() } else { span };
        let scale = if f64::from(span as f32) < span { (span as f32).next_up() } else { span as f32 };
        Self { texel, bias, scale }
    }
    /// Step between two heights, model units: scale / (2ᵇ − 1). With floating point the spacing just below the
    /// largest texel: scale · 2⁻²⁴, in half precision scale · 2⁻¹¹.
    pub fn quantum(self) -> f64 {
        f64::from(self.scale) * quantum(self.texel)
    }
}

/// Quantum of an encoding ([`Encoding::quantum`]) as a fraction of its scale.
pub fn quantum(texel: TexelFormat) -> f64 {
    match texel.stored() {
        Stored::Integers(steps) => 1.0 / f64::from(steps),
        Stored::Half => 2f64.powi(-11),
        Stored::Single => 2f64.powi(-24),
    }
}

/// Position in a map that a vertex samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SampleAt {
    /// The vertex samples at a texture coordinate, v up: bilinear between texel centres, clamped at the border.
    Uv(Vec2),
    /// The vertex reads one texel, counted row by row from the top.
    Texel(Index),
}

/// Position in a page of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PageSample {
    /// Index of the page.
    pub page: Index,
    /// Position in the image of the page.
    pub at: SampleAt,
}

/// A displacement map as the GPU has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Displacement {
    size: Size,
    kind: MapKind,
    encoding: Encoding,
    /// Texels in 0..=1 that the format can represent, channel by channel, row by row from the top.
    planes: Vec<Vec<f32>>,
}

impl Displacement {
    /// Quantises channels of the same size: each texel becomes the nearest one that the format can represent.
    ///
    /// # Panics
    /// If there are not as many channels as the kind has.
    pub fn encode(channels: &[HeightMap], kind: MapKind, encoding: Encoding) -> Self {
        assert_eq!(channels.len(), kind.planes(), "one map for each channel");
        let (bias, scale) = (f64::from(encoding.bias), f64::from(encoding.scale));
        let normalise =
            |height: f32| if scale > 0.0 { ((f64::from(height) - bias) / scale).clamp(0.0, 1.0) } else { 0.0 };
        let quantise = |height: &f32| match encoding.texel.stored() {
            // Unsigned normalised integers become floats as on GPUs: the nearest one to i / (2ᵇ − 1).
            Stored::Integers(steps) => ((normalise(*height) * f64::from(steps)).round() / f64::from(steps)) as f32,
            Stored::Half => f16::from_f64(normalise(*height)).to_f32(),
            Stored::Single => normalise(*height) as f32,
        };
        let planes = channels.iter().map(|map| map.texels.par_iter().map(quantise).collect()).collect();
        Self { size: channels[0].size, kind, encoding, planes }
    }

    /// Gathers the texels that source vertices (#v) sample in the pages of a map: the i-th texel is that of the i-th vertex, and a
    /// vertex that reads it gets the height that it samples in its page, bit for bit. Texels of vertices without a sample are 0.
    ///
    /// # Panics
    /// If there is no page, or a sample is in none.
    pub fn gathered(pages: &[Self], samples: &[Option<PageSample>], weights: Weights) -> Self {
        let size = per_vertex::size(samples.len());
        let plane = |channel: usize| {
            let texel = |sample: &Option<PageSample>| {
                sample.map_or(0.0, |PageSample { page, at }| pages[page as usize].texel_at(channel, at, weights))
            };
            let mut texels: Vec<f32> = samples.par_iter().map(texel).collect();
            texels.resize(size.texels(), 0.0);
            texels
        };
        let Self { kind, encoding, .. } = pages[0];
        Self { size, kind, encoding, planes: (0..kind.planes()).map(plane).collect() }
    }

    /// Size of the image.
    pub fn size(&self) -> Size {
        self.size
    }
    /// Kind of the map.
    pub fn kind(&self) -> MapKind {
        self.kind
    }
    /// Format, bias and scale.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }
    /// Texels in 0..=1, row by row from the top: one plane for heights, three for vectors.
    pub fn planes(&self) -> &[Vec<f32>] {
        &self.planes
    }

    /// Returns the map with another bias and scale, model units, as a slider sets them.
    #[must_use]
    pub fn with_range(&self, bias: f32, scale: f32) -> Self {
        Self { encoding: Encoding { bias, scale, ..self.encoding }, ..self.clone() }
    }

    /// Writes the image file.
    pub fn to_bytes(&self) -> Result<Vec<u8>, EncodeError> {
        image_file::encode(&self.planes, self.size, self.encoding.texel)
    }

    /// Reads an image file back; it must be what the manifest says.
    pub fn decode(bytes: &[u8], kind: MapKind, size: Size, encoding: Encoding) -> Result<Self, DecodeError> {
        Ok(Self { size, kind, encoding, planes: image_file::decode(bytes, kind.planes(), size, encoding.texel)? })
    }

    /// Height at a sample position, model units.
    ///
    /// Twin of `height_at` and `height_of` in `shaders/displace.wgsl`, operation by operation in single precision.
    pub fn height_at(&self, sample_at: SampleAt, weights: Weights) -> f32 {
        self.channel_at(0, sample_at, weights)
    }

    /// Vector of the three channels at a sample position, model units. Twin of `vector_at` and `vector_of`.
    ///
    /// # Panics
    /// If the map holds heights.
    pub fn vector_at(&self, sample_at: SampleAt, weights: Weights) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|plane| self.channel_at(plane, sample_at, weights)))
    }

    /// Value of one channel at a sample position, model units.
    pub fn channel_at(&self, channel: usize, sample_at: SampleAt, weights: Weights) -> f32 {
        self.encoding.bias + self.encoding.scale * self.texel_at(channel, sample_at, weights)
    }

    /// Interpolated texel of one channel at a sample position, 0..=1.
    pub fn texel_at(&self, channel: usize, sample_at: SampleAt, weights: Weights) -> f32 {
        let texels = &self.planes[channel];
        match sample_at {
            SampleAt::Texel(index) => texels[index as usize],
            SampleAt::Uv(uv) => Footprint::new(uv, self.size).with(weights).sample(texels),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size { width: 5, height: 3 };

    /// Formats that this build of the crate has.
    fn built(formats: &[TexelFormat]) -> impl Iterator<Item = TexelFormat> {
        formats.iter().copied().filter(|texel| texel.file().is_built())
    }

    fn ramp(texel: TexelFormat) -> Displacement {
        let texels = (0..15u8).map(|i| -0.3 + 0.05 * f32::from(i)).collect();
        let encoding = Encoding::covering(-0.3, 0.4, texel);
        Displacement::encode(&[HeightMap { size: SIZE, texels }], MapKind::Scalar, encoding)
    }

    fn ramps(texel: TexelFormat) -> Displacement {
        let plane = |k: u8| HeightMap {
            size: SIZE,
            texels: (0..15u8).map(|i| f32::from((7 * i + 3 * k) % 15) / 14.0).collect(),
        };
        Displacement::encode(
            &[plane(0), plane(1), plane(2)],
            MapKind::VectorObject,
            Encoding::covering(0.0, 1.0, texel),
        )
    }

    #[test]
    fn bytes_read_back_to_the_same_texels() {
        for texel in built(&TexelFormat::ALL) {
            for (kind, map) in [(MapKind::Scalar, ramp(texel)), (MapKind::VectorObject, ramps(texel))] {
                let read = Displacement::decode(&map.to_bytes().unwrap(), kind, map.size, map.encoding).unwrap();
                assert_eq!(read, map, "{texel:?}");
            }
        }
    }

    #[test]
    fn a_texel_is_off_by_half_a_quantum_at_most() {
        for texel in built(&TexelFormat::ALL) {
            let map = ramp(texel);
            let encoding = map.encoding;
            for (i, texel) in (0u8..).zip(&map.planes[0]) {
                let height = f64::from(encoding.bias) + f64::from(encoding.scale) * f64::from(*texel);
                let true_height = f64::from(-0.3 + 0.05 * f32::from(i));
                // The texel itself is rounded to single precision.
                let slack = 2f64.powi(-25) * f64::from(encoding.scale);
                assert!((height - true_height).abs() <= encoding.quantum() / 2.0 + slack, "{texel:?}");
            }
        }
    }

    #[test]
    fn the_range_is_never_cut() {
        for (low, high) in [(-0.1, 0.1), (1e-9, 1.0 / 3.0), (-1e10, 1e-3), (2.0, 2.0), (0.0, 0.0)] {
            let e = Encoding::covering(low, high, TexelFormat::Png16);
            assert!(f64::from(e.bias) <= low && f64::from(e.bias) + f64::from(e.scale) >= high, "{e:?}");
        }
    }

    #[test]
    fn heights_at_texel_centres_are_the_texels_and_the_border_is_clamped() {
        let map = ramp(TexelFormat::Exr32);
        let at = |uv: Vec2| map.height_at(SampleAt::Uv(uv), Weights::Exact);
        let texels = &map.planes[0];
        let height = |texel: f32| map.encoding.bias + map.encoding.scale * texel;
        for (i, texel) in texels.iter().enumerate() {
            let uv = map.size.uv_from_texel(i % 5, i / 5).as_vec2();
            // (i + ½)/5 is not exact in single precision: a texel gets 1e-6 of the step to its neighbour.
            assert!((at(uv) - height(*texel)).abs() < 1e-6);
            assert_eq!(map.height_at(SampleAt::Texel(i as Index), Weights::Exact), height(*texel));
        }
        assert_eq!(at(Vec2::new(-3.0, 9.0)), height(texels[0]));
        assert_eq!(at(Vec2::new(1e30, -1e30)), height(texels[14]));
        let between = at(Vec2::new(0.2, 1.0 - 0.5 / 3.0));
        assert!((between - height((texels[0] + texels[1]) / 2.0)).abs() < 1e-6);
    }

    #[test]
    fn weights_of_eight_bits_are_off_by_half_a_step() {
        let map = ramps(TexelFormat::Exr32);
        let uv = SampleAt::Uv(Vec2::new(0.413, 0.377));
        let [exact, coarse] = [Weights::Exact, Weights::EightBits].map(|w| map.vector_at(uv, w));
        let gap = (exact - coarse).abs().max_element();
        // Half a 256th in each of two directions, of texels that differ by one at most.
        assert!(gap > 1e-5 && gap <= 1.0 / 256.0, "{gap}");
    }

    #[test]
    fn texels_that_are_not_finite_are_refused_and_their_place_is_named() {
        for texel in built(&[TexelFormat::Tiff32, TexelFormat::Exr16, TexelFormat::Exr32]) {
            for broken in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let mut map = ramp(texel);
                map.planes[0][7] = broken;
                let read = Displacement::decode(&map.to_bytes().unwrap(), MapKind::Scalar, map.size, map.encoding);
                assert_eq!(read, Err(DecodeError::NotFinite { column: 2, row: 1 }), "{texel:?} {broken}");
            }
        }
    }

    #[test]
    fn another_size_is_found_in_the_header_of_every_format() {
        for texel in built(&TexelFormat::ALL) {
            let map = ramp(texel);
            let bytes = map.to_bytes().unwrap();
            // The texels are missing, so that only the header can be what is refused.
            for bytes in [&bytes[..], &bytes[..bytes.len() - 12]] {
                let size = Size { width: 3, height: 5 };
                let Err(DecodeError::Texels { found, .. }) =
                    Displacement::decode(bytes, MapKind::Scalar, size, map.encoding)
                else {
                    // A TIFF has its directory at the end.
                    assert!(
                        bytes.len() < map.to_bytes().unwrap().len() && texel.file() == FileFormat::Tiff,
                        "{texel:?}"
                    );
                    continue;
                };
                assert!(found.starts_with("5 × 3 texels"), "{texel:?}: {found}");
            }
        }
    }

    #[test]
    fn broken_and_foreign_images_are_refused() {
        for texel in built(&TexelFormat::ALL) {
            let map = ramp(texel);
            let bytes = map.to_bytes().unwrap();
            let cut = Displacement::decode(&bytes[..bytes.len() / 2], MapKind::Scalar, map.size, map.encoding);
            assert!(matches!(cut, Err(DecodeError::Image { .. })), "{texel:?}: {cut:?}");
        }
        let map = ramp(TexelFormat::Png16);
        let bytes = map.to_bytes().unwrap();
        let other = Displacement::decode(&bytes, MapKind::Scalar, Size::square(5), map.encoding).unwrap_err();
        assert_eq!(other.to_string(), "holds 5 × 3 texels of 16 bits, but the manifest says 5 × 5 texels of 16 bits");
    }

    #[cfg(not(all(feature = "exr", feature = "tiff")))]
    #[test]
    fn a_format_that_was_left_out_is_named_with_its_feature() {
        for texel in TexelFormat::ALL.into_iter().filter(|texel| !texel.file().is_built()) {
            let (map, name) = (ramp(texel), texel.file().name());
            let message = map.to_bytes().unwrap_err().to_string();
            assert!(message.contains(&format!("feature `{name}` of planish-geometry")), "{message}");
            let read = Displacement::decode(&[], MapKind::Scalar, map.size, map.encoding);
            assert_eq!(read, Err(DecodeError::LeftOut { format: texel.file() }));
        }
    }
}
