//! Reader of OBJ files.

use super::scan::{self, Statement, Statements, Tokens};
use super::{Extras, Obj};
use crate::mesh::jagged::Index;
use crate::source::mesh_data::MaterialRun;
use crate::source::patch::lenient_number;
use crate::source::read_error::shown;
use crate::source::{Corner, MeshData};
use glam::DVec2;
use rustc_hash::FxHashMap;
use std::ops::Range;

/// Error in an OBJ file: what is wrong and in which line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{kind}", line.map(|line| format!("line {line}: ")).unwrap_or_default())]
pub struct ObjError {
    /// Line of the error, counted from 1; `None` if the file as a whole is wrong.
    pub line: Option<u32>,
    /// Kind of the error.
    pub kind: ObjErrorKind,
}

/// Kinds of errors in an OBJ file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ObjErrorKind {
    /// The file has no bytes.
    #[error("the file is empty")]
    Empty,
    /// The file has a NUL byte near its start, so it is not text.
    #[error("this is a binary file, not an OBJ (byte {offset} is NUL)")]
    Binary {
        /// Offset of the first NUL byte.
        offset: usize,
    },
    /// The file has no `v` statement.
    #[error("no vertices: there is no `v` statement, so this is not an OBJ mesh")]
    NoVertices,
    /// The file has no `f` statement.
    #[error("no faces: there is no `f` statement, and planish works on surfaces")]
    NoFaces,
    /// The file has the byte order mark of UTF-16.
    #[error("this is UTF-16 text: save it as UTF-8")]
    Utf16,
    /// The token should be a number.
    #[error("`{0}` is not a number{hint}", hint = comma_hint(.0))]
    NotANumber(String),
    /// The coordinate is NaN or infinite.
    #[error("coordinate `{0}` is not finite")]
    NotFinite(String),
    /// The statement has too few numbers.
    #[error("`{keyword}` needs {needed} numbers, found {found}")]
    TooFewNumbers {
        /// Keyword of the statement: `v`, `vt` or `vn`.
        keyword: &'static str,
        /// Number of numbers that the statement needs.
        needed: usize,
        /// Number of numbers that it has.
        found: usize,
    },
    /// The corner is not spelled `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    #[error("`{0}` is not a face corner (v, v/vt, v//vn or v/vt/vn)")]
    BadCorner(String),
    /// The corner has an index 0 for its vertex, but indices count from 1.
    #[error("index 0 in `{0}`: OBJ counts from 1")]
    ZeroIndex(String),
    /// The index names no `v` line.
    #[error("index {index} names no `v` line: there are {count}")]
    OutOfRange {
        /// Index as it is written, counted from 1 or, if negative, backwards from the line.
        index: i64,
        /// Number of such lines in the file; for a negative index, before the line.
        count: usize,
    },
    /// The file has more vertices or corners than 32 bits can count.
    #[error("more than 2^32 − 2 elements")]
    TooLarge,
}

/// Advice for a number with a decimal comma.
fn comma_hint(token: &str) -> &'static str {
    let is_number = token.replacen(',', ".", 1).parse::<f64>().is_ok();
    if token.contains(',') && is_number { ": it has a decimal comma, and OBJ needs a point" } else { "" }
}

/// Number of bytes at the start of a file that are searched for a NUL, the sign of a binary file.
const SNIFFED: usize = 4096;

/// Largest index of a vertex so far. It is checked when all lines are known, because faces may come before vertices.
#[derive(Debug, Default)]
pub(super) struct Highest {
    index: Index,
    line: u32,
}

impl Highest {
    pub(super) fn update(&mut self, index: Index, line: u32) {
        if self.line == 0 || index > self.index {
            *self = Self { index, line };
        }
    }
    pub(super) fn check(&self, count: usize) -> Result<(), ObjError> {
        if self.line != 0 && self.index as usize >= count {
            let index = i64::from(self.index) + 1;
            let kind = ObjErrorKind::OutOfRange { index, count };
            return Err(ObjError { line: Some(self.line), kind });
        }
        Ok(())
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    data: MeshData,
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
}

/// Something odd that is handled: how often there is such a thing, and its first line.
#[derive(Default)]
struct Oddity {
    count: usize,
    line: u32,
}

impl Oddity {
    fn add(&mut self, line: u32) {
        self.count += 1;
        self.line = if self.line == 0 { line } else { self.line.min(line) };
    }
    /// Note about it; `None` if there is no such thing.
    fn note(&self, one: &str, many: &str, what: &str) -> Option<String> {
        let Self { count, line } = self;
        let things = if *count == 1 { one } else { many };
        (*count > 0).then(|| format!("{count} {things} {what}, the first in line {line}"))
    }
}

pub(super) fn parse(bytes: Vec<u8>) -> Result<Obj, ObjError> {
    let whole = |kind| ObjError { line: None, kind };
    if bytes.is_empty() {
        return Err(whole(ObjErrorKind::Empty));
    }
    // Only what cannot be read is called binary: a writer may move a NUL of a comment to the start of the file.
    let read = read(&bytes).map_err(|e| {
        if matches!(bytes[..], [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) {
            return whole(ObjErrorKind::Utf16);
        }
        let zero = memchr::memchr(0, &bytes[..bytes.len().min(SNIFFED)]);
        zero.map_or(e, |offset| whole(ObjErrorKind::Binary { offset }))
    });
    let (data, non_finite_uvs, extras, notes) = read?;
    Ok(Obj { bytes, data, non_finite_uvs, extras, notes })
}

/// Contents of a file: its mesh data, the index and line of each `vt` line that is not finite, the rest, and what is odd.
type Contents = (MeshData, Vec<(Index, u32)>, Extras, Vec<String>);

fn read(bytes: &[u8]) -> Result<Contents, ObjError> {
    let whole = |kind| ObjError { line: None, kind };
    let mut reader = Reader {
        bytes,
        data: MeshData::default(),
        non_finite_uvs: Vec::new(),
        non_finite: Vec::new(),
        extras: Extras::default(),
        highest: Highest::default(),
        short_faces: Oddity::default(),
        zero_indices: Oddity::default(),
        absent: Oddity::default(),
        materials: FxHashMap::default(),
    };
    for statement in Statements::new(bytes) {
        reader.statement(&statement).map_err(|kind| ObjError { line: Some(statement.line), kind })?;
    }
    let Reader { mut data, non_finite_uvs, non_finite, extras, highest, short_faces, zero_indices, mut absent, .. } =
        reader;
    if data.positions.is_empty() {
        return Err(whole(ObjErrorKind::NoVertices));
    }
    if data.faces.is_empty() {
        return Err(whole(ObjErrorKind::NoFaces));
    }
    highest.check(data.positions.len())?;
    if let Err(used) = data.place_unused() {
        let at = non_finite.binary_search_by_key(&used, |(index, ..)| *index).unwrap_or_default();
        let (_, line, token) = non_finite[at].clone();
        return Err(ObjError { line: Some(line), kind: ObjErrorKind::NotFinite(token) });
    }
    for face in data.drop_broken_attributes() {
        absent.add(data.face_lines[face as usize]);
    }
    let mut unplaced = Oddity::default();
    non_finite.iter().for_each(|(_, line, _)| unplaced.add(*line));
    let notes = [
        short_faces.note("`f` line has", "`f` lines have", "fewer than three corners and stay as they are"),
        zero_indices.note("corner has", "corners have", "an index 0 for `vt` or `vn`, which is read as none"),
        absent.note(
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
    Ok((data, non_finite_uvs, extras, notes))
}

impl Reader<'_> {
    fn statement(&mut self, statement: &Statement) -> Result<(), ObjErrorKind> {
        match &self.bytes[statement.keyword.clone()] {
            b"v" => self.position(statement)?,
            b"vt" => self.uv(statement)?,
            b"vn" => self.normal(statement)?,
            b"f" | b"fo" => self.face(statement)?,
            b"l" => self.extras.lines += 1,
            b"p" => self.extras.points += 1,
            b"o" => self.extras.objects += 1,
            b"g" => self.extras.groups += 1,
            b"s" => self.extras.smoothing_groups += 1,
            b"mtllib" => {
                self.extras.material_libraries.push(scan::name(self.bytes, statement).to_vec());
            }
            b"usemtl" => self.material(scan::name(self.bytes, statement)),
            _ => self.extras.other += 1,
        }
        Ok(())
    }

    fn material(&mut self, name: &[u8]) {
        let material = match self.materials.get(name) {
            Some(&known) => known,
            None => {
                let new = self.data.materials.len() as Index;
                self.data.materials.push(name.to_vec());
                self.materials.insert(name.to_vec(), new);
                new
            }
        };
        let run = MaterialRun { first_face: self.data.faces.len() as Index, material: Some(material) };
        match self.data.material_runs.last_mut() {
            // Exporters repeat the statement for each group, and may name another material before any face.
            Some(last) if last.material == run.material => {}
            Some(last) if last.first_face == run.first_face => *last = run,
            _ => self.data.material_runs.push(run),
        }
    }

    fn position(&mut self, statement: &Statement) -> Result<(), ObjErrorKind> {
        let mut tokens = Tokens::new(self.bytes, statement);
        let mut p = [0.0_f64; 3];
        for (found, x) in p.iter_mut().enumerate() {
            let Some(token) = tokens.next() else {
                return Err(ObjErrorKind::TooFewNumbers { keyword: "v", needed: 3, found });
            };
            let token = &self.bytes[token];
            *x = lenient(token)?;
            let index = self.data.positions.len() as Index;
            // Whether a face uses the vertex is known only at the end.
            if !x.is_finite() && self.non_finite.last().is_none_or(|(last, ..)| *last != index) {
                self.non_finite.push((index, statement.line, shown(token)));
            }
        }
        let fourth = tokens.next();
        self.extras.extended_vertices += usize::from(fourth.is_some());
        // Colours are kept as long as every vertex has had one.
        if self.data.colours.len() == self.data.positions.len() {
            let colour = fourth.and_then(|red| self.colour([Some(red), tokens.next(), tokens.next()]));
            self.data.colours.extend(colour.filter(|_| tokens.next().is_none()));
        }
        self.data.positions.push(p.into());
        fits(self.data.positions.len())
    }

    /// Reads the colour from three numbers after the coordinates; `None` if there are fewer, as a single one is a weight.
    fn colour(&self, tokens: [Option<Range<usize>>; 3]) -> Option<[f32; 3]> {
        let mut colour = [0.0; 3];
        for (x, token) in colour.iter_mut().zip(tokens) {
            *x = fast_float2::parse(&self.bytes[token?]).ok().filter(|x: &f32| x.is_finite())?;
        }
        Some(colour)
    }

    fn uv(&mut self, statement: &Statement) -> Result<(), ObjErrorKind> {
        let mut tokens = Tokens::new(self.bytes, statement);
        let Some(u) = tokens.next() else {
            return Err(ObjErrorKind::TooFewNumbers { keyword: "vt", needed: 1, found: 0 });
        };
        let u = lenient(&self.bytes[u])?;
        // The second number is optional, with 0 as its default.
        let v = tokens.next().map_or(Ok(0.0), |token| lenient(&self.bytes[token]))?;
        let uv = DVec2::new(u, v);
        if !uv.is_finite() {
            self.non_finite_uvs.push((self.data.uvs.len() as Index, statement.line));
        }
        self.data.uvs.push(uv);
        fits(self.data.uvs.len())
    }

    fn normal(&mut self, statement: &Statement) -> Result<(), ObjErrorKind> {
        let mut tokens = Tokens::new(self.bytes, statement);
        let mut n = [0.0; 3];
        for (found, x) in n.iter_mut().enumerate() {
            let Some(token) = tokens.next() else {
                return Err(ObjErrorKind::TooFewNumbers { keyword: "vn", needed: 3, found });
            };
            *x = lenient(&self.bytes[token])?;
        }
        self.data.normals.push(n.into());
        fits(self.data.normals.len())
    }

    fn face(&mut self, statement: &Statement) -> Result<(), ObjErrorKind> {
        for token in Tokens::new(self.bytes, statement) {
            let corner = self.corner(&self.bytes[token], statement.line)?;
            self.data.faces.extend_open(corner);
        }
        if self.data.faces.close_if(3) {
            self.data.face_lines.push(statement.line);
        } else {
            self.short_faces.add(statement.line);
        }
        fits(self.data.faces.items().len())
    }

    fn corner(&mut self, token: &[u8], line: u32) -> Result<Corner, ObjErrorKind> {
        let bad = || ObjErrorKind::BadCorner(shown(token));
        let counts = [self.data.positions.len(), self.data.uvs.len(), self.data.normals.len()];
        let mut named = [None; 3];
        for (k, part) in token.split(|&b| b == b'/').enumerate() {
            if k == 3 {
                return Err(bad());
            }
            if part.is_empty() {
                continue;
            }
            let index = integer(part).ok_or_else(bad)?;
            let index = match index {
                0 if k > 0 => {
                    self.zero_indices.add(line);
                    continue;
                }
                0 => return Err(ObjErrorKind::ZeroIndex(shown(token))),
                1.. => match Index::try_from(index - 1) {
                    Ok(index) if k == 0 || index != Index::MAX => index,
                    _ if k > 0 => {
                        self.absent.add(line);
                        continue;
                    }
                    _ => return Err(bad()),
                },
                _ => match usize::try_from(counts[k] as i64 + index) {
                    Ok(index) => index as Index,
                    Err(_) if k > 0 => {
                        self.absent.add(line);
                        continue;
                    }
                    Err(_) => return Err(ObjErrorKind::OutOfRange { index, count: counts[k] }),
                },
            };
            named[k] = Some(index);
            if k == 0 {
                self.highest.update(index, line);
            }
        }
        let [position, uv, normal] = named;
        let position = position.filter(|p| *p != Index::MAX).ok_or_else(bad)?;
        Ok(Corner::new(position, uv, normal))
    }
}

/// Parses a decimal integer of at most 18 digits.
pub(super) fn integer(text: &[u8]) -> Option<i64> {
    let (negative, digits) = match text {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value * 10 + i64::from(digit - b'0');
    }
    Some(if negative { -value } else { value })
}

/// Parses a number of a `vt` or `vn` line; every spelling of NaN becomes NaN. Exporters write it there, and a mesh with broken
/// shading can still be denoised.
pub(super) fn lenient(token: &[u8]) -> Result<f64, ObjErrorKind> {
    lenient_number(token).ok_or_else(|| ObjErrorKind::NotANumber(shown(token)))
}

/// Returns an error if 32 bits cannot count so many elements.
pub(super) fn fits(count: usize) -> Result<(), ObjErrorKind> {
    if count < Index::MAX as usize { Ok(()) } else { Err(ObjErrorKind::TooLarge) }
}
