//! Numbers of a volume from bytes.

use planish_render::settings::volume::{MAX_VALUES, SampleType};
use rayon::prelude::*;
use thiserror::Error;

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

/// Reason why bytes are not the values of a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub(super) enum NumbersError {
    #[error("has {found} bytes of values, but {} × {} × {} of type {} take {expected}", size[0], size[1], size[2], sample.name())]
    Length { found: usize, expected: u64, size: [u32; 3], sample: SampleType },
    #[error("{} × {} × {} values are none or too many: at most 2^28 are read", size[0], size[1], size[2])]
    Size { size: [u32; 3] },
}

/// Number of bytes that values take.
pub(super) fn byte_count(size: [u32; 3], sample: SampleType) -> Result<u64, NumbersError> {
    let count = size.iter().map(|n| u128::from(*n)).product::<u128>();
    if (1..=u128::from(MAX_VALUES)).contains(&count) {
        Ok(count as u64 * sample.bytes() as u64)
    } else {
        Err(NumbersError::Size { size })
    }
}

/// Reads values, in single precision.
pub(super) fn read(
    bytes: &[u8],
    size: [u32; 3],
    sample: SampleType,
    order: ByteOrder,
) -> Result<Vec<f32>, NumbersError> {
    let expected = byte_count(size, sample)?;
    if bytes.len() as u64 != expected {
        return Err(NumbersError::Length { found: bytes.len(), expected, size, sample });
    }
    macro_rules! read_as {
        ($number:ty) => {{
            const BYTES: usize = size_of::<$number>();
            let number = |bytes: &[u8]| {
                let mut own = [0; BYTES];
                own.copy_from_slice(bytes);
                match order {
                    ByteOrder::Little => <$number>::from_le_bytes(own) as f32,
                    ByteOrder::Big => <$number>::from_be_bytes(own) as f32,
                }
            };
            bytes.par_chunks_exact(BYTES).map(number).collect()
        }};
    }
    Ok(match sample {
        SampleType::U8 => read_as!(u8),
        SampleType::I8 => read_as!(i8),
        SampleType::U16 => read_as!(u16),
        SampleType::I16 => read_as!(i16),
        SampleType::U32 => read_as!(u32),
        SampleType::I32 => read_as!(i32),
        SampleType::F32 => read_as!(f32),
        SampleType::F64 => read_as!(f64),
    })
}
