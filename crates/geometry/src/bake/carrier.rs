//! The carrier: the mesh that a client loads together with the map.

use crate::map::manifest;
use crate::map::per_vertex;
use crate::mesh::jagged::Index;
use crate::source::model::Model;
use crate::source::obj::{Obj, ObjError};
use glam::{DVec3, Vec2, Vec3};

/// Carrier OBJ, parsed back from the bytes that will be written.
pub(super) struct CarrierFile {
    pub(super) obj: Obj,
    pub(super) sha256: String,
}

impl CarrierFile {
    /// Prints the carrier and parses it back. Its normals are those of the vertices (#V×3); `uvs` are texture coordinates
    /// of the source vertices (#v×2) for a mesh that has none.
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

/// Texture coordinates at which the source vertices sample a map with one texel for each. #v×2, v up
pub(super) fn texel_uvs(model: &Model) -> Vec<Vec2> {
    let count = model.data().positions().len();
    let size = per_vertex::size(count);
    (0..count as Index).map(|v| per_vertex::uv(v, size)).collect()
}

/// Unit normals of the source vertices. #v×3
///
/// A vertex without a normal has height zero, so any direction serves; a client would normalise a zero vector to NaN.
fn source_normals(model: &Model, normals: &[Vec3]) -> Vec<Vec3> {
    let mut normals = model.weld().spread(normals);
    for n in normals.iter_mut().filter(|n| **n == Vec3::ZERO) {
        *n = Vec3::Z;
    }
    normals
}
