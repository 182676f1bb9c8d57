//! File formats and texel formats of displacement maps.

use crate::named;
use serde::{Deserialize, Serialize};

named! {
    /// File format of a displacement map.
    pub enum FileFormat {
        /// 8 or 16 bits of unsigned integers, linear.
        Png = "png",
        /// 16 (half) or 32 bits of floating point, in the channel Y, or in R, G and B.
        Exr = "exr",
        /// 16 bits of unsigned integers or 32 of floating point, linear.
        Tiff = "tiff",
    }
}

impl std::fmt::Display for FileFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Png => "PNG",
            Self::Exr => "EXR",
            Self::Tiff => "TIFF",
        })
    }
}

impl FileFormat {
    /// Extension of file names, without a dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
            Self::Tiff => "tif",
        }
    }
    /// Tells whether this build of the crate reads and writes the format: EXR and TIFF are features.
    pub fn is_built(self) -> bool {
        match self {
            Self::Png => true,
            Self::Exr => cfg!(feature = "exr"),
            Self::Tiff => cfg!(feature = "tiff"),
        }
    }
    /// Media type (MIME type) of the format.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Exr => "image/x-exr",
            Self::Tiff => "image/tiff",
        }
    }
}

/// Format of a texel, and of the file that holds it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "Parts", try_from = "Parts")]
pub enum TexelFormat {
    /// PNG with integers of 8 bits.
    Png8,
    /// PNG with integers of 16 bits.
    #[default]
    Png16,
    /// TIFF with integers of 16 bits.
    Tiff16,
    /// TIFF with floating point of 32 bits (single precision).
    Tiff32,
    /// EXR with floating point of 16 bits (half precision).
    Exr16,
    /// EXR with floating point of 32 bits (single precision).
    Exr32,
}

/// A texel format as the two fields that a manifest has for it.
#[derive(Serialize, Deserialize)]
struct Parts {
    format: FileFormat,
    bits: u32,
}

impl From<TexelFormat> for Parts {
    fn from(texel: TexelFormat) -> Self {
        Self { format: texel.file(), bits: texel.bits() }
    }
}

impl TryFrom<Parts> for TexelFormat {
    type Error = String;

    fn try_from(Parts { format, bits }: Parts) -> Result<Self, String> {
        Self::new(format, bits).ok_or_else(|| format!("field `bits`: there are no {bits}-bit texels in {format} files"))
    }
}

/// Storage of numbers in 0..=1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stored {
    /// Numbers are i / n for i in 0..=n.
    Integers(u16),
    /// Numbers have 11 significant bits.
    Half,
    /// Numbers have 24 significant bits.
    Single,
}

impl TexelFormat {
    /// All formats.
    pub const ALL: [Self; 6] = [Self::Png8, Self::Png16, Self::Tiff16, Self::Tiff32, Self::Exr16, Self::Exr32];

    /// Finds the format with this file format and number of bits a channel; `None` if there is none.
    pub fn new(file: FileFormat, bits: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|format| (format.file(), format.bits()) == (file, bits))
    }
    /// Format of the file.
    pub fn file(self) -> FileFormat {
        match self {
            Self::Png8 | Self::Png16 => FileFormat::Png,
            Self::Tiff16 | Self::Tiff32 => FileFormat::Tiff,
            Self::Exr16 | Self::Exr32 => FileFormat::Exr,
        }
    }
    /// Number of bits of a channel: 8, 16 or 32.
    pub fn bits(self) -> u32 {
        match self {
            Self::Png8 => 8,
            Self::Png16 | Self::Tiff16 | Self::Exr16 => 16,
            Self::Tiff32 | Self::Exr32 => 32,
        }
    }
    /// Storage of a texel of this format.
    pub(super) fn stored(self) -> Stored {
        match self {
            Self::Png8 => Stored::Integers(255),
            Self::Png16 | Self::Tiff16 => Stored::Integers(65535),
            Self::Exr16 => Stored::Half,
            Self::Tiff32 | Self::Exr32 => Stored::Single,
        }
    }
}

impl std::fmt::Display for TexelFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kind = match self.stored() {
            Stored::Integers(_) => "bits",
            Stored::Half | Stored::Single => "bits (floating point)",
        };
        write!(f, "{} {kind}", self.bits())
    }
}
