//! Texels with bias and scale, as bytes and back: height = bias + scale · texel, texel in 0..=1.

use crate::texture::{HeightMap, Size};
use exr::prelude as openexr;
use exr::prelude::{ReadChannels as _, ReadLayers as _, WritableImage as _};
use glam::Vec2;
use image::{DynamicImage, ImageFormat};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::io::Cursor;

/// Bits of a texel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "u32", try_from = "u32")]
pub enum Bits {
    /// Integers of 8 bits, PNG.
    Eight,
    /// Integers of 16 bits, PNG.
    #[default]
    Sixteen,
    /// Single precision, EXR.
    ThirtyTwo,
}

impl From<Bits> for u32 {
    fn from(bits: Bits) -> Self {
        match bits {
            Bits::Eight => 8,
            Bits::Sixteen => 16,
            Bits::ThirtyTwo => 32,
        }
    }
}

impl TryFrom<u32> for Bits {
    type Error = String;

    fn try_from(bits: u32) -> Result<Self, String> {
        match bits {
            8 => Ok(Self::Eight),
            16 => Ok(Self::Sixteen),
            32 => Ok(Self::ThirtyTwo),
            _ => Err(format!("a texel has 8, 16 or 32 bits, not {bits}")),
        }
    }
}

impl Bits {
    /// Ending of the file that holds such texels.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Eight | Self::Sixteen => "png",
            Self::ThirtyTwo => "exr",
        }
    }
    /// Number of steps between the lowest and the highest texel; none for floating point.
    fn steps(self) -> Option<f64> {
        match self {
            Self::Eight => Some(255.0),
            Self::Sixteen => Some(65535.0),
            Self::ThirtyTwo => None,
        }
    }
}

/// What turns texels into heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoding {
    /// Of a texel.
    pub bits: Bits,
    /// Height at texel 0, model units.
    pub bias: f32,
    /// Height at texel 1 minus that at texel 0, model units; not negative.
    pub scale: f32,
}

impl Encoding {
    /// Covers a range of heights, model units. Bias and scale are rounded outwards to single precision, which is what
    /// clients compute in.
    pub fn covering(low: f64, high: f64, bits: Bits) -> Self {
        let bias = if f64::from(low as f32) > low { (low as f32).next_down() } else { low as f32 };
        let base = f64::from(bias);
        let span = high - base;
        // What the difference lost by rounding (Knuth 1969): all of the smaller end, where the other one is huge.
        let part = span - high;
        let lost = (high - (span - part)) - (base + part);
        let span = if lost > 0.0 { span.next_up() } else { span };
        let scale = if f64::from(span as f32) < span { (span as f32).next_up() } else { span as f32 };
        Self { bits, bias, scale }
    }
    /// Step between two heights, model units: scale / (2ᵇ − 1). With floating point the spacing just below the
    /// largest texel, scale · 2⁻²⁴.
    pub fn quantum(self) -> f64 {
        f64::from(self.scale) / self.bits.steps().unwrap_or(16_777_216.0)
    }
}

/// A displacement map as the GPU has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Displacement {
    size: Size,
    encoding: Encoding,
    /// Row by row from the top, each a multiple of 1/(2ᵇ − 1) in 0..=1.
    texels: Vec<f32>,
}

/// Why bytes are not the map they should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// No PNG or EXR, or a damaged one.
    #[error("not a readable {format} image: {reason}")]
    Image {
        /// What it should be.
        format: &'static str,
        /// The decoder's words.
        reason: String,
    },
    /// Other texels than the manifest says.
    #[error("holds {found}, but the manifest says {expected}")]
    Texels {
        /// In the file.
        found: String,
        /// In the manifest.
        expected: String,
    },
}

impl Displacement {
    /// Quantises a map: each texel becomes the nearest one there is.
    pub fn encode(map: &HeightMap, encoding: Encoding) -> Self {
        let (bias, scale) = (f64::from(encoding.bias), f64::from(encoding.scale));
        let normalise =
            |height: f32| if scale > 0.0 { ((f64::from(height) - bias) / scale).clamp(0.0, 1.0) } else { 0.0 };
        let quantise = |height: &f32| match encoding.bits.steps() {
            // Unsigned normalised integers become floats as on GPUs: the nearest one to i / (2ᵇ − 1).
            Some(steps) => ((normalise(*height) * steps).round() / steps) as f32,
            None => normalise(*height) as f32,
        };
        Self { size: map.size, encoding, texels: map.texels.par_iter().map(quantise).collect() }
    }

    /// Of the image.
    pub fn size(&self) -> Size {
        self.size
    }
    /// Bits, bias and scale.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }
    /// Texels in 0..=1, row by row from the top.
    pub fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// The image file: grey PNG of 8 or 16 bits (linear, no gamma), or EXR with the one channel Y.
    pub fn to_bytes(&self) -> Result<Vec<u8>, image::ImageError> {
        let Size { width, height } = self.size;
        let integers = |steps: f32| self.texels.iter().map(move |t| (t * steps).round());
        match self.encoding.bits {
            Bits::Eight => {
                png(&integers(255.0).map(|t| t as u8).collect::<Vec<_>>(), self.size, image::ExtendedColorType::L8)
            }
            Bits::Sixteen => {
                let bytes: Vec<u8> = integers(65535.0).flat_map(|t| (t as u16).to_ne_bytes()).collect();
                png(&bytes, self.size, image::ExtendedColorType::L16)
            }
            Bits::ThirtyTwo => {
                let samples = openexr::FlatSamples::F32(self.texels.clone());
                let channel = openexr::AnyChannel::new("Y", samples);
                let layer = openexr::Layer::new(
                    (width as usize, height as usize),
                    openexr::LayerAttributes::default(),
                    openexr::Encoding {
                        compression: openexr::Compression::ZIP16,
                        blocks: openexr::Blocks::ScanLines,
                        line_order: openexr::LineOrder::Increasing,
                    },
                    openexr::AnyChannels::sort(vec![channel].into()),
                );
                let mut out = Cursor::new(Vec::new());
                let failed = |e: openexr::Error| image::ImageError::IoError(std::io::Error::other(e.to_string()));
                openexr::Image::from_layer(layer).write().to_buffered(&mut out).map_err(failed)?;
                Ok(out.into_inner())
            }
        }
    }

    /// Reads an image file back; it must be what the manifest says.
    pub fn decode(bytes: &[u8], size: Size, encoding: Encoding) -> Result<Self, DecodeError> {
        let (found, bits, texels) = match encoding.bits {
            Bits::Eight | Bits::Sixteen => decode_png(bytes)?,
            Bits::ThirtyTwo => decode_exr(bytes)?,
        };
        if (found, bits) != (size, encoding.bits) {
            let say =
                |size: Size, bits: Bits| format!("{} × {} texels of {} bits", size.width, size.height, u32::from(bits));
            return Err(DecodeError::Texels { found: say(found, bits), expected: say(size, encoding.bits) });
        }
        Ok(Self { size, encoding, texels })
    }

    /// Height at a texture coordinate (v up), model units: bilinear between texel centres, clamped at the border.
    ///
    /// Twin of `height_at` in `shaders/displace.wgsl`, operation by operation in single precision.
    pub fn height_at(&self, uv: Vec2) -> f32 {
        let Footprint { texels: [a, b, c, d], w } = Footprint::new(uv, self.size);
        // In this form equal texels give just that value, whatever the weight.
        let blend = |a: f32, b: f32, w: f32| a + (b - a) * w;
        let top = blend(self.texels[a], self.texels[b], w.x);
        let bottom = blend(self.texels[c], self.texels[d], w.x);
        self.encoding.bias + self.encoding.scale * blend(top, bottom, w.y)
    }
}

/// The texels that bilinear sampling blends at a texture coordinate, computed as the shader does it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    /// Places in the image: upper left, upper right, lower left, lower right.
    texels: [usize; 4],
    /// Shares of the right and of the lower ones.
    w: Vec2,
}

impl Footprint {
    pub(crate) fn new(uv: Vec2, size: Size) -> Self {
        let p = Vec2::new(uv.x, 1.0 - uv.y) * Vec2::new(size.width as f32, size.height as f32) - 0.5;
        let low = p.floor();
        // `as` saturates, as the clamp in the shader does.
        let column = |x: f32| (x as i64).clamp(0, i64::from(size.width) - 1) as usize;
        let row = |y: f32| (y as i64).clamp(0, i64::from(size.height) - 1) as usize;
        let texel = |x: f32, y: f32| row(y) * size.width as usize + column(x);
        let (right, below) = (low.x + 1.0, low.y + 1.0);
        let texels = [texel(low.x, low.y), texel(right, low.y), texel(low.x, below), texel(right, below)];
        Self { texels, w: p - low }
    }
    /// The different texels with their weights, which add up to one.
    pub(crate) fn weights(&self) -> impl Iterator<Item = (usize, f64)> {
        let (x, y) = (f64::from(self.w.x), f64::from(self.w.y));
        let mut weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
        let texels = self.texels;
        // At the border of the image two or four of them are the same one.
        for k in 1..4 {
            if let Some(first) = (0..k).find(|&j| texels[j] == texels[k]) {
                weights[first] += weights[k];
                weights[k] = 0.0;
            }
        }
        texels.into_iter().zip(weights).filter(|(_, w)| *w > 0.0)
    }
}

/// A PNG without gamma or colour profile; compressed fast, because noise hardly compresses.
pub(crate) fn png(bytes: &[u8], size: Size, colour: image::ExtendedColorType) -> Result<Vec<u8>, image::ImageError> {
    use image::ImageEncoder as _;
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    let mut out = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut out, CompressionType::Fast, FilterType::Adaptive);
    encoder.write_image(bytes, size.width, size.height, colour)?;
    Ok(out)
}

fn decode_png(bytes: &[u8]) -> Result<(Size, Bits, Vec<f32>), DecodeError> {
    let failed = |e: image::ImageError| DecodeError::Image { format: "PNG", reason: e.to_string() };
    let mut reader = image::ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    // Sizes are checked against the manifest, whose own are bounded.
    reader.no_limits();
    let image = reader.decode().map_err(failed)?;
    let size = Size { width: image.width(), height: image.height() };
    let sixteen = |samples: &[u16], channels: usize| {
        samples.iter().step_by(channels).map(|t| (f64::from(*t) / 65535.0) as f32).collect()
    };
    let eight = |samples: &[u8], channels: usize| {
        samples.iter().step_by(channels).map(|t| (f64::from(*t) / 255.0) as f32).collect()
    };
    // An editor may have saved the grey image in colour; a shader would read red.
    let (bits, texels) = match &image {
        DynamicImage::ImageLuma16(i) => (Bits::Sixteen, sixteen(i, 1)),
        DynamicImage::ImageLumaA16(i) => (Bits::Sixteen, sixteen(i, 2)),
        DynamicImage::ImageRgb16(i) => (Bits::Sixteen, sixteen(i, 3)),
        DynamicImage::ImageRgba16(i) => (Bits::Sixteen, sixteen(i, 4)),
        DynamicImage::ImageLuma8(i) => (Bits::Eight, eight(i, 1)),
        DynamicImage::ImageLumaA8(i) => (Bits::Eight, eight(i, 2)),
        DynamicImage::ImageRgb8(i) => (Bits::Eight, eight(i, 3)),
        other => (Bits::Eight, eight(&other.to_rgba8(), 4)),
    };
    Ok((size, bits, texels))
}

fn decode_exr(bytes: &[u8]) -> Result<(Size, Bits, Vec<f32>), DecodeError> {
    let failed = |e: openexr::Error| DecodeError::Image { format: "EXR", reason: e.to_string() };
    let reader =
        openexr::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = reader.from_buffered(Cursor::new(bytes)).map_err(failed)?;
    let size = image.layer_data.size;
    let size = Size { width: size.width() as u32, height: size.height() as u32 };
    let channels = &image.layer_data.channel_data.list;
    let named = |name: &str| channels.iter().find(|c| c.name.eq_case_insensitive(name));
    let Some(channel) = named("Y").or_else(|| named("R")) else {
        return Err(DecodeError::Image { format: "EXR", reason: "there is no channel Y or R".to_owned() });
    };
    Ok((size, Bits::ThirtyTwo, channel.sample_data.values_as_f32().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(bits: Bits) -> Displacement {
        let size = Size { width: 5, height: 3 };
        let texels: Vec<f32> = (0..15u8).map(|i| -0.3 + 0.05 * f32::from(i)).collect();
        let encoding = Encoding::covering(-0.3, 0.4, bits);
        Displacement::encode(&HeightMap { size, texels }, encoding)
    }

    #[test]
    fn bytes_read_back_to_the_same_texels() {
        for bits in [Bits::Eight, Bits::Sixteen, Bits::ThirtyTwo] {
            let map = ramp(bits);
            let read = Displacement::decode(&map.to_bytes().unwrap(), map.size, map.encoding).unwrap();
            assert_eq!(read, map, "{bits:?}");
        }
    }

    #[test]
    fn a_texel_is_off_by_half_a_quantum_at_most() {
        for bits in [Bits::Eight, Bits::Sixteen, Bits::ThirtyTwo] {
            let map = ramp(bits);
            let encoding = map.encoding;
            for (i, texel) in (0u8..).zip(&map.texels) {
                let height = f64::from(encoding.bias) + f64::from(encoding.scale) * f64::from(*texel);
                let true_height = f64::from(-0.3 + 0.05 * f32::from(i));
                // The texel itself is rounded to single precision.
                let slack = 2f64.powi(-25) * f64::from(encoding.scale);
                assert!((height - true_height).abs() <= encoding.quantum() / 2.0 + slack, "{bits:?}");
            }
        }
    }

    #[test]
    fn the_range_is_never_cut() {
        for (low, high) in [(-0.1, 0.1), (1e-9, 1.0 / 3.0), (-1e10, 1e-3), (2.0, 2.0), (0.0, 0.0)] {
            let e = Encoding::covering(low, high, Bits::Sixteen);
            assert!(f64::from(e.bias) <= low && f64::from(e.bias) + f64::from(e.scale) >= high, "{e:?}");
        }
    }

    #[test]
    fn heights_at_texel_centres_are_the_texels_and_the_border_is_clamped() {
        let map = ramp(Bits::ThirtyTwo);
        let height = |texel: f32| map.encoding.bias + map.encoding.scale * texel;
        for i in 0..15 {
            let uv = map.size.uv_from_texel(i % 5, i / 5).as_vec2();
            // (i + ½)/5 is not exact in single precision: a texel's share of 1e-6 of the step to its neighbour.
            assert!((map.height_at(uv) - height(map.texels[i])).abs() < 1e-6);
        }
        assert_eq!(map.height_at(Vec2::new(-3.0, 9.0)), height(map.texels[0]));
        assert_eq!(map.height_at(Vec2::new(1e30, -1e30)), height(map.texels[14]));
        let between = map.height_at(Vec2::new(0.2, 1.0 - 0.5 / 3.0));
        assert!((between - height((map.texels[0] + map.texels[1]) / 2.0)).abs() < 1e-6);
    }

    #[test]
    fn broken_and_foreign_images_are_refused() {
        let map = ramp(Bits::Sixteen);
        let bytes = map.to_bytes().unwrap();
        let cut = Displacement::decode(&bytes[..bytes.len() / 2], map.size, map.encoding);
        assert!(matches!(cut, Err(DecodeError::Image { .. })));
        let other = Displacement::decode(&bytes, Size::square(5), map.encoding).unwrap_err();
        assert_eq!(other.to_string(), "holds 5 × 3 texels of 16 bits, but the manifest says 5 × 5 texels of 16 bits");
    }
}
