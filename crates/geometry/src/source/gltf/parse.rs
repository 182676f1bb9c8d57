//! Reader of the meshes of a glTF file.

use super::accessor::Accessor;
use super::container::Container;
use super::{Block, Gltf, PrimitiveKey, TRIANGLES, index, list, materials, scene};
use crate::mesh::jagged::Index;
use crate::source::Corner;
use crate::source::colours;
use crate::source::mesh_data::MaterialRun;
use crate::source::mesh_file::Builder;
use crate::source::read_error::{Place, ReadError, ReadErrorKind};
use glam::{DAffine3, DVec2, DVec3};
use rustc_hash::FxHashMap;
use serde_json::Value;
use std::ops::Range;

const POINTS: u64 = 0;
const LINES: [u64; 3] = [1, 2, 3];
const STRIP: u64 = 5;
const FAN: u64 = 6;

pub(super) fn parse(bytes: Vec<u8>, beside: &dyn Fn(&str) -> Option<Vec<u8>>) -> Result<Gltf, ReadError> {
    let (container, document) = Container::open(bytes, beside)?;
    let mut reader = Reader {
        container: &container,
        document: &document,
        builder: Builder::default(),
        positions: Vec::new(),
        normals: Vec::new(),
        uvs: Vec::new(),
        coloured: true,
        faces: 0,
        indices: Vec::new(),
        read: FxHashMap::default(),
    };
    let whole = |kind: ReadErrorKind| kind.at(Place::File);
    reader.read().and_then(|()| reader.check_overlaps()).map_err(whole)?;
    let Reader { mut builder, positions, normals, coloured, read, .. } = reader;
    if !coloured {
        builder.data.colours = Vec::new();
    }
    builder.data.materials = materials::names(&document);
    let (data, notes) = builder.finish().map_err(whole)?;
    Ok(Gltf { container, document, data, positions, normals, faces: read, notes })
}

struct Reader<'a> {
    container: &'a Container,
    document: &'a Value,
    builder: Builder,
    positions: Vec<Block>,
    normals: Vec<Block>,
    /// Accessors of texture coordinates, and the index of the first value of each.
    uvs: Vec<(usize, usize)>,
    /// True as long as all vertices have colours.
    coloured: bool,
    /// Number of faces of earlier primitives.
    faces: u64,
    /// Accessors of indices, with their numbers in the document.
    indices: Vec<(usize, Accessor)>,
    /// Faces of each primitive that was read.
    read: FxHashMap<PrimitiveKey, Range<Index>>,
}

/// Values that the vertices of a primitive have: the index of the first one in the mesh data, and their number.
type Values = Option<(usize, usize)>;

impl Reader<'_> {
    fn read(&mut self) -> Result<(), ReadErrorKind> {
        let (mut left_out, mut shared) = (0, 0);
        for placed in scene::meshes(self.document, &mut self.builder.notes)? {
            let mesh = &list(self.document, "meshes")[placed.mesh];
            for (p, primitive) in list(mesh, "primitives").iter().enumerate() {
                let extensions = &primitive["extensions"];
                if !extensions["KHR_draco_mesh_compression"].is_null() {
                    let used = "Draco compression (KHR_draco_mesh_compression)".to_owned();
                    return Err(ReadErrorKind::Unsupported(used));
                }
                let mode = primitive["mode"].as_u64().unwrap_or(TRIANGLES);
                if mode == POINTS || LINES.contains(&mode) {
                    left_out += 1;
                    continue;
                }
                let at =
                    |reason: String| ReadErrorKind::Malformed(format!("mesh {}, primitive {p}: {reason}", placed.mesh));
                let Some(position) = index(&primitive["attributes"]["POSITION"]) else {
                    return Err(at("it has no `POSITION`".to_owned()));
                };
                // Some programs write an instance as a mesh of its own that shares all numbers.
                let key = (position, index(&primitive["indices"]), mode);
                if self.read.contains_key(&key) {
                    shared += 1;
                    continue;
                }
                let (first, count) = self.positions(position, placed.place, primitive)?;
                let uvs = self.uvs(primitive)?;
                let normals = self.normals(primitive, placed.place)?;
                for (values, name) in [(uvs, "texture coordinates"), (normals, "normals")] {
                    if values.is_some_and(|(_, n)| n < count) {
                        return Err(at(format!("it has fewer {name} than positions")));
                    }
                }
                let first_face = self.builder.data.faces.len() as Index;
                self.faces(primitive, mode, (first, count), [uvs, normals])?;
                self.read.insert(key, first_face..self.builder.data.faces.len() as Index);
            }
        }
        if shared > 0 {
            let text = format!("{shared} × a primitive has the numbers of an earlier one, and follows it");
            self.builder.notes.push(text);
        }
        if left_out > 0 {
            let parts = if left_out == 1 {
                "primitive of points or lines stays as it is"
            } else {
                "primitives of points or lines stay as they are"
            };
            self.builder.notes.push(format!("{left_out} {parts}"));
        }
        Ok(())
    }

    /// Refuses positions and normals that share bytes with indices: other positions would make other faces.
    fn check_overlaps(&self) -> Result<(), ReadErrorKind> {
        for Block { index, accessor, .. } in self.positions.iter().chain(&self.normals) {
            let shares = |(_, indices): &&(usize, Accessor)| {
                let (a, b) = (accessor.span(), indices.span());
                accessor.buffer == indices.buffer && a.start < b.end && b.start < a.end
            };
            if let Some((indices, _)) = self.indices.iter().find(shares) {
                let reason = format!("accessor {index} shares bytes with accessor {indices}, the indices of faces");
                return Err(ReadErrorKind::Malformed(reason));
            }
        }
        Ok(())
    }

    fn accessor(&self, i: usize, used_for: &str, components: &[usize]) -> Result<Accessor, ReadErrorKind> {
        let accessor = Accessor::find(self.container, self.document, i, used_for)?;
        if components.contains(&accessor.components) {
            return Ok(accessor);
        }
        let reason = format!("accessor {i} ({used_for}): its values have {} numbers", accessor.components);
        Err(ReadErrorKind::Malformed(reason))
    }

    /// Reads a `POSITION` accessor, unless another primitive has done so, with the colours of the primitive.
    fn positions(&mut self, i: usize, place: DAffine3, primitive: &Value) -> Result<(usize, usize), ReadErrorKind> {
        if let Some(known) = self.positions.iter().find(|block| block.index == i) {
            return Ok((known.first, known.accessor.count));
        }
        let accessor = self.accessor(i, "POSITION", &[3])?;
        let (first, count) = (self.builder.data.positions.len(), accessor.count);
        let block = Block { index: i, accessor, first, place, inverse: place.inverse() };
        let bytes = self.container.buffer(block.accessor.buffer);
        let value = |v| DVec3::from_array([0, 1, 2].map(|k| block.accessor.get(bytes, v, k)));
        self.builder.data.positions.extend((0..count).map(|v| block.placed(value(v))));
        self.positions.push(block);
        let set = index(&primitive["attributes"]["COLOR_0"]).filter(|_| self.coloured);
        self.coloured = set.is_some();
        if let Some(set) = set {
            let accessor = self.accessor(set, "COLOR_0", &[3, 4])?;
            let bytes = self.container.buffer(accessor.buffer);
            let colour = |v| [0, 1, 2].map(|k| colours::from_linear(accessor.get(bytes, v, k) as f32));
            self.builder.data.colours.extend((0..accessor.count.min(count)).map(colour));
        }
        Ok((first, count))
    }

    /// Reads the texture coordinates that the base colour texture of the primitive's material uses, v up.
    fn uvs(&mut self, primitive: &Value) -> Result<Values, ReadErrorKind> {
        let material = index(&primitive["material"]).and_then(|m| list(self.document, "materials").get(m));
        let texture = material.map(|m| &m["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"]);
        let set = texture.and_then(index).unwrap_or(0);
        let Some(i) = index(&primitive["attributes"][format!("TEXCOORD_{set}")]) else { return Ok(None) };
        let accessor = self.accessor(i, "TEXCOORD", &[2])?;
        let known = self.uvs.iter().find(|(known, _)| *known == i).map(|(_, first)| *first);
        let first = known.unwrap_or_else(|| {
            let first = self.builder.data.uvs.len();
            let bytes = self.container.buffer(accessor.buffer);
            let uv = |v| DVec2::new(accessor.get(bytes, v, 0), 1.0 - accessor.get(bytes, v, 1));
            self.builder.data.uvs.extend((0..accessor.count).map(uv));
            self.uvs.push((i, first));
            first
        });
        Ok(Some((first, accessor.count)))
    }

    fn normals(&mut self, primitive: &Value, place: DAffine3) -> Result<Values, ReadErrorKind> {
        let Some(i) = index(&primitive["attributes"]["NORMAL"]) else { return Ok(None) };
        if let Some(known) = self.normals.iter().find(|block| block.index == i) {
            return Ok(Some((known.first, known.accessor.count)));
        }
        let accessor = self.accessor(i, "NORMAL", &[3])?;
        let (first, count) = (self.builder.data.normals.len(), accessor.count);
        let block = Block { index: i, accessor, first, place, inverse: place.inverse() };
        let bytes = self.container.buffer(block.accessor.buffer);
        let value = |v| DVec3::from_array([0, 1, 2].map(|k| block.accessor.get(bytes, v, k)));
        self.builder.data.normals.extend((0..count).map(|v| block.placed_normal(value(v))));
        self.normals.push(block);
        Ok(Some((first, count)))
    }

    fn faces(
        &mut self,
        primitive: &Value,
        mode: u64,
        (first, count): (usize, usize),
        [uvs, normals]: [Values; 2],
    ) -> Result<(), ReadErrorKind> {
        let number = index(&primitive["indices"]);
        let accessor = number.map(|i| self.accessor(i, "indices", &[1])).transpose()?;
        self.indices.extend(number.zip(accessor.clone()));
        let bytes = accessor.as_ref().map_or(&[][..], |accessor| self.container.buffer(accessor.buffer));
        let corners = accessor.as_ref().map_or(count, |accessor| accessor.count);
        let vertex = |k: usize| accessor.as_ref().map_or(k as f64, |accessor| accessor.raw(bytes, k, 0));
        let triangles = match mode {
            TRIANGLES => corners / 3,
            STRIP | FAN => corners.saturating_sub(2),
            _ => return Err(ReadErrorKind::Malformed(format!("a primitive has the unknown mode {mode}"))),
        };
        let material = index(&primitive["material"]).filter(|m| *m < list(self.document, "materials").len());
        let material = material.map(|m| m as Index);
        let runs = &mut self.builder.data.material_runs;
        if triangles > 0 && runs.last().is_none_or(|last| last.material != material) {
            runs.push(MaterialRun { first_face: self.builder.data.faces.len() as Index, material });
        }
        for t in 0..triangles {
            let corners = match mode {
                TRIANGLES => [3 * t, 3 * t + 1, 3 * t + 2],
                // Every other triangle of a strip is wound the other way.
                STRIP => [t, t + 1 + t % 2, t + 2 - t % 2],
                _ => [t + 1, t + 2, 0],
            };
            for k in corners {
                let v = vertex(k);
                if v < 0.0 || v >= count as f64 {
                    let (face, vertex) = (self.faces + t as u64, v as i64);
                    return Err(ReadErrorKind::OutOfRange { face, vertex, count });
                }
                let v = v as usize;
                let named = |values: Values| values.map(|(first, _)| (first + v) as Index);
                let corner = Corner::new((first + v) as Index, named(uvs), named(normals));
                self.builder.data.faces.extend_open(corner);
            }
            self.builder.close_face(None);
        }
        self.faces += triangles as u64;
        Ok(())
    }
}
