//! Reading and writing PLY files, where everything but the numbers that change stays byte for byte.
//!
//! Elements, properties and lists that planish does not know are walked over and kept. G. Turk, *The PLY polygon file format*,
//! 1994.
//!
//! ```
//! use planish_geometry::source::{mesh_file::MeshFile, ply::Ply, read_error::ReadError};
//!
//! // The property `confidence` is unknown, and kept.
//! let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
//!               property float confidence\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
//! let ply = Ply::parse(format!("{header}0 0 0 .9\n1 0 0 .8\n0 1 0 .7\n3 0 1 2\n").into_bytes())?;
//! let mut positions = ply.data().positions().to_vec();
//! positions[1].x = 2.5;
//! let written = String::from_utf8(ply.with_positions(&positions, None)).unwrap();
//! assert_eq!(written, format!("{header}0 0 0 .9\n2.5 0 0 .8\n0 1 0 .7\n3 0 1 2\n"));
//! # Ok::<(), ReadError>(())
//! ```

mod header;
mod parse;
mod print;
mod rewrite;
mod scalar;
pub(super) mod stream;

use super::format::Format;
use super::mesh_file::MeshFile;
use super::read_error::ReadError;
use crate::mesh::jagged::Index;
use crate::source::MeshData;
use glam::DVec3;
use header::Header;
use scalar::Scalar;

pub(super) use print::print;

/// A parsed file together with its bytes.
#[derive(Clone, Debug)]
pub struct Ply {
    bytes: Vec<u8>,
    data: MeshData,
    header: Header,
    /// Properties of the vertices that planish reads and rewrites.
    vertex: VertexProperties,
    /// Offset of the first vertex.
    vertices_at: usize,
    /// Line of the first vertex in a text file.
    vertices_line: u32,
    notes: Vec<String>,
}

/// Where the numbers of a vertex are among its properties.
#[derive(Clone, Debug, Default)]
struct VertexProperties {
    position: [usize; 3],
    normal: Option<[usize; 3]>,
    colour: Option<[usize; 3]>,
    uv: Option<[usize; 2]>,
}

impl Ply {
    /// Reads a file: elements `vertex` become the source vertices, elements `face` (or strips of `tristrips`) the faces.
    pub fn parse(bytes: Vec<u8>) -> Result<Self, ReadError> {
        parse::parse(bytes)
    }

    /// Type of the coordinate of an axis.
    fn coordinate(&self, axis: usize) -> Scalar {
        self.header.elements[self.header.vertex].properties[self.vertex.position[axis]].scalar
    }
}

impl MeshFile for Ply {
    fn format(&self) -> Format {
        Format::Ply
    }
    fn data(&self) -> &MeshData {
        &self.data
    }
    fn bytes(&self) -> &[u8] {
        &self.bytes
    }
    fn with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<u8> {
        rewrite::with_positions(self, positions, normals)
    }
    fn held(&self, vertex: Index, position: DVec3) -> DVec3 {
        if !self.data.moves(vertex, position) {
            return self.data.positions[vertex as usize];
        }
        DVec3::from_array([0, 1, 2].map(|axis| self.coordinate(axis).nearest(position[axis])))
    }
    fn embedded_library(&self) -> Vec<u8> {
        let textures = &self.header.textures;
        parse::material_names(textures).iter().zip(textures).fold(Vec::new(), |mut out, (name, texture)| {
            out.extend([b"newmtl ", &name[..], b"\nmap_Kd ", texture, b"\n"].concat());
            out
        })
    }
    fn contents(&self) -> Vec<String> {
        self.header.contents()
    }
    fn notes(&self) -> &[String] {
        &self.notes
    }
}

#[cfg(test)]
mod tests;
