//! Writer that copies the bytes of a glTF file and replaces the numbers that change, with the bounds of their accessors.

use super::container::to_data_uri;
use super::{Block, Gltf};
use crate::mesh::jagged::Index;
use crate::source::patch::{Patch, push_number};
use glam::DVec3;
use serde::Deserialize;
use serde_json::value::RawValue;
use std::collections::BTreeMap;
use std::ops::Range;

/// Parts of the JSON that may change, as they are spelled.
#[derive(Deserialize)]
struct Spans<'a> {
    #[serde(borrow, default)]
    accessors: Vec<AccessorSpans<'a>>,
    #[serde(borrow, default)]
    buffers: Vec<BufferSpans<'a>>,
}

#[derive(Deserialize)]
struct AccessorSpans<'a> {
    #[serde(borrow, default)]
    min: Option<&'a RawValue>,
    #[serde(borrow, default)]
    max: Option<&'a RawValue>,
}

#[derive(Deserialize)]
struct BufferSpans<'a> {
    #[serde(borrow, default)]
    uri: Option<&'a RawValue>,
}

pub(super) fn with_positions(gltf: &Gltf, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<u8> {
    let data = &gltf.data;
    assert_eq!(positions.len(), data.positions.len(), "one position for each vertex");
    assert!(normals.is_none_or(|normals| normals.len() == data.normals.len()), "one normal for each normal");
    let mut buffers: BTreeMap<usize, Vec<u8>> = BTreeMap::new();
    let mut changed: Vec<&Block> = Vec::new();
    let mut write = |block: &'_ Block, v: usize, before: &dyn Fn(usize) -> f64, after: DVec3| {
        let bytes = buffers.entry(block.accessor.buffer);
        let bytes = bytes.or_insert_with(|| gltf.container.buffer(block.accessor.buffer).to_vec());
        for (axis, x) in after.to_array().into_iter().enumerate() {
            if block.accessor.nearest(x).to_bits() != before(axis).to_bits() && x.is_finite() {
                block.accessor.set(bytes, v, axis, x);
            }
        }
    };
    for block in &gltf.positions {
        let bytes = gltf.container.buffer(block.accessor.buffer);
        let mut moves = false;
        for v in 0..block.accessor.count {
            let vertex = block.first + v;
            if data.moves(vertex as Index, positions[vertex]) {
                let before = |axis| block.accessor.get(bytes, v, axis);
                write(block, v, &before, block.local(positions[vertex]));
                moves = true;
            }
        }
        if moves {
            changed.push(block);
        }
    }
    for (block, normals) in gltf.normals.iter().flat_map(|block| normals.map(|normals| (block, normals))) {
        let bytes = gltf.container.buffer(block.accessor.buffer);
        for v in 0..block.accessor.count {
            let normal = normals[block.first + v];
            let bits = |n: DVec3| n.to_array().map(f64::to_bits);
            if bits(normal) != bits(data.normals[block.first + v]) {
                write(block, v, &|axis| block.accessor.get(bytes, v, axis), block.local_normal(normal));
            }
        }
    }
    let json = patched_json(gltf, &buffers, &changed);
    let within =
        buffers.iter().find(|(buffer, _)| gltf.container.is_within(**buffer)).map(|(_, bytes)| bytes.as_slice());
    gltf.container.rebuilt(&json, within)
}

/// JSON with the bounds of the blocks that changed. Where anything changes, buffers in files beside become data URIs.
fn patched_json(gltf: &Gltf, buffers: &BTreeMap<usize, Vec<u8>>, changed: &[&Block]) -> Vec<u8> {
    let json = gltf.container.json();
    // The reader has parsed this JSON, so both steps succeed.
    let spans = std::str::from_utf8(json).ok().and_then(|text| serde_json::from_str::<Spans>(text).ok());
    let Some(spans) = spans else { return json.to_vec() };
    let range = |raw: &RawValue| {
        let start = raw.get().as_ptr() as usize - json.as_ptr() as usize;
        start..start + raw.get().len()
    };
    let mut changes: Vec<(Range<usize>, Vec<u8>)> = Vec::new();
    for block in changed {
        let bytes = &buffers[&block.accessor.buffer];
        let Some(accessor) = spans.accessors.get(block.index) else { continue };
        let picks = [(accessor.min, f64::min as fn(f64, f64) -> f64), (accessor.max, f64::max)];
        for (span, pick) in picks.into_iter().filter_map(|(span, pick)| Some((span?, pick))) {
            let bound = |axis| (0..block.accessor.count).map(|v| block.accessor.raw(bytes, v, axis)).reduce(pick);
            let bounds = [0, 1, 2].map(|axis| bound(axis).unwrap_or(0.0));
            let old: Option<Vec<f64>> = serde_json::from_str(span.get()).ok();
            let is_same = |old: &[f64]| old.iter().zip(bounds).all(|(x, y)| f64::from(*x as f32) == y);
            if old.is_none_or(|old| old.len() != 3 || !is_same(&old)) {
                changes.push((range(span), spelled(block, bounds)));
            }
        }
    }
    for (i, uri) in spans.buffers.iter().enumerate().filter_map(|(i, buffer)| Some((i, buffer.uri?))) {
        // A reference to a file beside would break where the output is in another folder.
        let changes_place = !buffers.is_empty() && gltf.container.is_external(i);
        let bytes = buffers.get(&i).map(Vec::as_slice).or_else(|| changes_place.then(|| gltf.container.buffer(i)));
        if let Some(bytes) = bytes {
            changes.push((range(uri), format!("\"{}\"", to_data_uri(bytes)).into_bytes()));
        }
    }
    changes.sort_by_key(|(range, _)| range.start);
    let mut patch = Patch::new(json);
    for (range, bytes) in changes {
        patch.replace(range).extend(bytes);
    }
    patch.finish()
}

/// Bounds as JSON: numbers that read back to the same bits.
fn spelled(block: &Block, bounds: [f64; 3]) -> Vec<u8> {
    let mut out = b"[".to_vec();
    for (k, x) in bounds.into_iter().enumerate() {
        if k > 0 {
            out.push(b',');
        }
        if block.accessor.is_float() {
            push_number(&mut out, x as f32);
        } else {
            out.extend(itoa::Buffer::new().format(x as i64).as_bytes());
        }
    }
    out.push(b']');
    out
}
