//! OBJ bytes in, OBJ bytes out: what planish does not change stays byte for byte.
//!
//! The reader keeps the file and gives the numbers; the writers ([`Obj::with_positions`], [`Obj::carrier`])
//! walk over the statements again and replace the tokens that changed, nothing else.

mod parse;
mod rewrite;
mod scan;

use crate::ragged::{Index, Ragged};
use glam::{DVec2, DVec3};

pub use parse::{ObjError, ObjErrorKind};

/// What one corner of a face names, counted from 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Corner {
    /// `v` line.
    pub position: Index,
    uv: Index,
    normal: Index,
}

impl Corner {
    const ABSENT: Index = Index::MAX;

    /// `vt` line, where the corner names one.
    pub fn uv(self) -> Option<Index> {
        (self.uv != Self::ABSENT).then_some(self.uv)
    }
    /// `vn` line, where the corner names one.
    pub fn normal(self) -> Option<Index> {
        (self.normal != Self::ABSENT).then_some(self.normal)
    }
}

/// What a file holds besides its surface; all of it is kept when the file is written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Extras {
    /// `mtllib` arguments in the file's order (bytes: the format names no encoding).
    pub material_libraries: Vec<Vec<u8>>,
    /// Distinct `usemtl` arguments in the order of first use.
    pub materials: Vec<Vec<u8>>,
    /// Faces before the first `usemtl`.
    pub faces_without_material: usize,
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

/// Faces of one material; they end where the next run begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct MaterialRun {
    first_face: Index,
    /// In [`Extras::materials`].
    material: Index,
}

/// A parsed file together with its bytes.
#[derive(Clone, Debug)]
pub struct Obj {
    bytes: Vec<u8>,
    positions: Vec<DVec3>,
    uvs: Vec<DVec2>,
    normals: Vec<DVec3>,
    faces: Ragged<Corner>,
    face_lines: Vec<u32>,
    material_runs: Vec<MaterialRun>,
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
    /// The file without what was read from it.
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
    /// Coordinates of the `v` lines. Model units.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }
    /// The `vt` lines, u and v; v points up. May hold NaN, see [`Self::non_finite_uvs`].
    pub fn uvs(&self) -> &[DVec2] {
        &self.uvs
    }
    /// The `vn` lines as written, of any length.
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }
    /// The corners of each `f` statement.
    pub fn faces(&self) -> &Ragged<Corner> {
        &self.faces
    }
    /// Line of a face, counted from 1.
    pub fn face_line(&self, face: Index) -> u32 {
        self.face_lines[face as usize]
    }
    /// Material of a face, as its place in [`Extras::materials`]; none before the first `usemtl`.
    pub fn face_material(&self, face: Index) -> Option<Index> {
        let begun = self.material_runs.partition_point(|run| run.first_face <= face);
        Some(self.material_runs[begun.checked_sub(1)?].material)
    }
    /// `vt` lines that are not finite: index and line. They matter only to who needs UVs.
    pub fn non_finite_uvs(&self) -> &[(Index, u32)] {
        &self.non_finite_uvs
    }
    /// What else there is.
    pub fn extras(&self) -> &Extras {
        &self.extras
    }
}

#[cfg(test)]
mod tests;
