//! Encoding of texels as image files.

use super::format::TexelFormat;
use crate::map::sampling::Size;
use exr::prelude as openexr;
use exr::prelude::WritableImage as _;
use half::f16;
use image::ExtendedColorType;
use std::io::Cursor;
use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, colortype};

/// Reason why an image cannot be encoded.
#[derive(Debug, thiserror::Error)]
#[error("the image cannot be encoded: {0}")]
pub struct EncodeError(String);

impl EncodeError {
    fn because(reason: &impl ToString) -> Self {
        Self(reason.to_string())
    }
}

/// Writes one plane or three, whose values the format can represent.
pub(super) fn encode(planes: &[Vec<f32>], size: Size, format: TexelFormat) -> Result<Vec<u8>, EncodeError> {
    match format {
        TexelFormat::Png8 => {
            let colour = if planes.len() == 1 { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
            png(&interleaved(planes, |t| (t * 255.0).round() as u8), size, colour)
        }
        TexelFormat::Png16 => {
            let colour = if planes.len() == 1 { ExtendedColorType::L16 } else { ExtendedColorType::Rgb16 };
            let texels = interleaved(planes, |t| ((t * 65535.0).round() as u16).to_ne_bytes());
            png(texels.as_flattened(), size, colour)
        }
        TexelFormat::Tiff16 => {
            let texels = interleaved(planes, |t| (t * 65535.0).round() as u16);
            if planes.len() == 1 {
                tiff::<colortype::Gray16>(&texels, size)
            } else {
                tiff::<colortype::RGB16>(&texels, size)
            }
        }
        TexelFormat::Tiff32 => {
            let texels = interleaved(planes, |t| t);
            if planes.len() == 1 {
                tiff::<colortype::Gray32Float>(&texels, size)
            } else {
                tiff::<colortype::RGB32Float>(&texels, size)
            }
        }
        TexelFormat::Exr16 => {
            let half = |plane: &Vec<f32>| plane.iter().map(|t| f16::from_f32(*t)).collect();
            exr(planes.iter().map(|plane| openexr::FlatSamples::F16(half(plane))), size)
        }
        TexelFormat::Exr32 => exr(planes.iter().map(|plane| openexr::FlatSamples::F32(plane.clone())), size),
    }
}

fn interleaved<T>(planes: &[Vec<f32>], convert: impl Fn(f32) -> T) -> Vec<T> {
    let texels = planes.first().map_or(0, Vec::len);
    (0..texels).flat_map(|i| planes.iter().map(move |plane| plane[i])).map(convert).collect()
}

/// Encodes a PNG without gamma and colour profile, with fast compression, because noise hardly compresses.
pub(crate) fn png(bytes: &[u8], size: Size, colour: ExtendedColorType) -> Result<Vec<u8>, EncodeError> {
    use image::ImageEncoder as _;
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    let mut out = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut out, CompressionType::Fast, FilterType::Adaptive);
    encoder.write_image(bytes, size.width, size.height, colour).map_err(|e| EncodeError::because(&e))?;
    Ok(out)
}

fn exr(planes: impl Iterator<Item = openexr::FlatSamples>, size: Size) -> Result<Vec<u8>, EncodeError> {
    exr_with(openexr::Compression::ZIP16, planes, size)
}

pub(super) fn exr_with(
    compression: openexr::Compression,
    planes: impl Iterator<Item = openexr::FlatSamples>,
    size: Size,
) -> Result<Vec<u8>, EncodeError> {
    let planes: Vec<_> = planes.collect();
    let names: &[&str] = if planes.len() == 1 { &["Y"] } else { &["R", "G", "B"] };
    let channels = names.iter().zip(planes).map(|(name, samples)| openexr::AnyChannel::new(*name, samples)).collect();
    let layer = openexr::Layer::new(
        (size.width as usize, size.height as usize),
        openexr::LayerAttributes::default(),
        openexr::Encoding {
            compression,
            blocks: openexr::Blocks::ScanLines,
            line_order: openexr::LineOrder::Increasing,
        },
        openexr::AnyChannels::sort(channels),
    );
    let mut out = Cursor::new(Vec::new());
    openexr::Image::from_layer(layer).write().to_buffered(&mut out).map_err(|e| EncodeError::because(&e))?;
    Ok(out.into_inner())
}

fn tiff<C: colortype::ColorType>(texels: &[C::Inner], size: Size) -> Result<Vec<u8>, EncodeError>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut out = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut out).map_err(|e| EncodeError::because(&e))?;
    let mut encoder = encoder.with_compression(Compression::Deflate(DeflateLevel::Fast));
    encoder.write_image::<C>(size.width, size.height, texels).map_err(|e| EncodeError::because(&e))?;
    Ok(out.into_inner())
}
