//! Decoding of image files as texels.

use super::format::{FileFormat, TexelFormat};
use crate::map::sampling::Size;
use exr::prelude as openexr;
use exr::prelude::{ReadChannels as _, ReadLayers as _};
use image::{DynamicImage, ImageDecoder as _};
use std::io::Cursor;
use tiff::decoder::DecodingResult;

/// Reasons why bytes are not the map that the manifest describes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DecodeError {
    /// The bytes are another kind of file, or a damaged one.
    #[error("not a readable {format} image: {reason}")]
    Image {
        /// Format that was expected.
        format: &'static str,
        /// Message of the decoder.
        reason: String,
    },
    /// The image has another size or other texels than the manifest says.
    #[error("holds {found}, but the manifest says {expected}")]
    Texels {
        /// Size and texels of the file.
        found: String,
        /// Size and texels according to the manifest.
        expected: String,
    },
    /// A texel is NaN or infinite.
    #[error("the texel in column {column} of row {row} is not finite (counted from 0)")]
    NotFinite {
        /// Column of the texel, from 0.
        column: usize,
        /// Row of the texel, from 0 on top.
        row: usize,
    },
}

impl DecodeError {
    /// Error of an image that is not as expected; the format of the texels may not be known from its header.
    fn texels(found: (Size, Option<TexelFormat>), (size, format): (Size, TexelFormat)) -> Self {
        let say = |size: Size, format: Option<TexelFormat>| {
            let of = format.map(|format| format!(" of {format}")).unwrap_or_default();
            format!("{} × {} texels{of}", size.width, size.height)
        };
        Self::Texels { found: say(found.0, found.1), expected: say(size, found.1.map(|_| format)) }
    }
}

/// Planes of an image, one for grey or three for colours; texels row by row from the top.
pub(super) type Planes = Vec<Vec<f32>>;

/// Reads a number of planes and checks that the file has the expected size and texels. A few bytes may claim any size, so each
/// decoder compares the size in the header before it allocates anything.
pub(super) fn decode(bytes: &[u8], planes: usize, size: Size, format: TexelFormat) -> Result<Planes, DecodeError> {
    let expected = (size, format);
    let found = match format.file() {
        FileFormat::Png => decode_png(bytes, planes, expected)?,
        FileFormat::Exr => decode_exr(bytes, planes, expected)?,
        FileFormat::Tiff => decode_tiff(bytes, planes, expected)?,
    };
    if (found.size, found.format) != expected {
        return Err(DecodeError::texels((found.size, Some(found.format)), expected));
    }
    let broken = found.planes.iter().find_map(|plane| plane.iter().position(|texel| !texel.is_finite()));
    if let Some(texel) = broken {
        let width = size.width as usize;
        return Err(DecodeError::NotFinite { column: texel % width, row: texel / width });
    }
    Ok(found.planes)
}

struct Decoded {
    size: Size,
    format: TexelFormat,
    planes: Planes,
}

/// Separates the first `planes` channels of an image with `channels` of them. If three planes are asked for, grey stands for
/// all, because an editor may have merged three equal channels.
fn deinterleaved<T: Copy>(samples: &[T], channels: usize, planes: usize, convert: impl Fn(T) -> f32) -> Planes {
    // An image with two channels is grey with opacity.
    let colours = if channels < 3 { 1 } else { 3 };
    let plane = |k: usize| samples.iter().skip(k.min(colours - 1)).step_by(channels).map(|t| convert(*t)).collect();
    (0..planes).map(plane).collect()
}

/// Bytes that a decoder may allocate besides the texels, for texts and colour profiles.
const DECODER_MARGIN: usize = 1 << 26;

fn decode_png(bytes: &[u8], planes: usize, expected: (Size, TexelFormat)) -> Result<Decoded, DecodeError> {
    let failed = |e: image::ImageError| DecodeError::Image { format: "PNG", reason: e.to_string() };
    let mut limits = image::Limits::no_limits();
    // A texel has at most four channels of 16 bits.
    limits.max_alloc = Some((8 * expected.0.texels() + DECODER_MARGIN) as u64);
    let decoder = image::codecs::png::PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(failed)?;
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

/// Largest number of channels of an EXR that is read: a map has three at most, and a program may add some.
const MOST_CHANNELS: usize = 16;

fn decode_exr(bytes: &[u8], planes: usize, expected: (Size, TexelFormat)) -> Result<Decoded, DecodeError> {
    let failed = |reason: String| DecodeError::Image { format: "EXR", reason };
    let meta = openexr::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| failed(e.to_string()))?;
    if let Some(layer) = meta.headers.iter().find(|layer| !layer.deep) {
        let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let size = Size { width: side(layer.layer_size.width()), height: side(layer.layer_size.height()) };
        if size != expected.0 {
            return Err(DecodeError::texels((size, None), expected));
        }
        use openexr::Compression::{PIZ, RLE, Uncompressed, ZIP1, ZIP16};
        // The others lose digits, which a map cannot spare, and their decoders trust the file.
        if !matches!(layer.compression, Uncompressed | RLE | ZIP1 | ZIP16 | PIZ) {
            return Err(failed(format!("its compression ({}) loses digits", layer.compression)));
        }
        let channels = layer.channels.list.len();
        if channels > MOST_CHANNELS {
            return Err(failed(format!("it has {channels} channels, and at most {MOST_CHANNELS} are read")));
        }
    }
    let reader =
        openexr::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = reader.from_buffered(Cursor::new(bytes)).map_err(|e| failed(e.to_string()))?;
    let size = image.layer_data.size;
    let size = Size { width: size.width() as u32, height: size.height() as u32 };
    let channels = &image.layer_data.channel_data.list;
    let named = |name: &str| channels.iter().find(|c| c.name.eq_case_insensitive(name));
    let found = if planes == 1 {
        named("Y").or_else(|| named("R")).map(|c| vec![c]).ok_or("there is no channel Y or R")
    } else {
        ["R", "G", "B"].into_iter().map(named).collect::<Option<Vec<_>>>().ok_or("there are no channels R, G and B")
    };
    let found = found.map_err(|reason| failed(reason.to_owned()))?;
    let is_half = found.iter().all(|c| matches!(c.sample_data, openexr::FlatSamples::F16(_)));
    let format = if is_half { TexelFormat::Exr16 } else { TexelFormat::Exr32 };
    Ok(Decoded { size, format, planes: found.iter().map(|c| c.sample_data.values_as_f32().collect()).collect() })
}

/// Bytes that a tile may have besides those of the image.
const TIFF_MARGIN: usize = 1 << 22;

fn decode_tiff(bytes: &[u8], planes: usize, expected: (Size, TexelFormat)) -> Result<Decoded, DecodeError> {
    let failed = |e: tiff::TiffError| DecodeError::Image { format: "TIFF", reason: e.to_string() };
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
            return Err(DecodeError::Image { format: "TIFF", reason });
        }
    };
    Ok(Decoded { size, format, planes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::displacement::encode::exr_with;

    #[test]
    fn an_exr_whose_compression_loses_digits_is_refused() {
        use openexr::Compression::{B44, B44A, PIZ, PXR24, RLE, Uncompressed, ZIP1, ZIP16};
        let size = Size::square(8);
        let texels: Vec<f32> = (0..64u8).map(|i| f32::from(i) / 64.0).collect();
        let written = |compression| {
            let plane = openexr::FlatSamples::F32(texels.clone());
            exr_with(compression, std::iter::once(plane), size).unwrap()
        };
        for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ] {
            let read = decode(&written(compression), 1, size, TexelFormat::Exr32);
            assert_eq!(read, Ok(vec![texels.clone()]), "{compression}");
        }
        for compression in [B44, B44A, PXR24] {
            let read = decode(&written(compression), 1, size, TexelFormat::Exr32).unwrap_err();
            assert!(read.to_string().contains("loses digits"), "{compression}: {read}");
        }
    }
}
