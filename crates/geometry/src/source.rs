//! Sources of meshes: a file that can be written again with other numbers, or arrays.
//!
//! Code that reads a mesh reads [`MeshData`], which knows no format. Only code that writes the user's file again asks for
//! its format.

mod arrays;
pub mod flaws;
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

/// A mesh as it was given: its numbers and indices, and its file if there is one.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Source {
    /// The mesh came as an OBJ file.
    Obj(Obj),
    /// The mesh came as arrays and has no file.
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

/// The mesh was given as arrays, so there is no file that could be written with other numbers.
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
    /// The OBJ file; `None` if the mesh did not come as one.
    pub fn as_obj(&self) -> Option<&Obj> {
        match self {
            Self::Obj(obj) => Some(obj),
            Self::Arrays(_) => None,
        }
    }
    /// Returns the OBJ file; `None` if the mesh did not come as one.
    pub fn into_obj(self) -> Option<Obj> {
        match self {
            Self::Obj(obj) => Some(obj),
            Self::Arrays(_) => None,
        }
    }
    /// Bytes that identify the mesh: those of its file. Arrays are printed as an OBJ, so that they and an OBJ of just these
    /// bytes count as the same mesh.
    pub fn bytes(&self) -> Cow<'_, [u8]> {
        match self {
            Self::Obj(obj) => obj.bytes().into(),
            Self::Arrays(data) => obj::print(data).into(),
        }
    }
    /// Names of the material libraries that the file refers to; empty for arrays. The format names no encoding.
    pub fn material_libraries(&self) -> &[Vec<u8>] {
        match self {
            Self::Obj(obj) => &obj.extras().material_libraries,
            Self::Arrays(_) => &[],
        }
    }

    /// Returns the bytes of the file with other positions (#v×3, model units) and, if given, other normals (#vn×3). All else
    /// stays byte for byte.
    ///
    /// # Panics
    /// If there is not one position for each source vertex, or not one normal for each normal of the source.
    pub fn with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Result<Vec<u8>, NoFile> {
        match self {
            Self::Obj(obj) => Ok(obj.with_positions(positions, normals)),
            Self::Arrays(_) => Err(NoFile),
        }
    }
    /// Returns the mesh with other texture coordinates (#vt×2, v up); `corners` has the index of one for each corner (#c).
    ///
    /// # Panics
    /// If there is not one index for each corner.
    pub fn with_uvs(&self, uvs: &[Vec2], corners: &[Index]) -> Result<Self, ObjError> {
        match self {
            Self::Obj(obj) => Ok(Obj::parse(obj.with_uvs(uvs, corners))?.into()),
            Self::Arrays(data) => Ok(data.with_uvs(uvs, corners).into()),
        }
    }
    /// Returns the carrier of a displacement map as an OBJ file. It has these positions (#v×3, model units), one unit normal
    /// for each source vertex (#v×3), which all of its corners name, and one material library. Texture coordinates (#v×2), if
    /// given, replace those of the mesh by one for each source vertex. Faces without a material get
    /// [`CARRIER_MATERIAL`](crate::source::materials::CARRIER_MATERIAL).
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
