//! Binary container of glTF 2.0 (§3.6 and §4 of its specification): a JSON chunk and one buffer, which typed accessors read
//! through views.

use super::document::{Document, Entry, entries};
use crate::source::gltf::index;
use serde_json::{Value, json};

/// Error of a file that is longer than the 32-bit lengths of binary glTF can express.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a binary glTF file of more than 4 GiB cannot be written")]
pub struct TooLarge;

/// Chunks and views begin at multiples of this number of bytes.
const ALIGNMENT: usize = 4;

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Largest number of vertices with 16-bit indices; the highest index is reserved because it restarts a strip.
const VERTICES_OF_SHORT_INDICES: usize = u16::MAX as usize;

/// Buffer of a file, with its views and accessors.
#[derive(Default)]
pub(super) struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Entry>,
    accessors: Vec<Entry>,
}

impl Buffer {
    /// Makes an empty buffer with space for a number of bytes.
    pub(super) fn with_capacity(bytes: usize) -> Self {
        Self { bytes: Vec::with_capacity(bytes), ..Self::default() }
    }

    /// Makes a buffer with these bytes, views and accessors, to which others are added.
    pub(super) fn continuing(bytes: Vec<u8>, views: Vec<Value>, accessors: Vec<Value>) -> Self {
        Self { bytes, views: entries(views), accessors: entries(accessors) }
    }

    /// Adds a view of `length` bytes, and returns its index and the bytes to fill in.
    fn view(&mut self, length: usize, target: Option<u32>) -> (usize, &mut [u8]) {
        let start = self.bytes.len().next_multiple_of(ALIGNMENT);
        self.bytes.resize(start + length, 0);
        let mut view = json!({ "buffer": 0, "byteOffset": start, "byteLength": length });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(Entry::of(&view));
        (self.views.len() - 1, &mut self.bytes[start..])
    }
    /// Adds an accessor and returns its index.
    fn accessor(&mut self, accessor: &Value) -> usize {
        self.accessors.push(Entry::of(accessor));
        self.accessors.len() - 1
    }

    /// Adds a file of any kind and returns the index of its view.
    pub(super) fn file(&mut self, bytes: &[u8]) -> usize {
        let (view, out) = self.view(bytes.len(), None);
        out.copy_from_slice(bytes);
        view
    }
    /// Adds a value for each vertex and returns the index of its accessor, which has the bounds. There must be at least one
    /// value, and all must be finite.
    pub(super) fn attribute<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let (view, out) = self.view(size_of_val(values), Some(ARRAY_BUFFER));
        for (out, x) in out.as_chunks_mut().0.iter_mut().zip(values.as_flattened()) {
            *out = x.to_le_bytes();
        }
        let bound = |pick: fn(f32, f32) -> f32, start| {
            let bound =
                values.iter().fold([start; N], |bound, value| std::array::from_fn(|k| pick(bound[k], value[k])));
            Value::from(bound.to_vec())
        };
        let (min, max) = (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY));
        self.accessor(&json!({
            "bufferView": view, "componentType": FLOAT, "count": values.len(), "type": format!("VEC{N}"),
            "min": min, "max": max,
        }))
    }
    /// Adds an accessor of `count` pairs that has other values than the accessor `base` at these ascending positions, and returns its
    /// index. Only the other values take bytes.
    pub(super) fn changed(&mut self, base: usize, count: usize, others: &[(u32, [f32; 2])]) -> usize {
        let positions: Vec<u8> = others.iter().flat_map(|(at, _)| at.to_le_bytes()).collect();
        let values: Vec<u8> = others.iter().flat_map(|(_, value)| value.map(f32::to_le_bytes)).flatten().collect();
        let (positions, values) = (self.file(&positions), self.file(&values));
        let view = self.accessors[base].value()["bufferView"].take();
        self.accessor(&json!({
            "bufferView": view, "componentType": FLOAT, "count": count, "type": "VEC2",
            "sparse": {
                "count": others.len(),
                "indices": { "bufferView": positions, "componentType": UNSIGNED_INT },
                "values": { "bufferView": values },
            },
        }))
    }
    /// Adds zeros for a number of vectors, and returns the index of the accessor. They take no bytes.
    pub(super) fn zeros(&mut self, count: usize) -> usize {
        let zeros = [0.0; 3];
        self.accessor(&json!({ "componentType": FLOAT, "count": count, "type": "VEC3", "min": zeros, "max": zeros }))
    }
    /// Adds an accessor with the first `count` values of another one, sparse or not, and behind them copies of some of them. Returns its
    /// index; `None` if there is no such accessor, or if the buffer lacks some of its bytes or has them compressed.
    pub(super) fn with_copies(&mut self, base: usize, count: usize, copies: &[u32]) -> Option<usize> {
        let mut entry = self.accessors.get(base)?.value();
        let size = value_size(&entry)?;
        let stride = size.next_multiple_of(ALIGNMENT);
        let mut values = vec![0; (count + copies.len()) * stride];
        if !entry["bufferView"].is_null() {
            let (bytes, step) = self.bytes_of(&entry)?;
            for (k, out) in values.chunks_exact_mut(stride).take(count).enumerate() {
                out[..size].copy_from_slice(value(bytes, k.checked_mul(step.unwrap_or(size))?, size)?);
            }
        }
        let sparse = &entry["sparse"];
        if !sparse.is_null() {
            let width = component_size(&sparse["indices"])?.min(size_of::<u32>());
            let ((at, _), (others, _)) = (self.bytes_of(&sparse["indices"])?, self.bytes_of(&sparse["values"])?);
            for k in 0..index(&sparse["count"])? {
                let mut bytes = [0; size_of::<u32>()];
                bytes[..width].copy_from_slice(value(at, k * width, width)?);
                if let Some(out) = values.chunks_exact_mut(stride).take(count).nth(u32::from_le_bytes(bytes) as usize) {
                    out[..size].copy_from_slice(value(others, k * size, size)?);
                }
            }
        }
        for (to, from) in (count..).zip(copies) {
            let from = *from as usize * stride;
            values.copy_within(from..from + stride, to * stride);
        }
        let (view, out) = self.view(values.len(), Some(ARRAY_BUFFER));
        out.copy_from_slice(&values);
        if stride != size {
            let mut strided = self.views[view].value();
            strided["byteStride"] = stride.into();
            self.views[view] = Entry::of(&strided);
        }
        let fields = entry.as_object_mut()?;
        fields.retain(|name, _| name != "byteOffset" && name != "sparse");
        entry["bufferView"] = view.into();
        entry["count"] = (count + copies.len()).into();
        Some(self.accessor(&entry))
    }
    /// Bytes from the place that a view and an offset give to the end of the view, and its distance between values if it has one.
    fn bytes_of(&self, place: &Value) -> Option<(&[u8], Option<usize>)> {
        let view = self.views.get(index(&place["bufferView"])?)?.value();
        let is_compressed = |name: &String| name.ends_with("_meshopt_compression");
        if view["extensions"].as_object().is_some_and(|extensions| extensions.keys().any(is_compressed)) {
            return None;
        }
        let start = index(&view["byteOffset"]).unwrap_or(0);
        let end = start.checked_add(index(&view["byteLength"])?)?;
        let start = start.checked_add(index(&place["byteOffset"]).unwrap_or(0))?;
        Some((self.bytes.get(start..end)?, index(&view["byteStride"])))
    }
    /// Adds at least one triangle between `vertices` vertices, and returns the index of the accessor.
    pub(super) fn indices(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        self.index_list(triangles.as_flattened(), vertices)
    }
    /// Adds at least one index of one of `vertices` vertices, and returns the index of the accessor.
    pub(super) fn index_list(&mut self, indices: &[u32], vertices: usize) -> usize {
        let short = vertices <= VERTICES_OF_SHORT_INDICES;
        let (kind, width) = if short { (UNSIGNED_SHORT, 2) } else { (UNSIGNED_INT, 4) };
        let (view, out) = self.view(indices.len() * width, Some(ELEMENT_ARRAY_BUFFER));
        if short {
            for (out, i) in out.as_chunks_mut().0.iter_mut().zip(indices) {
                *out = (*i as u16).to_le_bytes();
            }
        } else {
            for (out, i) in out.as_chunks_mut().0.iter_mut().zip(indices) {
                *out = i.to_le_bytes();
            }
        }
        self.accessor(&json!({ "bufferView": view, "componentType": kind, "count": indices.len(), "type": "SCALAR" }))
    }

    /// Finishes the file with a document that uses the indices returned before.
    pub(super) fn finish(mut self, document: impl Into<Document>) -> Result<Vec<u8>, TooLarge> {
        let mut document: Document = document.into();
        self.bytes.resize(self.bytes.len().next_multiple_of(ALIGNMENT), 0);
        if !self.bytes.is_empty() {
            document.insert("buffers", json!([{ "byteLength": self.bytes.len() }]));
        }
        document.insert_list("bufferViews", self.views);
        document.insert_list("accessors", self.accessors);
        let length = |data: &[u8]| u32::try_from(data.len()).map(u32::to_le_bytes).map_err(|_| TooLarge);
        // The text follows behind two lengths, which it has to be there for.
        let mut head = [&b"glTF"[..], &2u32.to_le_bytes(), &[0; 8], b"JSON"].concat();
        let start = head.len();
        serde_json::to_writer(&mut head, &document).map_err(|_| TooLarge)?;
        drop(document);
        head.resize(head.len().next_multiple_of(ALIGNMENT), b' ');
        let text = length(&head[start..])?;
        head[12..16].copy_from_slice(&text);
        if !self.bytes.is_empty() {
            head.extend([length(&self.bytes)?, *b"BIN\0"].as_flattened());
        }
        // The data move within their own memory, because a copy would double the memory that is needed.
        let mut out = self.bytes;
        out.splice(0..0, head);
        let total = length(&out)?;
        out[8..12].copy_from_slice(&total);
        Ok(out)
    }
}

/// Bytes of a component of the values of an accessor; `None` if its type is unknown.
fn component_size(accessor: &Value) -> Option<usize> {
    match accessor["componentType"].as_u64()? {
        5120 | 5121 => Some(1),
        5122 | 5123 => Some(2),
        5125 | 5126 => Some(4),
        _ => None,
    }
}

/// Bytes of a value of an accessor; `None` if its type is unknown. Columns of matrices are aligned.
fn value_size(accessor: &Value) -> Option<usize> {
    let component = component_size(accessor)?;
    let square = |n: usize| Some(n * (n * component).next_multiple_of(ALIGNMENT));
    match accessor["type"].as_str()? {
        "SCALAR" => Some(component),
        "VEC2" => Some(2 * component),
        "VEC3" => Some(3 * component),
        "VEC4" => Some(4 * component),
        "MAT2" => square(2),
        "MAT3" => square(3),
        "MAT4" => square(4),
        _ => None,
    }
}

/// The `size` bytes of a value.
fn value(bytes: &[u8], start: usize, size: usize) -> Option<&[u8]> {
    bytes.get(start..start.checked_add(size)?)
}
