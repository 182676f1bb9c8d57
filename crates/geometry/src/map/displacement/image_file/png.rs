//! Displacement maps as PNG files.

use super::{DecodeError, Decoded, EncodeError, deinterleaved, interleaved};
use crate::map::displacement::format::{FileFormat, TexelFormat};
use crate::map::sampling::Size;
use image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageDecoder as _, ImageEncoder as _};
use std::io::Cursor;

/// Writes one plane or three as integers of 8 or 16 bits.
pub(super) fn encode_texels(planes: &[Vec<f32>], size: Size, format: TexelFormat) -> Result<Vec<u8>, EncodeError> {
    let is_grey = planes.len() == 1;
    if format.bits() == 8 {
        let colour = if is_grey { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
        encode(&interleaved(planes, |t| (t * 255.0).round() as u8), size, colour)
    } else {
        let colour = if is_grey { ExtendedColorType::L16 } else { ExtendedColorType::Rgb16 };
        let texels = interleaved(planes, |t| ((t * 65535.0).round() as u16).to_ne_bytes());
        encode(texels.as_flattened(), size, colour)
    }
}

/// Encodes a PNG without gamma and colour profile, with fast compression, because noise hardly compresses.
pub(crate) fn encode(bytes: &[u8], size: Size, colour: ExtendedColorType) -> Result<Vec<u8>, EncodeError> {
    let mut out = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut out, CompressionType::Fast, FilterType::Adaptive);
    encoder.write_image(bytes, size.width, size.height, colour).map_err(|e| EncodeError::because(&e))?;
    Ok(out)
}

/// Bytes that a decoder may allocate besides the texels, for texts and colour profiles.
const DECODER_MARGIN: usize = 1 << 26;

pub(super) fn decode(bytes: &[u8], planes: usize, expected: (Size, TexelFormat)) -> Result<Decoded, DecodeError> {
    let failed = |e: image::ImageError| DecodeError::Image { format: FileFormat::Png, reason: e.to_string() };
    let mut limits = image::Limits::no_limits();
    // A texel has at most four channels of 16 bits.
    limits.max_alloc = Some((8 * expected.0.texels() + DECODER_MARGIN) as u64);
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(failed)?;
    let (width, height) = decoder.dimensions();
    let size = Size { width, height };
    if size != expected.0 {
        let bits = 8 * u32::from(decoder.color_type().bytes_per_pixel() / decoder.color_type().channel_count());
        return Err(DecodeError::texels((size, TexelFormat::new(FileFormat::Png, bits)), expected));
    }
    let image = DynamicImage::from_decoder(decoder).map_err(failed)?;
    // Unsigned normalised integers become floats as on GPUs: the nearest one to i / (2ᵇ − 1).
    let sixteen =
        |samples: &[u16], channels| deinterleaved(samples, channels, planes, |t| (f64::from(t) / 65535.0) as f32);
    let eight = |samples: &[u8], channels| deinterleaved(samples, channels, planes, |t| (f64::from(t) / 255.0) as f32);
    // An editor may have saved the grey image in colour; a shader would read red.
    let (format, planes) = match &image {
        DynamicImage::ImageLuma16(i) => (TexelFormat::Png16, sixteen(i, 1)),
        DynamicImage::ImageLumaA16(i) => (TexelFormat::Png16, sixteen(i, 2)),
        DynamicImage::ImageRgb16(i) => (TexelFormat::Png16, sixteen(i, 3)),
        DynamicImage::ImageRgba16(i) => (TexelFormat::Png16, sixteen(i, 4)),
        DynamicImage::ImageLuma8(i) => (TexelFormat::Png8, eight(i, 1)),
        DynamicImage::ImageLumaA8(i) => (TexelFormat::Png8, eight(i, 2)),
        DynamicImage::ImageRgb8(i) => (TexelFormat::Png8, eight(i, 3)),
        other => (TexelFormat::Png8, eight(&other.to_rgba8(), 4)),
    };
    Ok(Decoded { size, format, planes })
}
