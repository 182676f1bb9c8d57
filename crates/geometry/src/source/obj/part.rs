//! Reader of a part of an OBJ file, which knows nothing of the others, so that parts can be read at the same time.

use super::Extras;
use super::error::{ObjError, ObjErrorKind, fits, not_a_number};
use super::scan::{self, Statement, Statements, Tokens, integer};
use crate::mesh::jagged::Index;
use crate::source::read_error::shown;
use crate::source::{Corner, MeshData};
use glam::DVec2;
use std::ops::Range;

/// Number of elements before a piece of a file.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Before {
    positions: usize,
    uvs: usize,
    normals: usize,
    corners: usize,
}

impl Before {
    pub(super) fn add(&mut self, part: &Part) {
        let MeshData { positions, uvs, normals, faces, .. } = &part.data;
        self.positions += positions.len();
        self.uvs += uvs.len();
        self.normals += normals.len();
        self.corners += faces.items().len();
    }
    /// Returns true if 32 bits can count the elements.
    pub(super) fn fits(&self) -> bool {
        let Self { positions, uvs, normals, corners } = *self;
        [positions, uvs, normals, corners].into_iter().all(|count| fits(count).is_ok())
    }
}

/// Something odd that is handled: how often there is such a thing, and its first line.
#[derive(Clone, Debug, Default)]
pub(super) struct Oddity {
    count: usize,
    line: u32,
}

impl Oddity {
    pub(super) fn add(&mut self, line: u32) {
        self.append(&Self { count: 1, line }, 0);
    }
    /// Adds those of a part that begins after so many lines.
    pub(super) fn append(&mut self, part: &Self, lines: u32) {
        if part.count > 0 {
            let line = lines + part.line;
            self.line = if self.count == 0 { line } else { self.line.min(line) };
            self.count += part.count;
        }
    }
    /// Note about it; `None` if there is no such thing.
    pub(super) fn note(&self, one: &str, many: &str, what: &str) -> Option<String> {
        let Self { count, line } = self;
        let things = if *count == 1 { one } else { many };
        (*count > 0).then(|| format!("{count} {things} {what}, the first in line {line}"))
    }
}

/// Largest index of a vertex so far. It is checked when all lines are known, because faces may come before vertices.
#[derive(Clone, Debug, Default)]
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
    /// The index and its line; `None` if there is no index.
    pub(super) fn found(&self) -> Option<(Index, u32)> {
        (self.line != 0).then_some((self.index, self.line))
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

/// Contents of a piece of a file. Lines and the places of elements count from the start of the piece, and the indices of corners from
/// that of the file.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// Number of elements before the piece; `None` while it is not known.
    before: Option<Before>,
    pub(super) data: MeshData,
    pub(super) non_finite_uvs: Vec<(Index, u32)>,
    /// Index, line and token of each `v` line that is not finite.
    pub(super) non_finite: Vec<(Index, u32, String)>,
    pub(super) extras: Extras,
    pub(super) highest: Highest,
    /// Number of faces before each `usemtl` statement, and where its argument is.
    pub(super) materials: Vec<(Index, Range<usize>)>,
    pub(super) short_faces: Oddity,
    pub(super) zero_indices: Oddity,
    pub(super) absent: Oddity,
    /// Number of physical lines.
    pub(super) lines: u32,
    /// First error with its line; nothing behind it was read.
    pub(super) error: Option<(u32, ObjErrorKind)>,
    is_relative: bool,
}

impl Part {
    /// Reads a piece of the file `bytes`. Without the number of elements before the piece relative indices mean nothing, and
    /// [`Self::is_relative`] says that there are some.
    pub(super) fn read(&mut self, bytes: &[u8], piece: Range<usize>, before: Option<Before>) {
        let MeshData { mut positions, mut colours, mut uvs, mut normals, mut faces, mut face_lines, .. } =
            std::mem::take(&mut self.data);
        // Memory that was touched before costs no page faults again.
        positions.clear();
        colours.clear();
        uvs.clear();
        normals.clear();
        faces.clear();
        face_lines.clear();
        let data = MeshData { positions, colours, uvs, normals, faces, face_lines, ..MeshData::default() };
        *self = Self { before, data, ..Self::default() };
        let mut statements = Statements::of_piece(bytes, piece);
        for statement in statements.by_ref() {
            if let Err(kind) = self.statement(bytes, &statement) {
                self.error = Some((statement.line, kind));
                break;
            }
        }
        self.lines = statements.lines();
    }

    /// Returns true if corners count from the end of lines whose number was not known.
    pub(super) fn is_relative(&self) -> bool {
        self.is_relative
    }

    /// Number of elements so far, with those before the piece if that is known.
    fn counts(&self) -> Before {
        let mut counts = self.before.unwrap_or_default();
        counts.add(self);
        counts
    }

    fn statement(&mut self, bytes: &[u8], statement: &Statement) -> Result<(), ObjErrorKind> {
        match &bytes[statement.keyword.clone()] {
            b"v" => self.position(bytes, statement)?,
            b"vt" => self.uv(bytes, statement)?,
            b"vn" => self.normal(bytes, statement)?,
            b"f" | b"fo" => self.face(bytes, statement)?,
            b"l" => self.extras.lines += 1,
            b"p" => self.extras.points += 1,
            b"o" => self.extras.objects += 1,
            b"g" => self.extras.groups += 1,
            b"s" => self.extras.smoothing_groups += 1,
            b"mtllib" => {
                self.extras.material_libraries.push(scan::name(bytes, statement).to_vec());
            }
            b"usemtl" => self.materials.push((self.data.faces.len() as Index, scan::name_range(bytes, statement))),
            _ => self.extras.other += 1,
        }
        Ok(())
    }

    fn position(&mut self, bytes: &[u8], statement: &Statement) -> Result<(), ObjErrorKind> {
        let mut tokens = Tokens::new(bytes, statement);
        let mut p = [0.0_f64; 3];
        for (found, x) in p.iter_mut().enumerate() {
            let Some((token, number)) = tokens.number() else {
                return Err(ObjErrorKind::TooFewNumbers { keyword: "v", needed: 3, found });
            };
            let token = &bytes[token];
            *x = number.ok_or_else(|| not_a_number(token))?;
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
            let colour = fourth.and_then(|red| colour(bytes, [Some(red), tokens.next(), tokens.next()]));
            self.data.colours.extend(colour.filter(|_| tokens.next().is_none()));
        }
        self.data.positions.push(p.into());
        fits(self.counts().positions)
    }

    fn uv(&mut self, bytes: &[u8], statement: &Statement) -> Result<(), ObjErrorKind> {
        let mut tokens = Tokens::new(bytes, statement);
        let mut uv = [0.0; 2];
        for (found, x) in uv.iter_mut().enumerate() {
            match tokens.number() {
                Some((token, number)) => *x = number.ok_or_else(|| not_a_number(&bytes[token]))?,
                None if found == 0 => return Err(ObjErrorKind::TooFewNumbers { keyword: "vt", needed: 1, found }),
                // The second number is optional, with 0 as its default.
                None => {}
            }
        }
        let uv = DVec2::from(uv);
        if !uv.is_finite() {
            self.non_finite_uvs.push((self.data.uvs.len() as Index, statement.line));
        }
        self.data.uvs.push(uv);
        fits(self.counts().uvs)
    }

    fn normal(&mut self, bytes: &[u8], statement: &Statement) -> Result<(), ObjErrorKind> {
        let mut tokens = Tokens::new(bytes, statement);
        let mut n = [0.0; 3];
        for (found, x) in n.iter_mut().enumerate() {
            let Some((token, number)) = tokens.number() else {
                return Err(ObjErrorKind::TooFewNumbers { keyword: "vn", needed: 3, found });
            };
            *x = number.ok_or_else(|| not_a_number(&bytes[token]))?;
        }
        self.data.normals.push(n.into());
        fits(self.counts().normals)
    }

    fn face(&mut self, bytes: &[u8], statement: &Statement) -> Result<(), ObjErrorKind> {
        let mut tokens = Tokens::new(bytes, statement);
        loop {
            let corner = match tokens.plain_corner() {
                Some(corner) => {
                    self.highest.update(corner.position, statement.line);
                    corner
                }
                None => match tokens.next() {
                    Some(token) => self.corner(&bytes[token], statement.line)?,
                    None => break,
                },
            };
            self.data.faces.extend_open(corner);
        }
        if self.data.faces.close_if(3) {
            self.data.face_lines.push(statement.line);
        } else {
            self.short_faces.add(statement.line);
        }
        fits(self.counts().corners)
    }

    fn corner(&mut self, token: &[u8], line: u32) -> Result<Corner, ObjErrorKind> {
        let bad = || ObjErrorKind::BadCorner(shown(token));
        let Before { positions, uvs, normals, .. } = self.counts();
        let counts = [positions, uvs, normals];
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
                _ if self.before.is_none() => {
                    self.is_relative = true;
                    0
                }
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

/// Reads the colour from three numbers after the coordinates; `None` if there are fewer, as a single one is a weight.
fn colour(bytes: &[u8], tokens: [Option<Range<usize>>; 3]) -> Option<[f32; 3]> {
    let mut colour = [0.0; 3];
    for (x, token) in colour.iter_mut().zip(tokens) {
        *x = fast_float2::parse(&bytes[token?]).ok().filter(|x: &f32| x.is_finite())?;
    }
    Some(colour)
}
