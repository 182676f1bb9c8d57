//! Displacement maps as TIFF files.

use super::{DecodeError, Decoded, EncodeError, deinterleaved, interleaved};
use crate::map::displacement::format::{FileFormat, TexelFormat};
use crate::map::sampling::Size;
use std::io::Cursor;
use tiff::decoder::DecodingResult;
use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, colortype};

/// Writes one plane or three as integers of 16 bits or floating point of 32.
pub(super) fn encode(planes: &[Vec<f32>], size: Size, format: TexelFormat) -> Result<Vec<u8>, EncodeError> {
    let is_grey = planes.len() == 1;
    if format.bits() == 16 {
        let texels = interleaved(planes, |t| (t * 65535.0).round() as u16);
        if is_grey { write::<colortype::Gray16>(&texels, size) } else { write::<colortype::RGB16>(&texels, size) }
    } else {
        let texels = interleaved(planes, |t| t);
        if is_grey {
            write::<colortype::Gray32Float>(&texels, size)
        } else {
            write::<colortype::RGB32Float>(&texels, size)
        }
    }
}

fn write<C: colortype::ColorType>(texels: &[C::Inner], size: Size) -> Result<Vec<u8>, EncodeError>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut out = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut out).map_err(|e| EncodeError::because(&e))?;
    let mut encoder = encoder.with_compression(Compression::Deflate(DeflateLevel::Fast));
    encoder.write_image::<C>(size.width, size.height, texels).map_err(|e| EncodeError::because(&e))?;
    Ok(out.into_inner())
}

/// Bytes that a tile may have besides those of the image.
const TIFF_MARGIN: usize = 1 << 22;

pub(super) fn decode(bytes: &[u8], planes: usize, expected: (Size, TexelFormat)) -> Result<Decoded, DecodeError> {
    let failed = |e: tiff::TiffError| DecodeError::Image { format: FileFormat::Tiff, reason: e.to_string() };
    let decoder = tiff::decoder::Decoder::new(Cursor::new(bytes)).map_err(failed)?;
    // A texel has at most four channels of 32 bits, and no list is longer than the file.
    let mut limits = tiff::decoder::Limits::unlimited();
    limits.decoding_buffer_size = 16 * expected.0.texels();
    // A tile may reach beyond a small image.
    limits.intermediate_buffer_size = limits.decoding_buffer_size + TIFF_MARGIN;
    limits.ifd_value_size = bytes.len();
    let mut decoder = decoder.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(failed)?;
    let size = Size { width, height };
    if size != expected.0 {
        return Err(DecodeError::texels((size, None), expected));
    }
    let channels = usize::from(decoder.colortype().map_err(failed)?.num_samples());
    let (format, planes) = match decoder.read_image().map_err(failed)? {
        DecodingResult::U16(samples) => {
            let unit = |t: u16| (f64::from(t) / 65535.0) as f32;
            (TexelFormat::Tiff16, deinterleaved(&samples, channels, planes, unit))
        }
        DecodingResult::F32(samples) => (TexelFormat::Tiff32, deinterleaved(&samples, channels, planes, |t| t)),
        _ => {
            let reason = "its texels are neither 16-bit integers nor 32-bit floats".to_owned();
            return Err(DecodeError::Image { format: FileFormat::Tiff, reason });
        }
    };
    Ok(Decoded { size, format, planes })
}
