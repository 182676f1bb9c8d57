//! OBJ files piece by piece.

use super::error::{ObjError, ObjErrorKind, fits, not_a_number};
use super::part::Highest;
use super::rewrite::replace_numbers;
use super::scan::{Statement, Statements, Tokens, integer};
use crate::mesh::jagged::Index;
use crate::source::patch::Patch;
use crate::source::read_error::shown;
use crate::source::stream::piece::{Change, Piece, Receiver};
use glam::DVec3;

/// State of a file that is read or rewritten piece by piece.
#[derive(Debug, Default)]
pub(crate) struct ObjStream {
    /// Number of `v` lines so far.
    vertices: usize,
    /// Number of physical lines so far.
    lines: u32,
    faces: usize,
    highest: Highest,
    /// Corners of a face; scratch memory.
    corners: Vec<Index>,
}

/// Number of bytes of a piece up to the end of its last statement. A line that is continued has not ended.
fn whole(piece: Piece) -> usize {
    if piece.is_last {
        return piece.bytes.len();
    }
    let ends = memchr::memrchr_iter(b'\n', piece.bytes);
    let is_continued = |end: usize| {
        let line = &piece.bytes[..end];
        line.strip_suffix(b"\r").unwrap_or(line).ends_with(b"\\")
    };
    ends.into_iter().find(|end| !is_continued(*end)).map_or(0, |end| end + 1)
}

impl ObjStream {
    pub(crate) fn read(&mut self, piece: Piece, receiver: &mut dyn Receiver) -> Result<usize, ObjError> {
        let bytes = &piece.bytes[..whole(piece)];
        for statement in Statements::new(bytes) {
            let line = self.lines + statement.line;
            self.statement(bytes, &statement, line, receiver).map_err(|kind| ObjError { line: Some(line), kind })?;
        }
        self.lines += memchr::memchr_iter(b'\n', bytes).count() as u32;
        Ok(bytes.len())
    }

    pub(crate) fn finish(&self) -> Result<(), ObjError> {
        let whole = |kind| ObjError { line: None, kind };
        if self.vertices == 0 {
            return Err(whole(ObjErrorKind::NoVertices));
        }
        if self.faces == 0 {
            return Err(whole(ObjErrorKind::NoFaces));
        }
        self.highest.check(self.vertices)
    }

    fn statement(
        &mut self,
        bytes: &[u8],
        statement: &Statement,
        line: u32,
        receiver: &mut dyn Receiver,
    ) -> Result<(), ObjErrorKind> {
        match &bytes[statement.keyword.clone()] {
            b"v" => {
                receiver.vertex(position(bytes, statement)?);
                self.vertices += 1;
                fits(self.vertices)
            }
            b"f" | b"fo" => {
                self.corners.clear();
                for token in Tokens::new(bytes, statement) {
                    let corner = self.corner(&bytes[token])?;
                    self.highest.update(corner, line);
                    self.corners.push(corner);
                }
                if self.corners.len() >= 3 {
                    receiver.face(&self.corners);
                    self.faces += 1;
                }
                fits(self.faces)
            }
            _ => Ok(()),
        }
    }

    /// Source vertex of a corner.
    fn corner(&self, token: &[u8]) -> Result<Index, ObjErrorKind> {
        let bad = || ObjErrorKind::BadCorner(shown(token));
        let first = token.split(|b| *b == b'/').next().unwrap_or_default();
        match integer(first).ok_or_else(bad)? {
            0 => Err(ObjErrorKind::ZeroIndex(shown(token))),
            index @ 1.. => Index::try_from(index - 1).ok().filter(|v| *v != Index::MAX).ok_or_else(bad),
            index => usize::try_from(self.vertices as i64 + index)
                .map(|v| v as Index)
                .map_err(|_| ObjErrorKind::OutOfRange { index, count: self.vertices }),
        }
    }

    pub(crate) fn rewrite(&mut self, piece: Piece, next: &mut dyn FnMut() -> Change, out: &mut Vec<u8>) -> usize {
        let bytes = &piece.bytes[..whole(piece)];
        let mut patch = Patch::new(bytes);
        for statement in Statements::new(bytes).filter(|s| &bytes[s.keyword.clone()] == b"v") {
            replace_numbers(&mut patch, &statement, next());
        }
        out.append(&mut patch.finish());
        bytes.len()
    }
}

fn position(bytes: &[u8], statement: &Statement) -> Result<DVec3, ObjErrorKind> {
    let mut tokens = Tokens::new(bytes, statement);
    let mut p = [0.0; 3];
    for (found, x) in p.iter_mut().enumerate() {
        let (token, number) = tokens.number().ok_or(ObjErrorKind::TooFewNumbers { keyword: "v", needed: 3, found })?;
        *x = number.ok_or_else(|| not_a_number(&bytes[token.clone()]))?;
        if !x.is_finite() {
            return Err(ObjErrorKind::NotFinite(shown(&bytes[token])));
        }
    }
    Ok(p.into())
}
