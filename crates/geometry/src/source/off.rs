//! Reading and writing OFF files, where everything but the numbers that change stays byte for byte.
//!
//! The first word says what a line of a vertex has: `ST` texture coordinates at its end, `C` a colour, `N` a normal after the
//! position. Geomview, *OOGL file formats*, 1.6.1.
//!
//! ```
//! use planish_geometry::source::{mesh_file::MeshFile, off::Off, read_error::ReadError};
//!
//! // Vertices with colours, which are kept.
//! let text = b"COFF\n3 1 0\n0 0 0 9 9 9 255\n1 0 0 9 9 9 255\n0 1 0 9 9 9 255\n3 0 1 2\n";
//! let off = Off::parse(text.to_vec())?;
//! let mut positions = off.data().positions().to_vec();
//! positions[1].x = 2.0;
//! let written = off.with_positions(&positions, None);
//! assert_eq!(written, b"COFF\n3 1 0\n0 0 0 9 9 9 255\n2.0 0 0 9 9 9 255\n0 1 0 9 9 9 255\n3 0 1 2\n");
//! # Ok::<(), ReadError>(())
//! ```

mod parse;
mod print;

use super::format::Format;
use super::mesh_data::MeshData;
use super::mesh_file::MeshFile;
use super::patch::{Patch, push_number};
use super::read_error::ReadError;
use super::text::Words;
use crate::mesh::jagged::Index;
use glam::DVec3;

pub(super) use print::print;

/// A parsed file together with its bytes.
#[derive(Clone, Debug)]
pub struct Off {
    bytes: Vec<u8>,
    data: MeshData,
    /// Offset and line of the first vertex.
    vertices_at: (usize, u32),
    has_normals: bool,
    /// Number of faces with colours.
    coloured_faces: usize,
    notes: Vec<String>,
}

impl Off {
    /// Reads a file: text, with or without its first word.
    pub fn parse(bytes: Vec<u8>) -> Result<Self, ReadError> {
        parse::parse(bytes)
    }
}

impl MeshFile for Off {
    fn format(&self) -> Format {
        Format::Off
    }
    fn data(&self) -> &MeshData {
        &self.data
    }
    fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    fn with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<u8> {
        assert_eq!(positions.len(), self.data.positions.len(), "one position for each vertex");
        let mut patch = Patch::new(&self.bytes);
        let (at, line) = self.vertices_at;
        let mut lines = Words { bytes: &self.bytes, at, line };
        let mut words = Vec::new();
        for (v, p) in positions.iter().enumerate() {
            lines.next_line(&mut words);
            let mut replace = |first: usize, before: DVec3, after: DVec3| {
                for (k, (x, y)) in before.to_array().into_iter().zip(after.to_array()).enumerate() {
                    if x.to_bits() != y.to_bits() {
                        push_number(patch.replace(words[first + k].clone()), y);
                    }
                }
            };
            if self.data.moves(v as Index, *p) {
                replace(0, self.data.positions[v], *p);
            }
            if let (Some(normals), true) = (normals, self.has_normals) {
                replace(3, self.data.normals[v], normals[v]);
            }
        }
        patch.finish()
    }
    fn contents(&self) -> Vec<String> {
        (self.coloured_faces > 0).then(|| format!("{} faces with colours", self.coloured_faces)).into_iter().collect()
    }
    fn notes(&self) -> &[String] {
        &self.notes
    }
}

#[cfg(test)]
mod tests;
