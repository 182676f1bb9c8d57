//! The mesh that carries the map.

use crate::manifest;
use crate::model::Model;
use crate::obj::{Obj, ObjError};
use crate::ragged::Index;
use crate::texture::per_vertex;
use glam::{DVec3, Vec2, Vec3};

/// The carrier as it reads back.
pub(super) struct CarrierFile {
    pub(super) obj: Obj,
    pub(super) sha256: String,
}

impl CarrierFile {
    /// Normals are those of the vertices (#V×3); texture coordinates (#v) where the file has none of its own.
    pub(super) fn make(
        model: &Model,
        normals: &[Vec3],
        uvs: Option<&[Vec2]>,
        library_file: &str,
    ) -> Result<Self, ObjError> {
        let welded: Vec<DVec3> = model.weld().spread(model.surface().positions());
        let bytes = model.obj().carrier(&welded, &line_normals(model, normals), uvs, library_file);
        let sha256 = manifest::sha256(&bytes);
        Ok(Self { obj: Obj::parse(bytes)?, sha256 })
    }
}

/// Where the `v` lines sample a map with a texel for each. #v, v up
pub(super) fn places(model: &Model) -> Vec<Vec2> {
    let lines = model.obj().positions().len();
    let size = per_vertex::size(lines);
    (0..lines as Index).map(|line| per_vertex::uv(line, size)).collect()
}

/// Normals of the `v` lines. Where there is none the height is zero, and any direction does; a client would make NaN
/// of a zero vector.
fn line_normals(model: &Model, normals: &[Vec3]) -> Vec<Vec3> {
    let mut normals = model.weld().spread(normals);
    for n in normals.iter_mut().filter(|n| **n == Vec3::ZERO) {
        *n = Vec3::Z;
    }
    normals
}
