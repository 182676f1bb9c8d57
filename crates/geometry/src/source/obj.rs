//! Reading and writing OBJ files, where everything that planish does not change stays byte for byte.
//!
//! The reader keeps the bytes of the file beside its numbers. The writers ([`Obj::with_positions`], [`Obj::carrier`]) walk
//! over the statements again and replace the tokens that changed, nothing else. Meshes from other sources are printed anew.

mod parse;
mod print;
mod rewrite;
mod scan;

use crate::mesh::jagged::Index;
use crate::source::MeshData;

pub use parse::{ObjError, ObjErrorKind};
pub(crate) use print::{print, print_carrier};

/// Contents of an OBJ file besides its mesh data; all of them are kept when the file is written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Extras {
    /// Arguments of the `mtllib` statements in the order of the file, as bytes, because the format names no encoding.
    pub material_libraries: Vec<Vec<u8>>,
    /// Number of `o` statements.
    pub objects: usize,
    /// Number of `g` statements.
    pub groups: usize,
    /// Number of `s` statements.
    pub smoothing_groups: usize,
    /// Number of `l` statements.
    pub lines: usize,
    /// Number of `p` statements.
    pub points: usize,
    /// Number of `v` lines with more than three numbers (w or colours).
    pub extended_vertices: usize,
    /// Number of statements that planish has no use for, such as free-form curves.
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
    /// Reads a file and checks that every position is finite and every index in range.
    ///
    /// The reader understands negative and forward indices, all corner spellings, continuations, inline comments, every line
    /// ending, and names in any encoding.
    pub fn parse(bytes: Vec<u8>) -> Result<Self, ObjError> {
        parse::parse(bytes)
    }
    /// Bytes of the file as they were read.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    /// Returns the bytes of the file and drops the rest.
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
    /// Numbers and indices of the file: `v` lines are the source vertices, `vt` lines the texture coordinates, `vn`
    /// lines the normals and `f` statements the faces.
    pub fn data(&self) -> &MeshData {
        &self.data
    }
    /// Index and line of each `vt` line with a number that is not finite; an error only for callers that need UVs.
    pub fn non_finite_uvs(&self) -> &[(Index, u32)] {
        &self.non_finite_uvs
    }
    /// Line of a `v` statement, counted from 1, by its index among them; `None` if there are not so many. The file is read again for
    /// it, because lines are needed for messages only.
    pub fn vertex_line(&self, vertex: Index) -> Option<u32> {
        let mut statements = scan::Statements::new(&self.bytes).filter(|s| &self.bytes[s.keyword.clone()] == b"v");
        statements.nth(vertex as usize).map(|statement| statement.line)
    }
    /// Contents of the file besides its mesh data.
    pub fn extras(&self) -> &Extras {
        &self.extras
    }
}

#[cfg(test)]
mod tests;
