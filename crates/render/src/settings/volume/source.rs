//! Origin of the values of a volume.

use crate::settings::rules::{SettingsError, named, require};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Largest number of values of a volume: a gibibyte in single precision.
pub const MAX_VALUES: u64 = 1 << 28;

/// Origin of a volume; relative paths are from the working directory. Computing distances and reading files is the caller's work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VolumeSource {
    /// Signed distance to the mesh as it was read, negative inside, on a grid.
    Distance {
        /// Number of values along the longest side of the grid.
        size: u32,
    },
    /// A file that says what is in it (NRRD).
    File(PathBuf),
    /// A file of bare numbers.
    Raw(RawVolume),
}

impl Default for VolumeSource {
    fn default() -> Self {
        Self::Distance { size: 96 }
    }
}

/// File of bare numbers, the first axis fastest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawVolume {
    /// Path of the file.
    pub file: PathBuf,
    /// Number of values along each axis.
    pub size: [u32; 3],
    /// Type of the values, little-endian.
    #[serde(rename = "type")]
    pub sample: SampleType,
    /// Lengths of the sides of a voxel, in any unit.
    #[serde(default = "unit_spacing")]
    pub spacing: [f32; 3],
}

fn unit_spacing() -> [f32; 3] {
    [1.0; 3]
}

named! {
/// Type of the numbers in a file.
pub enum SampleType {
    /// Integers of 8 bits, 0..=255.
    #[default]
    U8 = "u8",
    /// Integers of 8 bits with a sign.
    I8 = "i8",
    /// Integers of 16 bits.
    U16 = "u16",
    /// Integers of 16 bits with a sign.
    I16 = "i16",
    /// Integers of 32 bits.
    U32 = "u32",
    /// Integers of 32 bits with a sign.
    I32 = "i32",
    /// Single precision.
    F32 = "f32",
    /// Double precision.
    F64 = "f64",
}
}

impl SampleType {
    /// Returns the bytes that a number takes.
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

named! {
/// Position of the box of a volume.
pub enum Placement {
    /// Where its file says; around the mesh if the file says nothing.
    #[default]
    File = "file",
    /// As small as it can be around the mesh, with the same middle and voxels of the same shape.
    Fit = "fit",
}
}

impl VolumeSource {
    /// Refuses sizes that are too large.
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        match self {
            Self::Distance { size } => require(&[((2..=512).contains(size), "volume.source.distance.size", "2..512")]),
            Self::File(_) => Ok(()),
            Self::Raw(RawVolume { size, spacing, .. }) => require(&[
                (size.iter().all(|n| (1..=4096).contains(n)), "volume.source.raw.size", "1..4096 along each axis"),
                (
                    size.iter().map(|n| u64::from(*n)).product::<u64>() <= MAX_VALUES,
                    "volume.source.raw.size",
                    "at most 2^28 values",
                ),
                (spacing.iter().all(|s| (1e-6..=1e6).contains(s)), "volume.source.raw.spacing", "0.000001..1000000"),
            ]),
        }
    }
}
