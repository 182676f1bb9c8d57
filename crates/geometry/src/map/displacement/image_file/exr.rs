//! Displacement maps as EXR files.

use super::{DecodeError, Decoded, EncodeError};
use crate::map::displacement::format::{FileFormat, TexelFormat};
use crate::map::sampling::Size;
use exr::prelude as openexr;
use exr::prelude::{ReadChannels as _, ReadLayers as _, WritableImage as _};
use half::f16;
use std::io::Cursor;

/// Writes one plane or three as floating point of 16 or 32 bits.
pub(super) fn encode(planes: &[Vec<f32>], size: Size, format: TexelFormat) -> Result<Vec<u8>, EncodeError> {
    let samples = |plane: &Vec<f32>| match format.bits() {
        16 => openexr::FlatSamples::F16(plane.iter().map(|t| f16::from_f32(*t)).collect()),
        _ => openexr::FlatSamples::F32(plane.clone()),
    };
    encode_with(openexr::Compression::ZIP16, planes.iter().map(samples), size)
}

fn encode_with(
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

/// Largest number of channels of an EXR that is read: a map has three at most, and a program may add some.
const MOST_CHANNELS: usize = 16;

pub(super) fn decode(bytes: &[u8], planes: usize, expected: (Size, TexelFormat)) -> Result<Decoded, DecodeError> {
    let failed = |reason: String| DecodeError::Image { format: FileFormat::Exr, reason };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::displacement::image_file;

    #[test]
    fn an_exr_whose_compression_loses_digits_is_refused() {
        use openexr::Compression::{B44, B44A, PIZ, PXR24, RLE, Uncompressed, ZIP1, ZIP16};
        let size = Size::square(8);
        let texels: Vec<f32> = (0..64u8).map(|i| f32::from(i) / 64.0).collect();
        let written = |compression| {
            let plane = openexr::FlatSamples::F32(texels.clone());
            encode_with(compression, std::iter::once(plane), size).unwrap()
        };
        for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ] {
            let read = image_file::decode(&written(compression), 1, size, TexelFormat::Exr32);
            assert_eq!(read, Ok(vec![texels.clone()]), "{compression}");
        }
        for compression in [B44, B44A, PXR24] {
            let read = image_file::decode(&written(compression), 1, size, TexelFormat::Exr32).unwrap_err();
            assert!(read.to_string().contains("loses digits"), "{compression}: {read}");
        }
    }
}
