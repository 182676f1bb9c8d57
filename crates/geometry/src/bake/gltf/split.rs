//! Vertices of a document that are split where new texture coordinates are cut.

use super::GltfError;
use super::glb::Buffer;
use crate::mesh::jagged::Index;
use crate::source::gltf::{Block, Gltf, index};
use crate::source::model::Model;
use crate::source::{Corner, MeshData};
use glam::Vec2;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use serde_json::Value;

/// New texture coordinates of a model that came as glTF, as far as its faces name them: a source vertex and its texture coordinates,
/// ascending.
pub(super) struct Named<'a> {
    mesh: &'a MeshData,
    pairs: Vec<[Index; 2]>,
}

impl<'a> Named<'a> {
    /// Collects the pairs at the corners of all faces.
    pub(super) fn new(model: &'a Model) -> Self {
        let mesh = model.data();
        let corners = mesh.faces().items().par_iter();
        let mut pairs: Vec<_> = corners.filter_map(|corner| Some([corner.position, corner.uv()?])).collect();
        pairs.par_sort_unstable();
        pairs.dedup();
        Self { mesh, pairs }
    }

    /// Splits the vertices of a block.
    pub(super) fn split(&self, block: &Block) -> Split<'a> {
        let vertices = block.values();
        let before = |end: usize| self.pairs.partition_point(|[v, _]| (*v as usize) < end);
        let pairs = &self.pairs[before(vertices.start)..before(vertices.end)];
        let mut split = Split {
            mesh: self.mesh,
            block: block.index,
            first: vertices.start as Index,
            uvs: vec![None; vertices.len()],
            copies: Vec::new(),
            of_copies: FxHashMap::default(),
        };
        for &[source, uv] in pairs {
            let vertex = source - split.first;
            match &mut split.uvs[vertex as usize] {
                own @ None => *own = Some(uv),
                Some(_) => {
                    split.of_copies.insert([vertex, uv], split.uvs.len() as Index);
                    split.uvs.push(Some(uv));
                    split.copies.push(vertex);
                }
            }
        }
        split
    }
}

/// Vertices of a block of a document with their new texture coordinates. A vertex with several of them keeps the first, and gets a copy
/// behind the vertices of the block for each other one.
pub(super) struct Split<'a> {
    mesh: &'a MeshData,
    /// Accessor of the positions of the block.
    block: usize,
    /// Source vertex that is the first of the block.
    first: Index,
    /// Index of the texture coordinates of each vertex, copies included; `None` for vertices without faces.
    uvs: Vec<Option<Index>>,
    /// Vertex of the block that each further vertex copies.
    copies: Vec<Index>,
    /// Number of the copy of a vertex that has certain texture coordinates.
    of_copies: FxHashMap<[Index; 2], Index>,
}

/// Attributes with copies, and lists of triangles, that were made already: primitives share them.
#[derive(Default)]
pub(super) struct Made {
    attributes: FxHashMap<[usize; 2], usize>,
    triangles: FxHashMap<[Index; 2], usize>,
}

impl Split<'_> {
    /// Vertices of the block that are copied, in the order of the copies.
    pub(super) fn copies(&self) -> &[Index] {
        &self.copies
    }

    /// Texture coordinates of the vertices, copies included, v down.
    pub(super) fn uvs(&self) -> Vec<[f32; 2]> {
        let of = |uv: &Option<Index>| uv.map_or(Vec2::ZERO, |uv| self.mesh.uvs()[uv as usize].as_vec2());
        self.uvs.iter().map(|uv| super::v_down(of(uv))).collect()
    }

    /// Number of the vertex that a corner of a face has.
    fn vertex(&self, corner: &Corner) -> Index {
        let vertex = corner.position - self.first;
        corner.uv().and_then(|uv| self.of_copies.get(&[vertex, uv]).copied()).unwrap_or(vertex)
    }

    /// Gives a primitive, whose vertices are those of the block, the copies: in its attributes, in its morph targets and in its triangles.
    pub(super) fn apply(
        &self,
        primitive: &mut Value,
        gltf: &Gltf,
        buffer: &mut Buffer,
        made: &mut Made,
    ) -> Result<(), GltfError> {
        if self.copies.is_empty() {
            return Ok(());
        }
        let (own, all) = (self.uvs.len() - self.copies.len(), self.uvs.len());
        let triangles = gltf.faces(primitive).filter(|faces| !faces.is_empty());
        if let Some(faces) = triangles {
            let corners = |f: Index| {
                let face = self.mesh.faces().get(f);
                [0, 1, 2].map(|k| self.vertex(&face[k]))
            };
            let list = made.triangles.entry([faces.start, faces.end]);
            let list = *list.or_insert_with(|| buffer.indices(&faces.map(corners).collect::<Vec<_>>(), all));
            primitive["indices"] = list.into();
            primitive["mode"] = 4.into();
        } else if primitive["indices"].is_null() {
            // It is not in the scene, and goes on to have no more than its own vertices.
            primitive["indices"] = buffer.index_list(&(0..own as Index).collect::<Vec<_>>(), all).into();
        }
        let mut copy = |attributes: &mut Value| {
            for accessor in attributes.as_object_mut().into_iter().flatten().map(|(_, accessor)| accessor) {
                let Some(old) = index(accessor) else { continue };
                let new = match made.attributes.get(&[self.block, old]) {
                    Some(new) => *new,
                    None => buffer.with_copies(old, own, &self.copies).ok_or(GltfError::Attribute { accessor: old })?,
                };
                made.attributes.insert([self.block, old], new);
                *accessor = new.into();
            }
            Ok(())
        };
        if let Some(attributes) = primitive["attributes"].as_object_mut() {
            // All vertices get others.
            attributes.remove("NORMAL");
        }
        copy(&mut primitive["attributes"])?;
        primitive["targets"].as_array_mut().into_iter().flatten().try_for_each(copy)
    }
}
