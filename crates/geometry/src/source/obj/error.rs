//! Errors in OBJ files.

use crate::mesh::jagged::Index;
use crate::source::read_error::shown;

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
    /// The file has no `v` or no `f` statement, but a line begins with the letter as a capital.
    #[error("`{}` is no keyword of OBJ, and other programs skip such lines: write `{keyword}`", keyword.to_uppercase())]
    Capital {
        /// Keyword of OBJ: `v` or `f`.
        keyword: &'static str,
    },
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

/// Error of a token that should be a number.
pub(super) fn not_a_number(token: &[u8]) -> ObjErrorKind {
    ObjErrorKind::NotANumber(shown(token))
}

/// Returns an error if 32 bits cannot count so many elements.
pub(super) fn fits(count: usize) -> Result<(), ObjErrorKind> {
    if count < Index::MAX as usize { Ok(()) } else { Err(ObjErrorKind::TooLarge) }
}
