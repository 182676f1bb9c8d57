//! Where a mesh comes from: a file that can be given back with other numbers, or arrays.
//!
//! All that reads a mesh reads [`MeshData`]. Only what gives the user's file back asks for the format.

mod arrays;
pub mod materials;
mod mesh_data;
pub mod model;
pub mod obj;

pub use arrays::{ArrayError, Arrays};
pub use mesh_data::{Corner, MeshData};

use crate::mesh::jagged::Index;
use glam::{DVec3, Vec2, Vec3};
use obj::{Obj, ObjError};
use std::borrow::Cow;

/// A mesh as it was given.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Source {
    /// An OBJ file.
    Obj(Obj),
    /// Arrays that are no file.
    Arrays(MeshData),
}

impl From<Obj> for Source {
    fn from(obj: Obj) -> Self {
        Self::Obj(obj)
    }
}

impl From<MeshData> for Source {
    fn from(data: MeshData) -> Self {
        Self::Arrays(data)
    }
}

/// Arrays are no file that could be given back with other numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the mesh was given as arrays, so there is no file to give back")]
pub struct NoFile;

impl Source {
    /// Numbers and indices of the mesh.
    pub fn data(&self) -> &MeshData {
        match self {
            Self::Obj(obj) => obj.data(),
            Self::Arrays(data) => data,
        }
    }
    /// The OBJ file, where the mesh came as one.
    pub fn as_obj(&self) -> Option<&Obj> {
        match self {
            Self::Obj(obj) => Some(obj),
            Self::Arrays(_) => None,
        }
    }
    /// Bytes by which the mesh is recognised: those of its file. Of arrays they are the OBJ with the same numbers, so
    /// that arrays and that file count as the same mesh.
    pub fn bytes(&self) -> Cow<'_, [u8]> {
        match self {
            Self::Obj(obj) => obj.bytes().into(),
            Self::Arrays(data) => obj::print(data).into(),
        }
    }
    /// Names of the material libraries beside the file.
    pub fn material_libraries(&self) -> &[Vec<u8>] {
        match self {
            Self::Obj(obj) => &obj.extras().material_libraries,
            Self::Arrays(_) => &[],
        }
    }

    /// The file with other positions (#v×3, model units), and with other normals (#vn×3) where some are given. Whatever
    /// did not change stays byte for byte.
    ///
    /// # Panics
    /// If there is not one position for each source vertex, or not one normal for each normal of the source.
    pub fn with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Result<Vec<u8>, NoFile> {
        match self {
            Self::Obj(obj) => Ok(obj.with_positions(positions, normals)),
            Self::Arrays(_) => Err(NoFile),
        }
    }
    /// The mesh with other texture coordinates (#vt×2); `corners` says for each corner which one (#c).
    ///
    /// # Panics
    /// If there is not one index for each corner.
    pub fn with_uvs(&self, uvs: &[Vec2], corners: &[Index]) -> Result<Self, ObjError> {
        match self {
            Self::Obj(obj) => Ok(Obj::parse(obj.with_uvs(uvs, corners))?.into()),
            Self::Arrays(data) => Ok(data.with_uvs(uvs, corners).into()),
        }
    }
    /// The mesh as the carrier of a displacement map, an OBJ file: positions (#v×3, model units), one unit normal for
    /// each source vertex (#v×3) that every corner names, and one material library. Where texture coordinates (#v×2)
    /// are given they take the place of those of the mesh, one for each source vertex too. Faces without a material
    /// get [`CARRIER_MATERIAL`](crate::source::materials::CARRIER_MATERIAL).
    ///
    /// # Panics
    /// If a list has not one element for each source vertex.
    pub fn carrier(
        &self,
        positions: &[DVec3],
        normals: &[Vec3],
        uvs: Option<&[Vec2]>,
        material_library: &str,
    ) -> Vec<u8> {
        match self {
            Self::Obj(obj) => obj.carrier(positions, normals, uvs, material_library),
            Self::Arrays(data) => obj::print_carrier(data, positions, normals, uvs, material_library),
        }
    }
}
