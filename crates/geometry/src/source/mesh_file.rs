//! What all file formats have in common: a file is read into mesh data, and written again with other numbers.
//!
//! ```
//! use glam::DVec3;
//! use planish_geometry::source::{mesh_file::MeshFile, obj::{Obj, ObjError}, off::Off};
//!
//! /// Writes a file of any format with its mesh one higher.
//! fn raised(file: &dyn MeshFile) -> Vec<u8> {
//!     let positions: Vec<DVec3> = file.data().positions().iter().map(|p| *p + DVec3::Z).collect();
//!     file.with_positions(&positions, None)
//! }
//!
//! let obj = Obj::parse(b"# scan\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec())?;
//! assert_eq!(raised(&obj), b"# scan\nv 0 0 1.0\nv 1 0 1.0\nv 0 1 1.0\nf 1 2 3\n");
//! let off = Off::parse(b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".to_vec()).unwrap();
//! assert_eq!(raised(&off), b"OFF\n3 1 0\n0 0 1.0\n1 0 1.0\n0 1 1.0\n3 0 1 2\n");
//! # Ok::<(), ObjError>(())
//! ```

use super::format::Format;
use super::mesh_data::MeshData;
use super::read_error::ReadErrorKind;
use crate::mesh::jagged::Index;
use glam::DVec3;
use std::borrow::Cow;

/// A mesh file that was read, of any format.
pub trait MeshFile: std::fmt::Debug + Sync {
    /// Format of the file.
    fn format(&self) -> Format;
    /// Numbers and indices of the mesh.
    fn data(&self) -> &MeshData;
    /// Bytes of the file as they were read.
    fn bytes(&self) -> &[u8];
    /// Bytes that identify the mesh: those of the file, and of the files beside it that have its numbers.
    fn identity(&self) -> Cow<'_, [u8]> {
        self.bytes().into()
    }
    /// Returns the bytes of the file with other positions (#v×3, model units) and, if given, other normals (#vn×3). Numbers that
    /// do not change keep their bytes, as does all else that does not follow from the positions.
    ///
    /// # Panics
    /// If there is not one position for each source vertex, or not one normal for each normal of the source.
    fn with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<u8>;
    /// Returns what [`Self::with_positions`] does in pieces, those that do not change as they are in the file.
    fn pieces_with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<Cow<'_, [u8]>> {
        vec![self.with_positions(positions, normals).into()]
    }
    /// Position that the file can hold in place of a position of a source vertex: each coordinate is rounded to the nearest
    /// number of its type.
    fn held(&self, vertex: Index, position: DVec3) -> DVec3 {
        let _ = vertex;
        position
    }
    /// Names of the material libraries that the file refers to. The format names no encoding.
    fn material_libraries(&self) -> &[Vec<u8>] {
        &[]
    }
    /// Materials inside the file as the text of a material library (MTL); empty if there are none.
    fn embedded_library(&self) -> Vec<u8> {
        Vec::new()
    }
    /// Bytes of a texture that is inside the file, by its name in [`Self::embedded_library`].
    fn embedded_texture(&self, name: &str) -> Option<Vec<u8>> {
        let _ = name;
        None
    }
    /// Contents besides the mesh data, which are kept, each with its count.
    fn contents(&self) -> Vec<String> {
        Vec::new()
    }
    /// Notes on oddities of the file that were handled, one sentence each.
    fn notes(&self) -> &[String] {
        &[]
    }
}

/// Mesh data in the making, with the checks that readers share.
#[derive(Debug, Default)]
pub(super) struct Builder {
    pub(super) data: MeshData,
    pub(super) notes: Vec<String>,
    short_faces: u64,
    first_short: Option<u64>,
    faces: u64,
}

impl Builder {
    /// Ends the face whose corners were added to `data.faces`. A face with fewer than three corners is left out, with a note.
    pub(super) fn close_face(&mut self, line: Option<u32>) {
        self.faces += 1;
        if self.data.faces.close_if(3) {
            self.data.face_lines.extend(line);
        } else {
            self.short_faces += 1;
            self.first_short.get_or_insert(self.faces - 1);
        }
    }

    /// Checks what is known only at the end. Vertices that no face uses and that are not finite are put where a face is, so that
    /// they disturb nothing; [`MeshData::unplaced`] lists them.
    pub(super) fn finish(mut self) -> Result<(MeshData, Vec<String>), ReadErrorKind> {
        if self.data.positions.is_empty() {
            return Err(ReadErrorKind::NoVertices);
        }
        if self.data.faces.is_empty() {
            return Err(ReadErrorKind::NoFaces);
        }
        if self.data.positions.len().max(self.data.faces.items().len()) >= Index::MAX as usize {
            return Err(ReadErrorKind::TooLarge);
        }
        self.data.place_unused().map_err(|vertex| ReadErrorKind::NotFinite { vertex })?;
        let broken = self.data.drop_broken_attributes();
        if let Some(first) = broken.first() {
            let (count, corners) = (broken.len(), if broken.len() == 1 { "corner has" } else { "corners have" });
            let what = "texture coordinates that are not finite, and count as without";
            self.notes.push(format!("{count} {corners} {what}, the first in face {first}"));
        }
        let count = self.data.unplaced.len();
        if let Some(first) = self.data.unplaced.first() {
            let (vertices, have) = if count == 1 { ("vertex", "has") } else { ("vertices", "have") };
            self.notes.push(format!(
                "{count} {vertices} that no face uses {have} coordinates that are not finite, the first is vertex {first}"
            ));
        }
        if let Some(first) = self.first_short {
            let faces = if self.short_faces == 1 { "face has" } else { "faces have" };
            self.notes.push(format!(
                "{} {faces} fewer than three corners and stay as they are, the first is face {first}",
                self.short_faces
            ));
        }
        if self.data.colours.len() != self.data.positions.len() {
            self.data.colours = Vec::new();
        }
        Ok((self.data, self.notes))
    }
}
