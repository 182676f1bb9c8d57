//! Reading and writing glTF 2.0 files, binary and JSON, where everything but the numbers that change stays byte for byte.
//!
//! Each value of a `POSITION` accessor that a triangle of the scene uses is a source vertex, at the place that the first node with
//! its mesh gives it. Other nodes with the mesh are instances: they share the numbers, so they follow. Draco and meshopt
//! compression and sparse accessors are refused. <https://registry.khronos.org/glTF/specs/2.0>
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::source::{Source, SourceError, format::Format, gltf::Gltf, mesh_file::MeshFile};
//!
//! let triangle = Source::parse(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(), None)?;
//! let bytes = triangle.written_as(Format::Glb, triangle.data().positions(), None).bytes;
//! let gltf = Gltf::parse(bytes, &|_| None)?;
//! let raised: Vec<DVec3> = gltf.data().positions().iter().map(|p| *p + DVec3::Z).collect();
//! let written = Gltf::parse(gltf.with_positions(&raised, None), &|_| None)?;
//! assert_eq!(written.data().positions(), [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]].map(DVec3::from_array));
//! # Ok::<(), SourceError>(())
//! ```

mod accessor;
mod container;
mod materials;
mod parse;
mod print;
mod rewrite;
mod scene;

use super::format::Format;
use super::mesh_data::MeshData;
use super::mesh_file::MeshFile;
use super::read_error::ReadError;
use crate::mesh::jagged::Index;
use accessor::Accessor;
use container::Container;
use glam::{DAffine3, DVec3};
use rustc_hash::FxHashMap;
use serde_json::Value;
use std::borrow::Cow;
use std::ops::Range;

pub(crate) use container::percent_decoded;
pub(super) use print::{origin, print};

/// Mode of primitives whose triangles share no corners.
const TRIANGLES: u64 = 4;

/// Accessors of the positions and indices of a primitive, and its mode: primitives with the same ones have the same faces.
type PrimitiveKey = (usize, Option<usize>, u64);

/// A parsed file together with its bytes.
#[derive(Clone, Debug)]
pub struct Gltf {
    container: Container,
    document: Value,
    data: MeshData,
    positions: Vec<Block>,
    normals: Vec<Block>,
    /// Faces of each primitive in the scene.
    faces: FxHashMap<PrimitiveKey, Range<Index>>,
    notes: Vec<String>,
}

/// Values of an accessor that stand in a list of the mesh data.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// Index of the accessor in the document.
    pub(crate) index: usize,
    accessor: Accessor,
    /// Index of its first value in the list.
    pub(crate) first: usize,
    /// Place of the mesh in the scene; the identity where there is none.
    pub(crate) place: DAffine3,
    /// Inverse of `place`.
    inverse: DAffine3,
}

impl Block {
    /// Returns whether the mesh stands where its numbers say.
    fn is_in_place(&self) -> bool {
        self.place == DAffine3::IDENTITY
    }
    /// Position in the scene for numbers of the file.
    fn placed(&self, p: DVec3) -> DVec3 {
        if self.is_in_place() { p } else { self.place.transform_point3(p) }
    }
    /// Indices of the values in the list.
    pub(crate) fn values(&self) -> Range<usize> {
        self.first..self.first + self.accessor.count
    }
    /// Position of a value as the file has it.
    pub(crate) fn stored(&self, gltf: &Gltf, value: usize) -> DVec3 {
        let bytes = gltf.container.buffer(self.accessor.buffer);
        DVec3::from_array([0, 1, 2].map(|k| self.accessor.get(bytes, value, k)))
    }
    /// Numbers of the file for a position in the scene.
    pub(crate) fn local(&self, p: DVec3) -> DVec3 {
        if self.is_in_place() { p } else { self.inverse.transform_point3(p) }
    }
    /// Normal in the scene for numbers of the file, of any length.
    fn placed_normal(&self, n: DVec3) -> DVec3 {
        if self.is_in_place() { n } else { self.inverse.matrix3.transpose() * n }
    }
    /// Unit normal of the file for a normal in the scene.
    pub(crate) fn local_normal(&self, n: DVec3) -> DVec3 {
        if self.is_in_place() { n } else { (self.place.matrix3.transpose() * n).normalize_or_zero() }
    }
}

impl Gltf {
    /// Reads a file. `beside` gives the bytes of a file by its path relative to this one; `None` if there is no such file.
    pub fn parse(bytes: Vec<u8>, beside: &dyn Fn(&str) -> Option<Vec<u8>>) -> Result<Self, ReadError> {
        parse::parse(bytes, beside)
    }

    /// The JSON of the file.
    pub(crate) fn document(&self) -> &Value {
        &self.document
    }
    /// Bytes of a buffer; empty if there is none.
    pub(crate) fn buffer(&self, i: usize) -> &[u8] {
        self.container.buffer(i)
    }
    /// `POSITION` accessors whose values are source vertices.
    pub(crate) fn position_blocks(&self) -> &[Block] {
        &self.positions
    }

    /// Faces of a primitive; `None` if its triangles are not in the scene. Primitives that share all numbers share their faces.
    pub(crate) fn faces(&self, primitive: &Value) -> Option<Range<Index>> {
        let mode = primitive["mode"].as_u64().unwrap_or(TRIANGLES);
        let key = (index(&primitive["attributes"]["POSITION"])?, index(&primitive["indices"]), mode);
        self.faces.get(&key).cloned()
    }

    /// Block of a source vertex.
    fn block(&self, vertex: Index) -> &Block {
        let after = self.positions.partition_point(|block| block.first <= vertex as usize);
        &self.positions[after - 1]
    }
}

impl MeshFile for Gltf {
    fn format(&self) -> Format {
        if self.container.is_binary() { Format::Glb } else { Format::Gltf }
    }
    fn data(&self) -> &MeshData {
        &self.data
    }
    fn bytes(&self) -> &[u8] {
        self.container.bytes()
    }
    fn identity(&self) -> Cow<'_, [u8]> {
        self.container.with_external_buffers()
    }
    fn with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<u8> {
        rewrite::with_positions(self, positions, normals)
    }
    fn held(&self, vertex: Index, position: DVec3) -> DVec3 {
        if !self.data.moves(vertex, position) {
            return position;
        }
        let block = self.block(vertex);
        block.placed(block.local(position).map(|x| block.accessor.nearest(x)))
    }
    fn embedded_library(&self) -> Vec<u8> {
        materials::library(&self.document)
    }
    fn embedded_texture(&self, name: &str) -> Option<Vec<u8>> {
        materials::embedded_texture(&self.document, &self.container, name)
    }
    fn contents(&self) -> Vec<String> {
        let count = |list: &str| self.document[list].as_array().map_or(0, Vec::len);
        [("animations", "animation", "animations"), ("skins", "skin", "skins"), ("cameras", "camera", "cameras")]
            .into_iter()
            .map(|(list, one, many)| (count(list), one, many))
            .chain([(scene::morph_targets(&self.document), "morph target", "morph targets")])
            .filter(|(count, ..)| *count > 0)
            .map(|(count, one, many)| format!("{count} {}", if count == 1 { one } else { many }))
            .collect()
    }
    fn notes(&self) -> &[String] {
        &self.notes
    }
}

/// List of a document; empty if it has none.
pub(crate) fn list<'a>(document: &'a Value, name: &str) -> &'a [Value] {
    document[name].as_array().map_or(&[], Vec::as_slice)
}

/// Index in a document; `None` if there is none.
pub(crate) fn index(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|index| usize::try_from(index).ok())
}

#[cfg(test)]
mod tests;
