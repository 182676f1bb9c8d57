//! Sources of meshes: a file that can be written again with other numbers, or arrays.
//!
//! Code that reads a mesh reads [`MeshData`], which knows no format. Only code that writes the user's file again asks for
//! its format. A format is a type with [`MeshFile`], a variant of [`Source`] and a line in [`Source::parse`].
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::source::{Source, SourceError, format::Format};
//!
//! let source = Source::parse(b"OFF\n3 1 0\n0 0 0\n1 0 0 # east\n0 1 0\n3 0 1 2\n".to_vec(), None)?;
//! let raised: Vec<DVec3> = source.data().positions().iter().map(|p| *p + DVec3::Z).collect();
//! // In its own format the file keeps all else, in another one its numbers.
//! let same = source.written_as(Format::Off, &raised, None);
//! assert_eq!(same.bytes, b"OFF\n3 1 0\n0 0 1.0\n1 0 1.0 # east\n0 1 1.0\n3 0 1 2\n");
//! let other = Source::parse(source.written_as(Format::Ply, &raised, None).bytes, None)?;
//! assert_eq!((other.format(), other.data().positions()), (Format::Ply, &raised[..]));
//! # Ok::<(), SourceError>(())
//! ```

mod arrays;
pub mod backs;
pub(crate) mod colours;
mod convert;
pub mod flaws;
pub mod format;
pub mod gltf;
pub mod materials;
mod mesh_data;
pub mod mesh_file;
pub mod model;
pub mod obj;
pub mod off;
mod patch;
pub mod ply;
pub mod read_error;
pub mod stl;
pub mod stream;
mod text;
pub mod vertex_weights;

pub use arrays::{ArrayError, Arrays};
pub use convert::Written;
pub use mesh_data::{Corner, MeshData};

use crate::mesh::jagged::Index;
use format::Format;
use glam::{DVec3, Vec2, Vec3};
use gltf::Gltf;
use mesh_file::MeshFile;
use obj::{Obj, ObjError};
use off::Off;
use ply::Ply;
use rayon::prelude::*;
use read_error::ReadError;
use std::borrow::Cow;
use stl::Stl;

/// A mesh as it was given: its numbers and indices, and its file if there is one.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Source {
    /// The mesh came as an OBJ file.
    Obj(Obj),
    /// The mesh came as a PLY file.
    Ply(Ply),
    /// The mesh came as an STL file.
    Stl(Stl),
    /// The mesh came as an OFF file.
    Off(Off),
    /// The mesh came as a glTF file.
    Gltf(Box<Gltf>),
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

/// Reasons why bytes are no mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// The file is in no other format, and no OBJ file either.
    #[error(transparent)]
    Obj(#[from] ObjError),
    /// The file is in one of the other formats, and something is wrong with it.
    #[error(transparent)]
    Read(#[from] ReadError),
}

impl Source {
    /// Reads a mesh file. The content decides about its format, and the one that the file name stands for where the content does
    /// not.
    pub fn parse(bytes: Vec<u8>, named: Option<Format>) -> Result<Self, SourceError> {
        Self::parse_beside(bytes, named, &|_| None)
    }
    /// Reads a mesh file that may have parts in other files: `beside` gives the bytes of a file by its path relative to this one.
    pub fn parse_beside(
        bytes: Vec<u8>,
        named: Option<Format>,
        beside: &dyn Fn(&str) -> Option<Vec<u8>>,
    ) -> Result<Self, SourceError> {
        Ok(match Format::of_content(&bytes, named) {
            Format::Ply => Self::Ply(Ply::parse(bytes)?),
            Format::Stl => Self::Stl(Stl::parse(bytes)?),
            Format::Off => Self::Off(Off::parse(bytes)?),
            Format::Glb | Format::Gltf => Self::Gltf(Box::new(Gltf::parse(bytes, beside)?)),
            Format::Obj => Obj::parse(bytes)?.into(),
        })
    }
    /// The file, or the arrays if there is none.
    fn file_or_arrays(&self) -> Result<&dyn MeshFile, &MeshData> {
        match self {
            Self::Obj(file) => Ok(file),
            Self::Ply(file) => Ok(file),
            Self::Stl(file) => Ok(file),
            Self::Off(file) => Ok(file),
            Self::Gltf(file) => Ok(file.as_ref()),
            Self::Arrays(data) => Err(data),
        }
    }
    /// The file; `None` for arrays.
    pub fn file(&self) -> Option<&dyn MeshFile> {
        self.file_or_arrays().ok()
    }
    /// Numbers and indices of the mesh.
    pub fn data(&self) -> &MeshData {
        match self.file_or_arrays() {
            Ok(file) => file.data(),
            Err(data) => data,
        }
    }
    /// The OBJ file; `None` if the mesh did not come as one.
    pub fn as_obj(&self) -> Option<&Obj> {
        match self {
            Self::Obj(obj) => Some(obj),
            _ => None,
        }
    }
    /// Returns the OBJ file; `None` if the mesh did not come as one.
    pub fn into_obj(self) -> Option<Obj> {
        match self {
            Self::Obj(obj) => Some(obj),
            _ => None,
        }
    }
    /// Format of the file; for arrays OBJ, as which they are printed.
    pub fn format(&self) -> Format {
        self.file().map_or(Format::Obj, MeshFile::format)
    }
    /// Bytes that identify the mesh: those of its file. Arrays are printed as an OBJ, so that they and an OBJ of just these
    /// bytes count as the same mesh.
    pub fn bytes(&self) -> Cow<'_, [u8]> {
        self.file().map_or_else(|| obj::print(self.data()).into(), |file| file.identity())
    }
    /// Names of the material libraries that the file refers to; empty for arrays. The format names no encoding.
    pub fn material_libraries(&self) -> &[Vec<u8>] {
        self.file().map_or(&[], MeshFile::material_libraries)
    }

    /// Returns the bytes of the file with other positions (#v×3, model units) and, if given, other normals (#vn×3). All else
    /// stays byte for byte.
    ///
    /// # Panics
    /// If there is not one position for each source vertex, or not one normal for each normal of the source.
    pub fn with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Result<Vec<u8>, NoFile> {
        self.file().map(|file| file.with_positions(positions, normals)).ok_or(NoFile)
    }
    /// Writes the mesh in any format, with other positions (#v×3, model units) and, if given, other normals (#vn×3). In its own
    /// format the file keeps all else byte for byte.
    ///
    /// # Panics
    /// If there is not one position for each source vertex, or not one normal for each normal of the source.
    pub fn written_as(&self, format: Format, positions: &[DVec3], normals: Option<&[DVec3]>) -> Written {
        self.pieces_as(format, positions, normals).joined()
    }
    /// Writes the mesh as [`Self::written_as`] does, in pieces: where the file does not change, they are those of the source.
    ///
    /// # Panics
    /// If there is not one position for each source vertex, or not one normal for each normal of the source.
    pub fn pieces_as(
        &self,
        format: Format,
        positions: &[DVec3],
        normals: Option<&[DVec3]>,
    ) -> Written<Vec<Cow<'_, [u8]>>> {
        match self.file() {
            Some(file) if file.format() == format => {
                let all = (0..positions.len() as Index).into_par_iter();
                let held = all.map(|v| positions[v as usize].distance(file.held(v, positions[v as usize])));
                Written {
                    bytes: file.pieces_with_positions(positions, normals),
                    rounding: held.reduce(|| 0.0, f64::max),
                    lost: Vec::new(),
                }
            }
            file => {
                let contents = file.map(MeshFile::contents).unwrap_or_default();
                let Written { bytes, rounding, lost } =
                    convert::write(self.data(), &contents, format, positions, normals);
                Written { bytes: vec![bytes.into()], rounding, lost }
            }
        }
    }
    /// Returns the mesh with other texture coordinates (#vt×2, v up); `corners` has the index of one for each corner (#c).
    ///
    /// # Panics
    /// If there is not one index for each corner.
    pub fn with_uvs(&self, uvs: &[Vec2], corners: &[Index]) -> Result<Self, ObjError> {
        match self {
            Self::Obj(obj) => Ok(Obj::parse(obj.with_uvs(uvs, corners))?.into()),
            other => Ok(other.data().with_uvs(uvs, corners).into()),
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
            other => obj::print_carrier(other.data(), positions, normals, uvs, material_library),
        }
    }
}
