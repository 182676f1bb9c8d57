//! OBJ bytes in, OBJ bytes out: what planish does not change stays byte for byte.
//!
//! The reader keeps the file and gives the numbers; the writers ([`Obj::with_positions`], [`Obj::carrier`])
//! walk over the statements again and replace the tokens that changed, nothing else. Meshes that were no OBJ are printed.

mod parse;
mod print;
mod rewrite;
mod scan;

use crate::mesh::jagged::Index;
use crate::source::MeshData;

pub use parse::{ObjError, ObjErrorKind};
pub(crate) use print::{print, print_carrier};

/// Things in an OBJ file besides its mesh data; all of them are kept when the file is written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Extras {
    /// `mtllib` arguments in the file's order (bytes: the format names no encoding).
    pub material_libraries: Vec<Vec<u8>>,
    /// `o` statements.
    pub objects: usize,
    /// `g` statements.
    pub groups: usize,
    /// `s` statements.
    pub smoothing_groups: usize,
    /// `l` elements.
    pub lines: usize,
    /// `p` elements.
    pub points: usize,
    /// `v` lines with more than three numbers (w or colours).
    pub extended_vertices: usize,
    /// Statements planish has no use for, such as free-form curves.
    pub other: usize,
}

/// A parsed file together with its bytes.
#[derive(Clone, Debug)]
pub struct Obj {
    bytes: Vec<u8>,
    data: MeshData,
    non_finite_uvs: Vec<(Index, u32)>,
    extras: Extras,
}

impl Obj {
    /// Reads a file. Every coordinate is finite and every index in range afterwards.
    ///
    /// Understands negative and forward indices, all corner spellings, continuations, inline comments,
    /// every line ending, and names in any encoding.
    pub fn parse(bytes: Vec<u8>) -> Result<Self, ObjError> {
        parse::parse(bytes)
    }
    /// The file as it was read.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    /// The file without the numbers that were read from it.
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
    /// Numbers and indices of the file: `v` lines are the source vertices, `vt` lines the texture coordinates, `vn`
    /// lines the normals and `f` statements the faces.
    pub fn data(&self) -> &MeshData {
        &self.data
    }
    /// `vt` lines that are not finite: index and line. They matter only to who needs UVs.
    pub fn non_finite_uvs(&self) -> &[(Index, u32)] {
        &self.non_finite_uvs
    }
    /// Things in the file besides its mesh data.
    pub fn extras(&self) -> &Extras {
        &self.extras
    }
}

#[cfg(test)]
mod tests;
