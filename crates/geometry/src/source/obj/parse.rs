//! Reader of OBJ files.

use super::error::{ObjError, ObjErrorKind};
use super::part::{Before, Highest, Oddity, Part};
use super::{Extras, Obj, Piece, scan};
use crate::mesh::jagged::Index;
use crate::source::MeshData;
use crate::source::mesh_data::MaterialRun;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::ops::Range;

/// Number of bytes at the start of a file that are searched for a NUL, the sign of a binary file.
const SNIFFED: usize = 4096;

/// Bytes of a piece of a file: few enough to stay in the cache of a core, and many beside the cost of a task.
const PIECE: usize = 1 << 20;
/// Number of pieces that are read at the same time. Their memory serves again, so it stays small beside that of the whole.
const ROUND: usize = 16;

pub(super) fn parse(bytes: Vec<u8>) -> Result<Obj, ObjError> {
    parse_in_pieces(bytes, PIECE)
}

/// Reads a file in pieces of at least so many bytes; the result is the same for any number.
pub(super) fn parse_in_pieces(bytes: Vec<u8>, size: usize) -> Result<Obj, ObjError> {
    let whole = |kind| ObjError { line: None, kind };
    if bytes.is_empty() {
        return Err(whole(ObjErrorKind::Empty));
    }
    // Only what cannot be read is called binary: a writer may move a NUL of a comment to the start of the file.
    let read = read(&bytes, size).and_then(Contents::finish).map_err(|e| {
        if matches!(bytes[..], [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) {
            return whole(ObjErrorKind::Utf16);
        }
        let zero = memchr::memchr(0, &bytes[..bytes.len().min(SNIFFED)]);
        zero.map_or_else(|| with_capital(e, &bytes), |offset| whole(ObjErrorKind::Binary { offset }))
    });
    let (contents, notes) = read?;
    let Contents { data, non_finite_uvs, extras, pieces, .. } = contents;
    Ok(Obj { bytes, data, non_finite_uvs, extras, notes, pieces })
}

/// The error of a file that lacks vertices or faces, with the line where their keyword is written as a capital, if there is one.
fn with_capital(error: ObjError, bytes: &[u8]) -> ObjError {
    let keyword = match error.kind {
        ObjErrorKind::NoVertices => "v",
        ObjErrorKind::NoFaces => "f",
        _ => return error,
    };
    let capital = keyword.to_uppercase();
    let is_capital = |word: &[u8]| word == capital.as_bytes();
    match scan::Statements::new(bytes).find(|statement| is_capital(&bytes[statement.keyword.clone()])) {
        Some(statement) => ObjError { line: Some(statement.line), kind: ObjErrorKind::Capital { keyword } },
        None => error,
    }
}

fn read(bytes: &[u8], size: usize) -> Result<Contents, ObjError> {
    let pieces = scan::pieces(bytes, size);
    let mut contents = Contents::default();
    let [mut parts, mut next] = [(); 2].map(|()| vec![Part::default(); ROUND.min(pieces.len())]);
    let mut rounds = pieces.chunks(ROUND).peekable();
    let mut before = Before::default();
    if let Some(first) = rounds.peek() {
        read_round(bytes, first, &mut parts, &mut before);
    }
    while let Some(round) = rounds.next() {
        // While the parts of a round are put together, those of the next one are read.
        let append = || round.iter().zip(&parts).try_for_each(|(piece, part)| contents.append(bytes, piece, part));
        let read_next = || rounds.peek().map(|following| read_round(bytes, following, &mut next, &mut before));
        rayon::join(append, read_next).0?;
        std::mem::swap(&mut parts, &mut next);
    }
    Ok(contents)
}

/// Reads pieces that follow the lines of `before`, which then includes theirs.
fn read_round(bytes: &[u8], pieces: &[Range<usize>], parts: &mut [Part], before: &mut Before) {
    parts.par_iter_mut().zip(pieces).for_each(|(part, piece)| part.read(bytes, piece.clone(), None));
    let mut again = Vec::new();
    for (part, piece) in parts.iter_mut().zip(pieces) {
        let start = *before;
        before.add(part);
        // Relative indices need the number of lines before the piece, as does the line at which there are too many.
        if part.is_relative() || !before.fits() {
            again.push((part, piece, start));
        }
    }
    again.into_par_iter().for_each(|(part, piece, start)| part.read(bytes, piece.clone(), Some(start)));
}

/// Contents of a file, as far as its parts have been put together.
#[derive(Default)]
struct Contents {
    data: MeshData,
    /// Index and line of each `vt` line that is not finite.
    non_finite_uvs: Vec<(Index, u32)>,
    /// Index, line and token of each `v` line that is not finite.
    non_finite: Vec<(Index, u32, String)>,
    extras: Extras,
    highest: Highest,
    /// Index of each material by its name.
    materials: FxHashMap<Vec<u8>, Index>,
    short_faces: Oddity,
    zero_indices: Oddity,
    absent: Oddity,
    /// Number of physical lines.
    lines: u32,
    pieces: Vec<Piece>,
}

impl Contents {
    /// Appends the part that was read from a piece. Fails with the first error of the part.
    fn append(&mut self, bytes: &[u8], piece: &Range<usize>, part: &Part) -> Result<(), ObjError> {
        let lines = self.lines;
        if let Some((line, kind)) = &part.error {
            return Err(ObjError { line: Some(lines + line), kind: kind.clone() });
        }
        let data = &mut self.data;
        let [v, vt, f] = [data.positions.len(), data.uvs.len(), data.faces.len()].map(|count| count as Index);
        let vn = data.normals.len() as Index;
        self.pieces.push(Piece { bytes: piece.clone(), vertices: v, normals: vn });
        for (faces, name) in &part.materials {
            self.name_material(&bytes[name.clone()], f + faces);
        }
        let data = &mut self.data;
        // Colours are kept as long as every vertex has had one.
        if data.colours.len() == data.positions.len() {
            data.colours.extend_from_slice(&part.data.colours);
        }
        data.positions.extend_from_slice(&part.data.positions);
        data.uvs.extend_from_slice(&part.data.uvs);
        data.normals.extend_from_slice(&part.data.normals);
        data.faces.append(&part.data.faces);
        data.face_lines.extend(part.data.face_lines.iter().map(|line| lines + line));
        self.non_finite_uvs.extend(part.non_finite_uvs.iter().map(|(uv, line)| (vt + uv, lines + line)));
        let non_finite = part.non_finite.iter();
        self.non_finite.extend(non_finite.map(|(vertex, line, token)| (v + vertex, lines + line, token.clone())));
        self.extras.append(&part.extras);
        if let Some((index, line)) = part.highest.found() {
            self.highest.update(index, lines + line);
        }
        self.short_faces.append(&part.short_faces, lines);
        self.zero_indices.append(&part.zero_indices, lines);
        self.absent.append(&part.absent, lines);
        self.lines += part.lines;
        Ok(())
    }

    /// Begins the faces of a material.
    fn name_material(&mut self, name: &[u8], first_face: Index) {
        let material = match self.materials.get(name) {
            Some(&known) => known,
            None => {
                let new = self.data.materials.len() as Index;
                self.data.materials.push(name.to_vec());
                self.materials.insert(name.to_vec(), new);
                new
            }
        };
        let run = MaterialRun { first_face, material: Some(material) };
        match self.data.material_runs.last_mut() {
            // Exporters repeat the statement for each group, and may name another material before any face.
            Some(last) if last.material == run.material => {}
            Some(last) if last.first_face == run.first_face => *last = run,
            _ => self.data.material_runs.push(run),
        }
    }

    /// Checks what is known only at the end, and adds notes on what is odd.
    fn finish(mut self) -> Result<(Self, Vec<String>), ObjError> {
        let whole = |kind| ObjError { line: None, kind };
        let data = &mut self.data;
        if data.positions.is_empty() {
            return Err(whole(ObjErrorKind::NoVertices));
        }
        if data.faces.is_empty() {
            return Err(whole(ObjErrorKind::NoFaces));
        }
        self.highest.check(data.positions.len())?;
        if let Err(used) = data.place_unused() {
            let at = self.non_finite.binary_search_by_key(&used, |(index, ..)| *index).unwrap_or_default();
            let (_, line, token) = self.non_finite[at].clone();
            return Err(ObjError { line: Some(line), kind: ObjErrorKind::NotFinite(token) });
        }
        for face in data.drop_broken_attributes() {
            self.absent.add(data.face_lines[face as usize]);
        }
        let mut unplaced = Oddity::default();
        self.non_finite.iter().for_each(|(_, line, _)| unplaced.add(*line));
        let notes = [
            self.short_faces.note("`f` line has", "`f` lines have", "fewer than three corners and stay as they are"),
            self.zero_indices.note("corner has", "corners have", "an index 0 for `vt` or `vn`, which is read as none"),
            self.absent.note(
                "corner names",
                "corners name",
                "a `vt` or `vn` that does not exist or is not finite, and count as without",
            ),
            unplaced.note(
                "`v` line that no face uses is",
                "`v` lines that no face uses are",
                "not finite and stay as they are",
            ),
        ];
        if data.colours.len() != data.positions.len() {
            data.colours = Vec::new();
        }
        let notes = notes.into_iter().flatten().collect();
        Ok((self, notes))
    }
}
