//! Meshes written in another format than the one that they came in.

use super::format::Format;
use super::mesh_data::{Corner, MeshData};
use super::{gltf, obj, off, ply, stl};
use crate::mesh::jagged::Index;
use glam::{DVec2, DVec3};
use std::borrow::Cow;

/// A mesh as the bytes of a file, in one piece or in several.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Written<B = Vec<u8>> {
    /// Content of the file.
    pub bytes: B,
    /// Largest distance between a position and the one that the file holds, model units. Formats of single precision round to
    /// the nearest number.
    pub rounding: f64,
    /// Contents of the source that the file has no place for, each in a few words.
    pub lost: Vec<String>,
}

impl Written<Vec<Cow<'_, [u8]>>> {
    /// Joins the pieces.
    pub fn joined(self) -> Written {
        let Self { bytes, rounding, lost } = self;
        let bytes = match <[_; 1]>::try_from(bytes) {
            Ok([whole]) => whole.into_owned(),
            Err(pieces) => pieces.concat(),
        };
        Written { bytes, rounding, lost }
    }
}

/// Precision of coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Precision {
    Single,
    Double,
}

/// Mesh data with the attributes that belong to vertices rather than to corners.
pub(super) struct Attributes<'a> {
    pub(super) data: &'a MeshData,
    /// Texture coordinate of each source vertex, if all of its corners share it. #v×2
    pub(super) vertex_uvs: Option<Vec<DVec2>>,
    /// Normal of each source vertex, if all of its corners share it. #v×3
    pub(super) vertex_normals: Option<Vec<DVec3>>,
}

impl<'a> Attributes<'a> {
    fn new(data: &'a MeshData) -> Self {
        Self {
            vertex_uvs: of_vertices(data, data.uvs(), Corner::uv),
            vertex_normals: of_vertices(data, data.normals(), Corner::normal),
            data,
        }
    }
}

/// Value of each source vertex, if all of its corners name equal values or none; `None` if they differ or there are none. A vertex
/// without a value gets zeros.
fn of_vertices<T: Copy + Default + PartialEq>(
    data: &MeshData,
    values: &[T],
    named: impl Fn(Corner) -> Option<Index>,
) -> Option<Vec<T>> {
    if values.is_empty() {
        return None;
    }
    let mut of_vertex: Vec<Option<T>> = vec![None; data.positions().len()];
    for corner in data.faces().items() {
        let value = values[named(*corner)? as usize];
        let slot = &mut of_vertex[corner.position as usize];
        if slot.is_some_and(|known| known != value) {
            return None;
        }
        *slot = Some(value);
    }
    Some(of_vertex.into_iter().map(Option::unwrap_or_default).collect())
}

/// Writes mesh data, whose source has `contents` besides, with other positions (#v×3, model units) and, if given, other normals
/// (#vn×3).
pub(super) fn write(
    source: &MeshData,
    contents: &[String],
    format: Format,
    positions: &[DVec3],
    normals: Option<&[DVec3]>,
) -> Written {
    let mut data = source.clone();
    data.positions = positions.to_vec();
    if let Some(normals) = normals {
        data.normals = normals.to_vec();
    }
    let mesh = Attributes::new(&data);
    let single = |p: &DVec3| p.as_vec3().as_dvec3();
    let is_single = source.positions().iter().all(|p| single(p) == *p);
    let precision = match format {
        Format::Ply if is_single => Precision::Single,
        Format::Obj | Format::Off | Format::Ply => Precision::Double,
        Format::Stl | Format::Glb | Format::Gltf => Precision::Single,
    };
    let bytes = match format {
        Format::Obj => obj::print(&data),
        Format::Ply => ply::print(&mesh, precision),
        Format::Stl => stl::print(&data),
        Format::Off => off::print(&mesh),
        Format::Glb | Format::Gltf => gltf::print(&data, format == Format::Glb),
    };
    let origin = if matches!(format, Format::Glb | Format::Gltf) { gltf::origin(positions) } else { DVec3::ZERO };
    let rounding = match precision {
        Precision::Single => {
            positions.iter().map(|p| (*p - origin).distance(single(&(*p - origin)))).fold(0.0, f64::max)
        }
        Precision::Double => 0.0,
    };
    Written { bytes, rounding, lost: lost(&mesh, contents, format) }
}

/// Contents of a mesh that a format cannot hold.
fn lost(mesh: &Attributes, contents: &[String], format: Format) -> Vec<String> {
    let data = mesh.data;
    let holds = |formats: &[Format]| formats.contains(&format);
    let mut lost = Vec::new();
    let mut lose = |condition: bool, what: &str| {
        if condition {
            lost.push(what.to_owned());
        }
    };
    let has_polygons = data.faces().iter().any(|face| face.len() > 3);
    lose(has_polygons && holds(&[Format::Stl, Format::Glb, Format::Gltf]), "polygons, which are cut into triangles");
    let split_uvs = mesh.vertex_uvs.is_none() && format == Format::Off;
    lose(!data.uvs().is_empty() && (split_uvs || format == Format::Stl), "texture coordinates");
    let split_normals = mesh.vertex_normals.is_none() && holds(&[Format::Ply, Format::Off]);
    lose(!data.normals().is_empty() && (split_normals || format == Format::Stl), "normals");
    lose(!data.colours().is_empty() && format == Format::Stl, "vertex colours");
    let is_rounded = |x: &f32| (x * 255.0).round() / 255.0 != *x;
    let rounded = data.colours().iter().flatten().any(is_rounded);
    lose(rounded && holds(&[Format::Ply, Format::Off]), "vertex colours beyond 8 bits");
    let has_materials = !data.materials().is_empty();
    let keeps_names = holds(&[Format::Obj, Format::Glb, Format::Gltf]);
    lose(has_materials && !keeps_names, "materials and textures");
    lose(has_materials && keeps_names, "colours and textures of materials, whose names stay");
    lost.extend(contents.iter().cloned());
    lost
}
