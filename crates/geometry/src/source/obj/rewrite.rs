//! Writers that copy the bytes of an OBJ file and replace some of its tokens.

use super::print::{carrier_corner, push_attributes, push_corner, push_line};
use super::scan::{self, Statement, Statements, Tokens};
use super::{Obj, Piece};
use crate::mesh::jagged::Index;
use crate::source::Corner;
use crate::source::materials::CARRIER_MATERIAL;
use crate::source::patch::{Patch, push_number};
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;
use std::borrow::Cow;

/// Line ending of a file. A wrong one would join lines: after a line feed, lone carriage returns end no line any more.
fn end_of_line(bytes: &[u8]) -> &'static [u8] {
    match scan::terminator(bytes) {
        b'\r' => b"\r",
        _ if memchr::memmem::find(bytes, b"\r\n").is_some() => b"\r\n",
        _ => b"\n",
    }
}

/// Replaces those of the first three numbers of a statement whose bits differ.
pub(super) fn replace_numbers(patch: &mut Patch, statement: &Statement, [before, after]: [DVec3; 2]) {
    let tokens = Tokens::new(patch.source(), statement);
    for (token, (x, y)) in tokens.zip(before.to_array().into_iter().zip(after.to_array())) {
        if x.to_bits() != y.to_bits() {
            push_number(patch.replace(token), y);
        }
    }
}

impl Obj {
    /// Position of a `v` line before and after; the same if it has none in the file.
    fn change(&self, v: usize, after: DVec3) -> [DVec3; 2] {
        let before = self.data.positions[v];
        if self.data.moves(v as Index, after) { [before, after] } else { [before, before] }
    }
    /// Returns whether the statement of a face is in the surface, whose next face is `face`.
    fn is_face(&self, statement: &Statement, face: usize) -> bool {
        self.data.face_lines.get(face) == Some(&statement.line)
    }

    /// Returns the file with other positions on its `v` lines (#v×3, model units) and, if given, other normals on its `vn`
    /// lines (#vn×3). Numbers that did not change keep their spelling.
    ///
    /// # Panics
    /// If there is not one position for each `v` line.
    pub fn with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<u8> {
        self.rewritten(positions, normals).concat()
    }

    /// Pieces of [`Self::with_positions`], those that do not change as they are in the file.
    pub(super) fn rewritten(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<Cow<'_, [u8]>> {
        assert_eq!(positions.len(), self.data.positions.len(), "one position for each `v` line");
        let end = [positions.len() as Index, self.data.normals.len() as Index];
        let ends = self.pieces[1..].iter().map(|next| [next.vertices, next.normals]).chain([end]);
        let pieces: Vec<_> = self.pieces.iter().zip(ends).collect();
        let rewritten = pieces.into_par_iter().map(|(piece, [vertices, vns])| {
            if vertices == piece.vertices && (normals.is_none() || vns == piece.normals) {
                Cow::Borrowed(&self.bytes[piece.bytes.clone()])
            } else {
                Cow::Owned(self.rewritten_piece(piece, positions, normals))
            }
        });
        rewritten.collect()
    }

    fn rewritten_piece(&self, piece: &Piece, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<u8> {
        let mut patch = Patch::of_piece(&self.bytes, piece.bytes.clone());
        let [mut v, mut vn] = [piece.vertices, piece.normals].map(|before| before as usize);
        for statement in Statements::of_piece(&self.bytes, piece.bytes.clone()) {
            match (&self.bytes[statement.keyword.clone()], normals) {
                (b"v", _) => {
                    replace_numbers(&mut patch, &statement, self.change(v, positions[v]));
                    v += 1;
                }
                (b"vn", Some(normals)) => {
                    replace_numbers(&mut patch, &statement, [self.data.normals[vn], normals[vn]]);
                    vn += 1;
                }
                _ => {}
            }
        }
        patch.finish()
    }

    /// Returns the file as the carrier of a displacement map, with these positions on its `v` lines (#v×3, model units), one
    /// unit normal for each `v` line (#v×3), which all of its corners name, and one material library.
    ///
    /// The `vn` lines are replaced, because a client must not displace along normals that are split at seams or hard edges.
    /// Texture coordinates (#v×2), if given, replace the `vt` lines by one for each `v` line. Faces without a material get
    /// [`CARRIER_MATERIAL`].
    ///
    /// # Panics
    /// If a list has not one element for each `v` line.
    pub fn carrier(
        &self,
        positions: &[DVec3],
        normals: &[Vec3],
        uvs: Option<&[Vec2]>,
        material_library: &str,
    ) -> Vec<u8> {
        assert_eq!(positions.len(), self.data.positions.len(), "one position for each `v` line");
        assert_eq!(normals.len(), self.data.positions.len(), "one normal for each `v` line");
        assert!(uvs.is_none_or(|uvs| uvs.len() == normals.len()), "one texture coordinate for each `v` line");
        let eol = end_of_line(&self.bytes);
        let mut patch = Patch::new(&self.bytes);
        let mut faces = CarrierFaces { obj: self, normals, uvs, eol, written: 0, corner: 0 };
        let (mut v, mut face, mut library_named, mut material_named) = (0, 0, false, false);
        for statement in Statements::new(&self.bytes) {
            let whole_line = statement.line_start..statement.line_end;
            let before_line = statement.line_start..statement.line_start;
            let keyword = &self.bytes[statement.keyword.clone()];
            if matches!(keyword, b"mtllib" | b"usemtl" | b"f" | b"fo") && !library_named {
                push_line(patch.replace(before_line.clone()), "mtllib", material_library.as_bytes(), eol);
                library_named = true;
            }
            match keyword {
                b"v" => {
                    replace_numbers(&mut patch, &statement, self.change(v, positions[v]));
                    v += 1;
                }
                b"vn" | b"mtllib" => {
                    patch.replace(whole_line);
                }
                b"vt" if uvs.is_some() => {
                    patch.replace(whole_line);
                }
                b"usemtl" => material_named = true,
                // What a face with too few corners names may be gone.
                b"f" | b"fo" if !self.is_face(&statement, face) => {
                    patch.replace(whole_line);
                }
                b"f" | b"fo" => {
                    face += 1;
                    if !material_named {
                        push_line(patch.replace(before_line), "usemtl", CARRIER_MATERIAL.as_bytes(), eol);
                        material_named = true;
                    }
                    faces.write(&mut patch, &statement, v);
                }
                _ => {}
            }
        }
        faces.finish(patch.finish(), v)
    }

    /// Returns the file with other texture coordinates (#vt×2, v up); `corners` has the index of one for each corner (#c).
    /// They are written before the first face, and all other `vt` lines left out, as are the `vt` indices of `l` statements.
    ///
    /// # Panics
    /// If there is not one index for each corner.
    pub fn with_uvs(&self, uvs: &[Vec2], corners: &[Index]) -> Vec<u8> {
        assert_eq!(corners.len(), self.data.faces.items().len(), "one texture coordinate for each corner");
        let eol = end_of_line(&self.bytes);
        let mut patch = Patch::new(&self.bytes);
        let (mut corner, mut face) = (0, 0);
        for statement in Statements::new(&self.bytes) {
            match &self.bytes[statement.keyword.clone()] {
                b"vt" => {
                    patch.replace(statement.line_start..statement.line_end);
                }
                b"f" | b"fo" if self.is_face(&statement, face) => {
                    face += 1;
                    if corner == 0 {
                        let out = patch.replace(statement.line_start..statement.line_start);
                        push_attributes(out, &[], Some(uvs), eol);
                    }
                    for token in Tokens::new(&self.bytes, &statement) {
                        let named = self.data.faces.items()[corner];
                        let new = Corner::new(named.position, Some(corners[corner]), named.normal());
                        push_corner(patch.replace(token), new);
                        corner += 1;
                    }
                }
                b"l" | b"f" | b"fo" => {
                    for token in Tokens::new(&self.bytes, &statement) {
                        if let Some(slash) = memchr::memchr(b'/', &self.bytes[token.clone()]) {
                            patch.replace(token.start + slash..token.end);
                        }
                    }
                }
                _ => {}
            }
        }
        patch.finish()
    }
}

/// Writer of the faces of a carrier, and of the attributes of the `v` lines before them.
struct CarrierFaces<'a> {
    obj: &'a Obj,
    normals: &'a [Vec3],
    uvs: Option<&'a [Vec2]>,
    eol: &'static [u8],
    /// Number of `v` lines whose attributes have been written.
    written: usize,
    /// Number of corners that have been written.
    corner: usize,
}

impl CarrierFaces<'_> {
    /// Rewrites a face that follows `v` lines in the number of `v`.
    fn write(&mut self, patch: &mut Patch, statement: &Statement, v: usize) {
        // Attributes go just before the first face that may name them, so that no reader has to look ahead.
        self.write_attributes(patch.replace(statement.line_start..statement.line_start), v);
        for token in Tokens::new(patch.source(), statement) {
            let named = self.obj.data.faces.items()[self.corner];
            let uv = if self.uvs.is_some() { Some(named.position) } else { named.uv() };
            push_corner(patch.replace(token), carrier_corner(named.position, uv));
            self.corner += 1;
        }
    }

    fn write_attributes(&mut self, out: &mut Vec<u8>, v: usize) {
        let new = self.written..v;
        push_attributes(out, &self.normals[new.clone()], self.uvs.map(|uvs| &uvs[new]), self.eol);
        self.written = v;
    }

    /// Appends the attributes of the `v` lines after the last face.
    fn finish(mut self, mut out: Vec<u8>, v: usize) -> Vec<u8> {
        if self.written < v {
            if !out.ends_with(&self.eol[self.eol.len() - 1..]) {
                out.extend_from_slice(self.eol);
            }
            // A backslash at the end of the file would continue into the next line.
            if out.trim_ascii_end().ends_with(b"\\") {
                out.extend_from_slice(self.eol);
            }
            self.write_attributes(&mut out, v);
        }
        out
    }
}
