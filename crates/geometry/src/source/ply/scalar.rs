//! Types of numbers in PLY files, and their bytes.

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// How numbers become bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

impl Scalar {
    /// Type by its name, old or new.
    pub(super) fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }
    /// Number of bytes in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
    /// Returns true for whole numbers.
    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
    /// Largest value of a whole number, by which colours are divided; 1 for others.
    pub(super) fn full(self) -> f64 {
        match self {
            Self::I8 => i8::MAX.into(),
            Self::U8 => u8::MAX.into(),
            Self::I16 => i16::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::I32 => i32::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::F32 | Self::F64 => 1.0,
        }
    }

    /// Value of a number in a binary file; `bytes` has the size of the type.
    pub(super) fn read(self, bytes: &[u8], encoding: Encoding) -> f64 {
        let mut number = [0; 8];
        let number = &mut number[..self.size()];
        number.copy_from_slice(bytes);
        if encoding == Encoding::Big {
            number.reverse();
        }
        match *number {
            [a] if self == Self::I8 => i8::from_le_bytes([a]).into(),
            [a] => a.into(),
            [a, b] if self == Self::I16 => i16::from_le_bytes([a, b]).into(),
            [a, b] => u16::from_le_bytes([a, b]).into(),
            [a, b, c, d] if self == Self::I32 => i32::from_le_bytes([a, b, c, d]).into(),
            [a, b, c, d] if self == Self::U32 => u32::from_le_bytes([a, b, c, d]).into(),
            [a, b, c, d] => f32::from_le_bytes([a, b, c, d]).into(),
            [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
            _ => f64::NAN,
        }
    }

    /// Number of this type that is nearest to a value.
    pub(super) fn nearest(self, x: f64) -> f64 {
        match self {
            // A cast of a float to an integer rounds towards zero and ends at the limits of the type.
            Self::I8 => f64::from(x.round() as i8),
            Self::U8 => f64::from(x.round() as u8),
            Self::I16 => f64::from(x.round() as i16),
            Self::U16 => f64::from(x.round() as u16),
            Self::I32 => f64::from(x.round() as i32),
            Self::U32 => f64::from(x.round() as u32),
            Self::F32 => f64::from(x as f32),
            Self::F64 => x,
        }
    }

    /// Appends the number of this type that is nearest to a value.
    pub(super) fn write(self, x: f64, encoding: Encoding, out: &mut Vec<u8>) {
        if encoding == Encoding::Text {
            match self {
                Self::F32 => crate::source::patch::push_number(out, x as f32),
                Self::F64 => crate::source::patch::push_number(out, x),
                _ => out.extend_from_slice(itoa::Buffer::new().format(self.nearest(x) as i64).as_bytes()),
            }
            return;
        }
        let start = out.len();
        match self {
            Self::I8 => out.extend((x.round() as i8).to_le_bytes()),
            Self::U8 => out.extend((x.round() as u8).to_le_bytes()),
            Self::I16 => out.extend((x.round() as i16).to_le_bytes()),
            Self::U16 => out.extend((x.round() as u16).to_le_bytes()),
            Self::I32 => out.extend((x.round() as i32).to_le_bytes()),
            Self::U32 => out.extend((x.round() as u32).to_le_bytes()),
            Self::F32 => out.extend((x as f32).to_le_bytes()),
            Self::F64 => out.extend(x.to_le_bytes()),
        }
        if encoding == Encoding::Big {
            out[start..].reverse();
        }
    }
}
