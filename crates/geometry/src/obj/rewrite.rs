//! The writers.

use super::Obj;
use super::scan::{self, Statement, Statements, Tokens};
use crate::ragged::Index;
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

/// Appends the shortest decimal that reads back to the same number.
fn push_number(out: &mut Vec<u8>, x: impl ryu::Float) {
    out.extend_from_slice(ryu::Buffer::new().format(x).as_bytes());
}

fn push_index(out: &mut Vec<u8>, index: Index) {
    out.extend_from_slice(itoa::Buffer::new().format(u64::from(index) + 1).as_bytes());
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

fn push_attributes(out: &mut Vec<u8>, normals: &[Vec3], uvs: Option<&[Vec2]>, eol: &[u8]) {
    let mut line = |keyword: &[u8], numbers: &[f32]| {
        out.extend_from_slice(keyword);
        for x in numbers {
            out.push(b' ');
            push_number(out, *x);
        }
        out.extend_from_slice(eol);
    };
    for uv in uvs.into_iter().flatten() {
        line(b"vt", &uv.to_array());
    }
    for n in normals {
        line(b"vn", &n.to_array());
    }
}

fn push_line(out: &mut Vec<u8>, keyword: &str, argument: &str, eol: &[u8]) {
    out.extend_from_slice(keyword.as_bytes());
    out.push(b' ');
    out.extend_from_slice(argument.as_bytes());
    out.extend_from_slice(eol);
}

impl Obj {
    /// The file with other coordinates on its `v` lines (#v), and with other normals on its `vn` lines (#vn)
    /// where some are given. Numbers that did not change keep their spelling.
    pub fn with_positions(&self, positions: &[DVec3], normals: Option<&[DVec3]>) -> Vec<u8> {
        assert_eq!(positions.len(), self.positions.len(), "one position for each `v` line");
        let mut patch = Patch::new(&self.bytes);
        let (mut v, mut vn) = (0, 0);
        for statement in Statements::new(&self.bytes) {
            match (&self.bytes[statement.keyword.clone()], normals) {
                (b"v", _) => {
                    replace_numbers(&mut patch, &statement, self.positions[v], positions[v]);
                    v += 1;
                }
                (b"vn", Some(normals)) => {
                    replace_numbers(&mut patch, &statement, self.normals[vn], normals[vn]);
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
    /// `v` line too. Faces without a material get [`Self::CARRIER_MATERIAL`].
    pub fn carrier(
        &self,
        positions: &[DVec3],
        normals: &[Vec3],
        uvs: Option<&[Vec2]>,
        material_library: &str,
    ) -> Vec<u8> {
        assert_eq!(positions.len(), self.positions.len(), "one position for each `v` line");
        assert_eq!(normals.len(), self.positions.len(), "one normal for each `v` line");
        assert!(uvs.is_none_or(|uvs| uvs.len() == normals.len()), "one texture coordinate for each `v` line");
        let eol = end_of_line(&self.bytes);
        let mut patch = Patch::new(&self.bytes);
        let (mut v, mut vn, mut corner) = (0, 0, 0);
        let (mut library_named, mut material_named) = (false, false);
        for statement in Statements::new(&self.bytes) {
            let whole_line = statement.line_start..statement.line_end;
            let before_line = statement.line_start..statement.line_start;
            let keyword = &self.bytes[statement.keyword.clone()];
            if matches!(keyword, b"mtllib" | b"usemtl" | b"f" | b"fo") && !library_named {
                push_line(patch.replace(before_line.clone()), "mtllib", material_library, eol);
                library_named = true;
            }
            match keyword {
                b"v" => {
                    replace_numbers(&mut patch, &statement, self.positions[v], positions[v]);
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
                    let out = patch.replace(before_line);
                    if !material_named {
                        push_line(out, "usemtl", Self::CARRIER_MATERIAL, eol);
                        material_named = true;
                    }
                    // Just before the first face that may name them, so that numbers of `v` and `vn` agree
                    // and no reader has to look ahead.
                    push_attributes(out, &normals[vn..v], uvs.map(|uvs| &uvs[vn..v]), eol);
                    vn = v;
                    for token in Tokens::new(&self.bytes, &statement) {
                        let corner_of_file = self.faces.items()[corner];
                        let uv = if uvs.is_some() { Some(corner_of_file.position) } else { corner_of_file.uv() };
                        push_corner(patch.replace(token), corner_of_file.position, uv);
                        corner += 1;
                    }
                }
                _ => {}
            }
        }
        let mut out = patch.finish();
        if vn < v {
            if !out.ends_with(&eol[eol.len() - 1..]) {
                out.extend_from_slice(eol);
            }
            // A backslash at the end of the file would continue into what follows now.
            if out.trim_ascii_end().ends_with(b"\\") {
                out.extend_from_slice(eol);
            }
            push_attributes(&mut out, &normals[vn..v], uvs.map(|uvs| &uvs[vn..v]), eol);
        }
        out
    }

    /// The file with other texture coordinates; `corners` says for each corner which one. They stand before the first
    /// face, in place of all `vt` lines. A `vt` index that `l` elements name is left out.
    pub fn with_uvs(&self, uvs: &[Vec2], corners: &[Index]) -> Vec<u8> {
        assert_eq!(corners.len(), self.faces.items().len(), "one texture coordinate for each corner");
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
                        let named = self.faces.items()[corner];
                        push_wedge(patch.replace(token), named.position, Some(corners[corner]), named.normal());
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

    /// Material of carrier faces that had none.
    pub const CARRIER_MATERIAL: &str = "planish";
}

/// `v/vt/v` or `v//v`: the normal has the number of the vertex.
fn push_corner(out: &mut Vec<u8>, position: Index, uv: Option<Index>) {
    push_wedge(out, position, uv, Some(position));
}

fn push_wedge(out: &mut Vec<u8>, position: Index, uv: Option<Index>, normal: Option<Index>) {
    push_index(out, position);
    if uv.is_some() || normal.is_some() {
        out.push(b'/');
    }
    if let Some(uv) = uv {
        push_index(out, uv);
    }
    if let Some(normal) = normal {
        out.push(b'/');
        push_index(out, normal);
    }
}
