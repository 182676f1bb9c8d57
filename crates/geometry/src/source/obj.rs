//! Reading and writing OBJ files, where everything that planish does not change stays byte for byte.
//!
//! The reader keeps the bytes of the file beside its numbers. The writers ([`Obj::with_positions`], [`Obj::carrier`]) walk
//! over the statements again and replace the tokens that changed, nothing else. Meshes from other sources are printed anew.
//!
//! ```
//! use planish_geometry::source::obj::{Obj, ObjError};
//!
//! let obj = Obj::parse(b"# scan\nv 0.00 0 0\nv 1 0 0\nv 0 1 0 # top\nf -3 -2 -1\n".to_vec())?;
//! let mut positions = obj.data().positions().to_vec();
//! positions[2].y = 1.5;
//! let written = obj.with_positions(&positions, None);
//! assert_eq!(written, b"# scan\nv 0.00 0 0\nv 1 0 0\nv 0 1.5 0 # top\nf -3 -2 -1\n");
//! # Ok::<(), ObjError>(())
//! ```

mod error;
mod groups;
mod parse;
mod part;
mod print;
mod rewrite;
mod scan;
pub(super) mod stream;

use crate::mesh::jagged::Index;
use crate::source::MeshData;
use crate::source::format::Format;
use crate::source::mesh_file::MeshFile;
use glam::DVec3;
use std::borrow::Cow;
use std::ops::Range;

pub use error::{ObjError, ObjErrorKind};
pub use groups::NoSuchGroup;
pub use print::CarrierLines;
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

impl Extras {
    /// Adds the contents of the next part of the file.
    fn append(&mut self, part: &Self) {
        let Self { material_libraries, objects, groups, smoothing_groups, lines, points, extended_vertices, other } =
            part;
        self.material_libraries.extend_from_slice(material_libraries);
        self.objects += objects;
        self.groups += groups;
        self.smoothing_groups += smoothing_groups;
        self.lines += lines;
        self.points += points;
        self.extended_vertices += extended_vertices;
        self.other += other;
    }
}

/// A piece of the file that is read and written at the same time as others.
#[derive(Clone, Debug)]
struct Piece {
    /// Range of whole statements.
    bytes: Range<usize>,
    /// Number of `v` lines before the piece.
    vertices: Index,
    /// Number of `vn` lines before the piece.
    normals: Index,
}

/// A parsed file together with its bytes.
#[derive(Clone, Debug)]
pub struct Obj {
    bytes: Vec<u8>,
    data: MeshData,
    non_finite_uvs: Vec<(Index, u32)>,
    extras: Extras,
    notes: Vec<String>,
    pieces: Vec<Piece>,
}

impl Obj {
    /// Reads a file and checks that every position that a face uses is finite and every index of a vertex in range. What a
    /// surface can do without (texture coordinates, normals, faces with fewer than three corners) may be broken.
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
    /// Index and line of each `vt` line with a number that is not finite; corners that name it count as without.
    pub fn non_finite_uvs(&self) -> &[(Index, u32)] {
        &self.non_finite_uvs
    }
    /// Line of a `v` statement, counted from 1, by its index among them; `None` if there are not so many. The file is read again for
    /// it, because lines are needed for messages only.
    pub fn vertex_line(&self, vertex: Index) -> Option<u32> {
        self.line_of(b"v", vertex)
    }
    /// Line of a `vt` statement, counted from 1, by its index among them, as [`Self::vertex_line`] finds it.
    pub fn uv_line(&self, uv: Index) -> Option<u32> {
        self.line_of(b"vt", uv)
    }
    fn line_of(&self, keyword: &[u8], index: Index) -> Option<u32> {
        let mut statements = scan::Statements::new(&self.bytes).filter(|s| &self.bytes[s.keyword.clone()] == keyword);
        statements.nth(index as usize).map(|statement| statement.line)
    }
    /// Contents of the file besides its mesh data.
    pub fn extras(&self) -> &Extras {
        &self.extras
    }
}

impl MeshFile for Obj {
    fn format(&self) -> Format {
        Format::Obj
    }
    fn data(&self) -> &MeshData {
        &self.data
    }
    fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    fn with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<u8> {
        Self::with_positions(self, positions, normals)
    }
    fn pieces_with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<Cow<'_, [u8]>> {
        self.rewritten(positions, normals)
    }
    fn material_libraries(&self) -> &[Vec<u8>] {
        &self.extras.material_libraries
    }
    fn contents(&self) -> Vec<String> {
        let Extras { objects, groups, smoothing_groups, lines, points, other, .. } = self.extras;
        [
            (objects, "object", "objects"),
            (groups, "group", "groups"),
            (smoothing_groups, "smoothing group", "smoothing groups"),
            (lines, "line", "lines"),
            (points, "point element", "point elements"),
            (other, "other statement", "other statements"),
        ]
        .into_iter()
        .filter(|(count, ..)| *count > 0)
        .map(|(count, one, many)| format!("{count} {}", if count == 1 { one } else { many }))
        .collect()
    }
    fn notes(&self) -> &[String] {
        &self.notes
    }
}

#[cfg(test)]
mod tests;
