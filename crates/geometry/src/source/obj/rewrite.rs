//! The writers of files that are given back: bytes are copied, and tokens replaced.

use super::Obj;
use super::print::{carrier_corner, push_attributes, push_corner, push_line, push_number};
use super::scan::{self, Statement, Statements, Tokens};
use crate::mesh::jagged::Index;
use crate::source::Corner;
use crate::source::materials::CARRIER_MATERIAL;
use glam::{DVec3, Vec2, Vec3};
use std::ops::Range;

/// Copies a file while replacing byte ranges in ascending order.
struct Patch<'a> {
    source: &'a [u8],
    copied: usize,
    out: Vec<u8>,
}

impl<'a> Patch<'a> {
    fn new(source: &'a [u8]) -> Self {
        // Full precision makes numbers longer than what most exporters write.
        let out = Vec::with_capacity(source.len() + source.len() / 2);
        Self { source, copied: 0, out }
    }
    /// Copies all before `range`, leaves `range` out, and gives the place to write instead.
    fn replace(&mut self, range: Range<usize>) -> &mut Vec<u8> {
        self.out.extend_from_slice(&self.source[self.copied..range.start]);
        self.copied = range.end;
        &mut self.out
    }
    fn finish(mut self) -> Vec<u8> {
        self.out.extend_from_slice(&self.source[self.copied..]);
        self.out
    }
}

/// What ends the lines of a file. A single line feed among carriage returns would make one line of all the others.
fn end_of_line(bytes: &[u8]) -> &'static [u8] {
    match scan::terminator(bytes) {
        b'\r' => b"\r",
        _ if memchr::memmem::find(bytes, b"\r\n").is_some() => b"\r\n",
        _ => b"\n",
    }
}

/// Replaces the leading numbers of a statement where they differ, bit for bit.
fn replace_numbers(patch: &mut Patch, statement: &Statement, before: DVec3, after: DVec3) {
    let tokens = Tokens::new(patch.source, statement);
    for (token, (x, y)) in tokens.zip(before.to_array().into_iter().zip(after.to_array())) {
        if x.to_bits() != y.to_bits() {
            push_number(patch.replace(token), y);
        }
    }
}

impl Obj {
    /// The file with other coordinates on its `v` lines (#v), and with other normals on its `vn` lines (#vn)
    /// where some are given. Numbers that did not change keep their spelling.
    pub fn with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<u8> {
        assert_eq!(positions.len(), self.data.positions.len(), "one position for each `v` line");
        let mut patch = Patch::new(&self.bytes);
        let (mut v, mut vn) = (0, 0);
        for statement in Statements::new(&self.bytes) {
            match (&self.bytes[statement.keyword.clone()], normals) {
                (b"v", _) => {
                    replace_numbers(&mut patch, &statement, self.data.positions[v], positions[v]);
                    v += 1;
                }
                (b"vn", Some(normals)) => {
                    replace_numbers(&mut patch, &statement, self.data.normals[vn], normals[vn]);
                    vn += 1;
                }
                _ => {}
            }
        }
        patch.finish()
    }

    /// The file as the carrier of a displacement map: one normal for each `v` line (#v, unit), which every
    /// corner names, and one material library. What a client displaces along must not be split at seams or
    /// hard edges, and that is how `vn` lines usually are; so they are replaced. Positions (#v) replace those
    /// of the `v` lines. Where texture coordinates (#v) are given they take the place of those of the file, one for each
    /// `v` line too. Faces without a material get [`CARRIER_MATERIAL`].
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
        let (mut v, mut library_named, mut material_named) = (0, false, false);
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
                    replace_numbers(&mut patch, &statement, self.data.positions[v], positions[v]);
                    v += 1;
                }
                b"vn" | b"mtllib" => {
                    patch.replace(whole_line);
                }
                b"vt" if uvs.is_some() => {
                    patch.replace(whole_line);
                }
                b"usemtl" => material_named = true,
                b"f" | b"fo" => {
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

    /// The file with other texture coordinates; `corners` says for each corner which one. They stand before the first
    /// face, in place of all `vt` lines. A `vt` index that `l` elements name is left out.
    pub fn with_uvs(&self, uvs: &[Vec2], corners: &[Index]) -> Vec<u8> {
        assert_eq!(corners.len(), self.data.faces.items().len(), "one texture coordinate for each corner");
        let eol = end_of_line(&self.bytes);
        let mut patch = Patch::new(&self.bytes);
        let mut corner = 0;
        for statement in Statements::new(&self.bytes) {
            match &self.bytes[statement.keyword.clone()] {
                b"vt" => {
                    patch.replace(statement.line_start..statement.line_end);
                }
                b"f" | b"fo" => {
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
                b"l" => {
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

/// Faces of a carrier, and the attributes of the `v` lines that stand before them.
struct CarrierFaces<'a> {
    obj: &'a Obj,
    normals: &'a [Vec3],
    uvs: Option<&'a [Vec2]>,
    eol: &'static [u8],
    /// Number of `v` lines whose attributes are written.
    written: usize,
    /// Number of corners that are written.
    corner: usize,
}

impl CarrierFaces<'_> {
    /// Rewrites a face after so many `v` lines.
    fn write(&mut self, patch: &mut Patch, statement: &Statement, v: usize) {
        // Just before the first face that may name them, so that numbers of `v` and `vn` agree and no reader has to
        // look ahead.
        self.write_attributes(patch.replace(statement.line_start..statement.line_start), v);
        for token in Tokens::new(patch.source, statement) {
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

    /// Adds the attributes of `v` lines that stand behind the last face.
    fn finish(mut self, mut out: Vec<u8>, v: usize) -> Vec<u8> {
        if self.written < v {
            if !out.ends_with(&self.eol[self.eol.len() - 1..]) {
                out.extend_from_slice(self.eol);
            }
            // A backslash at the end of the file would continue into what follows now.
            if out.trim_ascii_end().ends_with(b"\\") {
                out.extend_from_slice(self.eol);
            }
            self.write_attributes(&mut out, v);
        }
        out
    }
}
