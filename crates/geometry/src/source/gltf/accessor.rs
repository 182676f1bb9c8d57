//! Accessors of a glTF file: numbers in a view of a buffer.

use super::container::Container;
use super::{index, list};
use crate::source::read_error::ReadErrorKind;
use serde_json::Value;
use std::ops::Range;

/// Numbers in a buffer.
#[derive(Clone, Debug)]
pub(super) struct Accessor {
    pub(super) buffer: usize,
    /// Offset of the first value in the buffer.
    start: usize,
    stride: usize,
    pub(super) count: usize,
    /// Number of components of a value.
    pub(super) components: usize,
    kind: Kind,
    normalized: bool,
}

/// Type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Kind {
    fn of(code: u64) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }
    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
    /// Smallest and largest number of a whole type.
    fn range(self) -> [f64; 2] {
        match self {
            Self::I8 => [i8::MIN.into(), i8::MAX.into()],
            Self::U8 => [0.0, u8::MAX.into()],
            Self::I16 => [i16::MIN.into(), i16::MAX.into()],
            Self::U16 => [0.0, u16::MAX.into()],
            Self::U32 => [0.0, u32::MAX.into()],
            Self::F32 => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }
}

impl Accessor {
    /// Finds an accessor of a document, and checks that its buffer has all of its numbers. `used_for` is for errors.
    pub(super) fn find(
        container: &Container,
        document: &Value,
        accessor: usize,
        used_for: &str,
    ) -> Result<Self, ReadErrorKind> {
        let bad = |reason: &str| ReadErrorKind::Malformed(format!("accessor {accessor} ({used_for}): {reason}"));
        let entry = list(document, "accessors").get(accessor).ok_or_else(|| bad("there is none"))?;
        if !entry["sparse"].is_null() {
            return Err(ReadErrorKind::Unsupported(format!("a sparse accessor ({accessor}, {used_for})")));
        }
        let view = index(&entry["bufferView"]).ok_or_else(|| bad("it has no buffer view"))?;
        let view_entry =
            list(document, "bufferViews").get(view).ok_or_else(|| bad("its buffer view does not exist"))?;
        for extension in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
            if !view_entry["extensions"][extension].is_null() {
                return Err(ReadErrorKind::Unsupported(format!("meshopt compression ({extension})")));
            }
        }
        let kind = entry["componentType"].as_u64().and_then(Kind::of).ok_or_else(|| bad("unknown `componentType`"))?;
        let components = match entry["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            _ => return Err(bad("its `type` does not fit")),
        };
        let size = components * kind.size();
        let stride = index(&view_entry["byteStride"]).unwrap_or(size);
        if stride < size {
            return Err(bad("its `byteStride` is too small"));
        }
        let count = index(&entry["count"]).ok_or_else(|| bad("it has no `count`"))?;
        let offset = index(&entry["byteOffset"]).unwrap_or(0);
        let bytes = container.view(document, view).ok_or_else(|| bad("its buffer view is larger than its buffer"))?;
        let needed = count.saturating_sub(1) as u128 * stride as u128 + size as u128 * u128::from(count > 0);
        if needed + offset as u128 > bytes.len() as u128 {
            let (element, count) = (format!("{used_for} of accessor {accessor}"), count as u64);
            let left = bytes.len().saturating_sub(offset);
            return Err(ReadErrorKind::Truncated { element, count, needed, left });
        }
        let buffer = index(&view_entry["buffer"]).unwrap_or(0);
        let start = index(&view_entry["byteOffset"]).unwrap_or(0) + offset;
        let normalized = entry["normalized"].as_bool().unwrap_or(false) && kind != Kind::F32;
        Ok(Self { buffer, start, stride, count, components, kind, normalized })
    }

    /// Number of a component as it is in the bytes of the buffer, before any normalisation.
    pub(super) fn raw(&self, bytes: &[u8], value: usize, component: usize) -> f64 {
        let at = self.at(value, component);
        let byte = |k: usize| bytes[at + k];
        match self.kind {
            Kind::I8 => f64::from(byte(0) as i8),
            Kind::U8 => f64::from(byte(0)),
            Kind::I16 => f64::from(i16::from_le_bytes([byte(0), byte(1)])),
            Kind::U16 => f64::from(u16::from_le_bytes([byte(0), byte(1)])),
            Kind::U32 => f64::from(u32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)])),
            Kind::F32 => f64::from(f32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)])),
        }
    }
    /// Value of a component.
    pub(super) fn get(&self, bytes: &[u8], value: usize, component: usize) -> f64 {
        self.value_of(self.raw(bytes, value, component))
    }
    fn value_of(&self, raw: f64) -> f64 {
        if self.normalized { (raw / self.kind.range()[1]).max(-1.0) } else { raw }
    }
    fn raw_of(&self, value: f64) -> f64 {
        let [low, high] = self.kind.range();
        match self.kind {
            Kind::F32 => f64::from(value as f32),
            _ => (if self.normalized { value * high } else { value }).round().clamp(low, high),
        }
    }
    /// Value that the type of the component can hold and that is nearest to another.
    pub(super) fn nearest(&self, value: f64) -> f64 {
        self.value_of(self.raw_of(value))
    }
    /// Writes the nearest number that the type can hold.
    pub(super) fn set(&self, bytes: &mut [u8], value: usize, component: usize, x: f64) {
        let at = self.at(value, component);
        let raw = self.raw_of(x);
        let out = &mut bytes[at..at + self.kind.size()];
        match self.kind {
            Kind::I8 => out.copy_from_slice(&(raw as i8).to_le_bytes()),
            Kind::U8 => out.copy_from_slice(&(raw as u8).to_le_bytes()),
            Kind::I16 => out.copy_from_slice(&(raw as i16).to_le_bytes()),
            Kind::U16 => out.copy_from_slice(&(raw as u16).to_le_bytes()),
            Kind::U32 => out.copy_from_slice(&(raw as u32).to_le_bytes()),
            Kind::F32 => out.copy_from_slice(&(raw as f32).to_le_bytes()),
        }
    }
    /// Returns whether the components are numbers of single precision.
    /// Bytes of the buffer from the first value to the last.
    pub(super) fn span(&self) -> Range<usize> {
        let size = self.components * self.kind.size();
        let length = if self.count == 0 { 0 } else { (self.count - 1) * self.stride + size };
        self.start..self.start + length
    }

    pub(super) fn is_float(&self) -> bool {
        self.kind == Kind::F32
    }
    fn at(&self, value: usize, component: usize) -> usize {
        self.start + value * self.stride + component * self.kind.size()
    }
}
