//! The mesh that carries the map.

use super::Request;
use super::draft::Draft;
use crate::bake::gltf::{self, Filter, GltfError};
use crate::map::displace::{self, Places};
use crate::map::displacement::Place;
use crate::map::manifest::{self, Layout};
use crate::map::per_vertex;
use crate::mesh::jagged::Index;
use crate::mesh::normals::{self, FaceWeight};
use crate::source::materials;
use crate::source::model::Model;
use crate::source::obj::{Obj, ObjError};
use glam::{DVec3, Vec2, Vec3};
use serde_json::{Map as Object, Value, json};

/// The carrier as it reads back.
pub(super) struct CarrierFile {
    pub(super) obj: Obj,
    pub(super) sha256: String,
}

impl CarrierFile {
    /// Writes and reads the carrier: normals of the vertices (#V×3), and texture coordinates of the source vertices
    /// (#v×2) where the mesh has none of its own.
    pub(super) fn make(
        model: &Model,
        normals: &[Vec3],
        uvs: Option<&[Vec2]>,
        library_file: &str,
    ) -> Result<Self, ObjError> {
        let welded: Vec<DVec3> = model.weld().spread(model.surface().positions());
        let bytes = model.source().carrier(&welded, &source_normals(model, normals), uvs, library_file);
        let sha256 = manifest::sha256(&bytes);
        Ok(Self { obj: Obj::parse(bytes)?, sha256 })
    }
}

/// Where the source vertices sample a map with a texel for each. #v×2, v up
pub(super) fn places(model: &Model) -> Vec<Vec2> {
    let count = model.data().positions().len();
    let size = per_vertex::size(count);
    (0..count as Index).map(|v| per_vertex::uv(v, size)).collect()
}

/// The carrier as binary glTF, with normals (#V×3) along which the map displaces.
pub(super) fn glb(request: &Request, normals: &[Vec3], draft: &Draft) -> Result<Vec<u8>, GltfError> {
    let Request { model, names, side_files, .. } = *request;
    let Draft { manifest, maps, carrier, .. } = draft;
    let entry = &manifest.displacement;
    let dominant = manifest.dominant_pairs();
    let places = Places::new(entry.layout, &dominant);
    let vertices = displace::carrier_vertices(carrier.obj.data(), places, entry.origin);
    let uv = |place: Place| match place {
        Place::Uv(uv) => uv,
        Place::Texel(line) => per_vertex::uv(line, entry.size()),
    };
    let places: Vec<Option<Vec2>> = vertices.iter().map(|v| v.place.map(uv)).collect();
    let denoised = &maps.offsets.places;
    let denoised_normals = normals::vertex_normals(&model.surface().at(denoised.clone()), FaceWeight::Angle);
    // A library that cannot be understood is copied into the carrier's own all the same; here its materials are grey.
    let materials: Vec<_> = side_files.libraries.iter().flat_map(|l| materials::read(l).unwrap_or_default()).collect();
    let normal_map = manifest.normal_map.as_ref().map_or(Value::Null, |map| json!(map));
    let map = gltf::Map {
        bytes: &maps.displacement,
        filter: if entry.layout == Layout::Uv { Filter::Linear } else { Filter::Nearest },
        entry: match json!(entry) {
            Value::Object(entry) => entry,
            _ => Object::new(),
        },
    };
    let carrier = gltf::Carrier {
        name: &names.stem,
        model,
        normals,
        places: &places,
        denoised,
        denoised_normals: &denoised_normals,
        origin: entry.origin,
        lambda: entry.lambda,
        materials: &materials,
        map,
        normal_map,
    };
    gltf::glb(&carrier, side_files.texture)
}

/// Normals of the source vertices. Where there is none the height is zero, and any direction does; a client would make
/// NaN of a zero vector.
fn source_normals(model: &Model, normals: &[Vec3]) -> Vec<Vec3> {
    let mut normals = model.weld().spread(normals);
    for n in normals.iter_mut().filter(|n| **n == Vec3::ZERO) {
        *n = Vec3::Z;
    }
    normals
}
