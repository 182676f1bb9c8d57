//! Reading and writing STL files, binary and text, where everything but the numbers that change stays byte for byte.
//!
//! A file lists three corners for each facet and no vertices. Corners at the same position, bit for bit but for the sign of zeros,
//! are one source vertex. Facet normals follow from the corners, so they are written anew where a corner moves.
//!
//! ```
//! use planish_geometry::source::{mesh_file::MeshFile, read_error::ReadError, stl::Stl};
//!
//! // Two facets with three corners each, which share an edge: four vertices.
//! let facet = |corners: [&str; 3]| {
//!     format!("facet normal 0 0 1\nouter loop\nvertex {}\nendloop\nendfacet\n", corners.join("\nvertex "))
//! };
//! let solid = facet(["0 0 0", "1 0 0", "0 1 0"]) + &facet(["0 1 0", "1 0 0", "1 1 0"]);
//! let stl = Stl::parse(format!("solid scan\n{solid}endsolid scan\n").into_bytes())?;
//! assert_eq!(stl.data().positions().len(), 4);
//! // A vertex that moves takes all of its corners with it.
//! let mut positions = stl.data().positions().to_vec();
//! positions[1].x = 3.0;
//! let written = String::from_utf8(stl.with_positions(&positions, None)).unwrap();
//! assert_eq!(written.matches("vertex 3").count(), 2, "{written}");
//! # Ok::<(), ReadError>(())
//! ```

mod parse;
mod print;
mod rewrite;

use super::format::Format;
use super::mesh_data::MeshData;
use super::mesh_file::MeshFile;
use super::read_error::ReadError;
use crate::mesh::jagged::{Index, Ragged};
use glam::DVec3;

pub(super) use print::print;

/// A parsed file together with its bytes.
#[derive(Clone, Debug)]
pub struct Stl {
    bytes: Vec<u8>,
    data: MeshData,
    /// Source vertices at the corners of each facet of the file.
    facets: Ragged<Index>,
    is_text: bool,
    /// Number of solids in a text file.
    solids: usize,
    notes: Vec<String>,
}

/// Number of bytes before the facets of a binary file.
const HEADER: usize = 84;
/// Number of bytes of a facet in a binary file: a normal, three corners, and two bytes that programs use as they like.
const FACET: usize = 50;

impl Stl {
    /// Reads a file. It is binary if its size goes with its number of facets, even if it begins with `solid`.
    pub fn parse(bytes: Vec<u8>) -> Result<Self, ReadError> {
        parse::parse(bytes)
    }
}

impl MeshFile for Stl {
    fn format(&self) -> Format {
        Format::Stl
    }
    fn data(&self) -> &MeshData {
        &self.data
    }
    fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    fn with_positions(&self, positions: &[DVec3], _: Option<&[DVec3]>) -> Vec<u8> {
        rewrite::with_positions(self, positions)
    }
    fn held(&self, vertex: Index, position: DVec3) -> DVec3 {
        if self.is_text || !self.data.moves(vertex, position) {
            return position;
        }
        position.as_vec3().as_dvec3()
    }
    fn contents(&self) -> Vec<String> {
        let attributes = |facet: &[u8]| facet[FACET - 2..] != [0, 0];
        let marked = match self.is_text {
            true => 0,
            false => self.bytes[HEADER..].chunks_exact(FACET).take(self.facets.len()).filter(|f| attributes(f)).count(),
        };
        let solids = (self.solids > 1).then(|| format!("{} solids", self.solids));
        solids.into_iter().chain((marked > 0).then(|| format!("{marked} facets with attribute bytes"))).collect()
    }
    fn notes(&self) -> &[String] {
        &self.notes
    }
}

#[cfg(test)]
mod tests;
