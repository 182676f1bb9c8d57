//! Image files of displacement maps: texels to bytes and back. Each file format has a file of its own, and those that bring large
//! libraries are features of the crate.

#[cfg(feature = "exr")]
mod exr;
mod png;
#[cfg(feature = "tiff")]
mod tiff;

use super::format::{FileFormat, TexelFormat};
use crate::map::sampling::Size;

pub(crate) use png::encode as png;

/// Reason why an image cannot be encoded.
#[derive(Debug, thiserror::Error)]
#[error("the image cannot be encoded: {0}")]
pub struct EncodeError(String);

impl EncodeError {
    fn because(reason: &impl ToString) -> Self {
        Self(reason.to_string())
    }

    /// Fails for a format that this build was made without.
    pub(crate) fn unless_built(format: FileFormat) -> Result<(), Self> {
        if format.is_built() { Ok(()) } else { Err(Self(left_out(format))) }
    }
}

/// Message of a build that was made without a file format.
fn left_out(format: FileFormat) -> String {
    format!("this build has no {format}: it is the feature `{}` of planish-geometry", format.name())
}

/// Reasons why bytes are not the map that the manifest describes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DecodeError {
    /// The bytes are another kind of file, or a damaged one.
    #[error("not a readable {format} image: {reason}")]
    Image {
        /// Format that was expected.
        format: FileFormat,
        /// Message of the decoder.
        reason: String,
    },
    /// The format is a feature that the crate was built without.
    #[error("{}", left_out(*.format))]
    LeftOut {
        /// Format of the file.
        format: FileFormat,
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

/// Writes one plane or three, whose values the format can represent.
pub(super) fn encode(planes: &[Vec<f32>], size: Size, format: TexelFormat) -> Result<Vec<u8>, EncodeError> {
    match format.file() {
        FileFormat::Png => png::encode_texels(planes, size, format),
        #[cfg(feature = "exr")]
        FileFormat::Exr => exr::encode(planes, size, format),
        #[cfg(feature = "tiff")]
        FileFormat::Tiff => tiff::encode(planes, size, format),
        #[cfg(not(all(feature = "exr", feature = "tiff")))]
        format => Err(EncodeError(left_out(format))),
    }
}

fn interleaved<T>(planes: &[Vec<f32>], convert: impl Fn(f32) -> T) -> Vec<T> {
    let texels = planes.first().map_or(0, Vec::len);
    (0..texels).flat_map(|i| planes.iter().map(move |plane| plane[i])).map(convert).collect()
}

/// Planes of an image, one for grey or three for colours; texels row by row from the top.
pub(super) type Planes = Vec<Vec<f32>>;

/// Reads a number of planes and checks that the file has the expected size and texels. A few bytes may claim any size, so each
/// decoder compares the size in the header before it allocates anything.
pub(super) fn decode(bytes: &[u8], planes: usize, size: Size, format: TexelFormat) -> Result<Planes, DecodeError> {
    let expected = (size, format);
    let found = match format.file() {
        FileFormat::Png => png::decode(bytes, planes, expected)?,
        #[cfg(feature = "exr")]
        FileFormat::Exr => exr::decode(bytes, planes, expected)?,
        #[cfg(feature = "tiff")]
        FileFormat::Tiff => tiff::decode(bytes, planes, expected)?,
        #[cfg(not(all(feature = "exr", feature = "tiff")))]
        format => return Err(DecodeError::LeftOut { format }),
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
