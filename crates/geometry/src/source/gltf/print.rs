//! Writer of meshes that did not come from a glTF file: one mesh, one primitive for each material.

use super::container::to_data_uri;
use crate::mesh::jagged::Index;
use crate::mesh::polygon;
use crate::source::colours;
use crate::source::{Corner, MeshData};
use glam::DVec3;
use rustc_hash::FxHashMap;
use serde_json::{Map, Value, json};

/// Distance from the origin, in diagonals of the bounds, up to which single precision has digits enough for coordinates.
const NEAR: f64 = 8.0;

/// Point that is subtracted from positions, and that the node adds again: zero unless the mesh is far from it.
pub(in crate::source) fn origin(positions: &[DVec3]) -> DVec3 {
    let low = positions.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = positions.iter().copied().reduce(DVec3::max).unwrap_or_default();
    let centre = (low + high) / 2.0;
    if centre.length() > NEAR * low.distance(high) { centre.round() } else { DVec3::ZERO }
}

/// Buffer with its views and accessors.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds numbers, and returns the index of their accessor. `entry` has what the accessor says besides.
    fn add(&mut self, bytes: impl IntoIterator<Item = u8>, target: u32, mut entry: Value) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        let length = self.bytes.len() - start;
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "target": target }));
        entry["bufferView"] = (self.views.len() - 1).into();
        self.accessors.push(entry);
        self.accessors.len() - 1
    }
    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..N).map(|k| values.iter().map(|value| value[k]).reduce(pick).unwrap_or(0.0)).collect()
        };
        let (min, max) = (bound(f32::min), bound(f32::max));
        let bytes = values.as_flattened().iter().flat_map(|x| x.to_le_bytes());
        let entry =
            json!({ "componentType": 5126, "count": values.len(), "type": format!("VEC{N}"), "min": min, "max": max });
        self.add(bytes, 34962, entry)
    }
}

/// Prints a mesh as a binary file, or as JSON with its buffer inside.
pub(in crate::source) fn print(data: &MeshData, is_binary: bool) -> Vec<u8> {
    let origin = origin(data.positions());
    // Each distinct corner is a vertex of the file.
    let mut vertex_of: FxHashMap<[Index; 3], Index> = FxHashMap::default();
    let mut corners: Vec<Corner> = Vec::new();
    let mut triangles: Vec<Vec<[Index; 3]>> = vec![Vec::new(); data.materials().len() + 1];
    for (f, face) in (0..).zip(data.faces().iter()) {
        let mut vertex = |corner: &Corner| {
            let key = [corner.position, corner.uv().unwrap_or(Index::MAX), corner.normal().unwrap_or(Index::MAX)];
            *vertex_of.entry(key).or_insert_with(|| {
                corners.push(*corner);
                corners.len() as Index - 1
            })
        };
        let vertices: Vec<Index> = face.iter().map(&mut vertex).collect();
        let points: Vec<DVec3> = face.iter().map(|c| data.positions()[c.position as usize]).collect();
        let list = data.face_material(f).map_or(0, |m| m as usize + 1);
        polygon::triangulate(&points, |t| triangles[list].push(t.map(|k| vertices[k])));
    }
    let mut buffer = Buffer::default();
    let mut attributes = Map::new();
    let mut attribute = |name: &str, accessor: usize| attributes.insert(name.to_owned(), accessor.into());
    let of = |get: &dyn Fn(&Corner) -> [f32; 3]| -> Vec<[f32; 3]> { corners.iter().map(get).collect() };
    let positions = of(&|c| (data.positions()[c.position as usize] - origin).as_vec3().to_array());
    attribute("POSITION", buffer.floats(&positions));
    if !data.normals().is_empty() && corners.iter().all(|c| c.normal().is_some()) {
        let normal = |c: &Corner| c.normal().map_or(DVec3::Z, |n| data.normals()[n as usize]);
        let unit = |n: DVec3| n.try_normalize().unwrap_or(DVec3::Z).as_vec3().to_array();
        attribute("NORMAL", buffer.floats(&of(&|c| unit(normal(c)))));
    }
    if !data.uvs().is_empty() {
        let uv = |c: &Corner| {
            let uv = c.uv().map(|uv| data.uvs()[uv as usize]).filter(|uv| uv.is_finite()).unwrap_or_default();
            [uv.x as f32, (1.0 - uv.y) as f32]
        };
        attribute("TEXCOORD_0", buffer.floats(&corners.iter().map(uv).collect::<Vec<_>>()));
    }
    if !data.colours().is_empty() {
        attribute("COLOR_0", buffer.floats(&of(&|c| data.colours()[c.position as usize].map(colours::to_linear))));
    }
    let mut primitives = Vec::new();
    for (list, triangles) in triangles.iter().enumerate().filter(|(_, triangles)| !triangles.is_empty()) {
        let bytes = triangles.as_flattened().iter().flat_map(|v| v.to_le_bytes());
        let entry = json!({ "componentType": 5125, "count": 3 * triangles.len(), "type": "SCALAR" });
        let mut primitive = json!({ "attributes": attributes, "indices": buffer.add(bytes, 34963, entry) });
        if list > 0 {
            primitive["material"] = (list - 1).into();
        }
        primitives.push(primitive);
    }
    let material = |name: &Vec<u8>| json!({ "name": String::from_utf8_lossy(name) });
    let mut node = json!({ "mesh": 0 });
    if origin != DVec3::ZERO {
        node["translation"] = json!(origin.to_array());
    }
    let mut length = json!({ "byteLength": buffer.bytes.len() });
    if !is_binary {
        length["uri"] = to_data_uri(&buffer.bytes).into();
    }
    let mut document = json!({
        "asset": { "version": "2.0", "generator": concat!("planish ", env!("CARGO_PKG_VERSION")) },
        "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [node], "meshes": [{ "primitives": primitives }],
        "accessors": buffer.accessors, "bufferViews": buffer.views, "buffers": [length],
    });
    if !data.materials().is_empty() {
        document["materials"] = data.materials().iter().map(material).collect();
    }
    let mut json = document.to_string().into_bytes();
    if !is_binary {
        return json;
    }
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(((12 + 8 + json.len() + 8 + buffer.bytes.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &buffer.bytes)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    out
}
