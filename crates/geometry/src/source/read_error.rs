//! Errors of the readers of PLY, STL, OFF and glTF files.
//!
//! ```
//! use planish_geometry::source::{off::Off, read_error::Place};
//!
//! let error = Off::parse(b"OFF\n3 1 0\n0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n".to_vec()).unwrap_err();
//! assert_eq!(error.place, Place::Line(4));
//! assert!(error.to_string().starts_with("line 4: ") && error.to_string().contains("`zero`"), "{error}");
//! ```

use super::format::Format;
use crate::mesh::jagged::Index;

/// Error in a mesh file: what is wrong, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}{kind}")]
pub struct ReadError {
    /// Place of the error.
    pub place: Place,
    /// Kind of the error.
    pub kind: ReadErrorKind,
}

/// Place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of text, counted from 1.
    Line(u32),
    /// An offset in bytes from the start of the file.
    Byte(u64),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, "line {line}: "),
            Self::Byte(byte) => write!(f, "byte {byte}: "),
        }
    }
}

/// Kinds of errors in a mesh file. Elements are counted from 0, as the formats do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReadErrorKind {
    /// The file has no bytes.
    #[error("the file is empty")]
    Empty,
    /// The file is not in the format that its name or its first bytes promise; the text says why.
    #[error("this is no {} file: {reason}", format.name().to_uppercase())]
    Foreign {
        /// Format that the file should have.
        format: Format,
        /// Reason why the file does not have it.
        reason: String,
    },
    /// The file breaks the rules of its format; the text says how.
    #[error("{0}")]
    Malformed(String),
    /// The file uses a part of its format that planish does not read.
    #[error("the file uses {0}, which planish does not read")]
    Unsupported(String),
    /// The file promises more elements than its size has space for.
    #[error("the file promises {count} × `{element}`, which need {needed} bytes or more, and has {left} left")]
    Truncated {
        /// Name of the elements.
        element: String,
        /// Number of elements that are promised.
        count: u64,
        /// Smallest number of bytes that they can have.
        needed: u128,
        /// Number of bytes that are left.
        left: usize,
    },
    /// The file ends within an element.
    #[error("the file ends within {element} {index}")]
    Ends {
        /// Name of the element.
        element: String,
        /// Index of the element.
        index: u64,
    },
    /// The token should be a number.
    #[error("{element} {index}: `{token}` is not a number")]
    NotANumber {
        /// Name of the element.
        element: String,
        /// Index of the element.
        index: u64,
        /// Text of the token.
        token: String,
    },
    /// The vertex has a coordinate that is NaN or infinite, and a face uses it.
    #[error("vertex {vertex}, which a face uses, has a coordinate that is not finite")]
    NotFinite {
        /// Index of the vertex.
        vertex: Index,
    },
    /// The face names a vertex that does not exist.
    #[error("face {face} names vertex {vertex}: there are {count}, counted from 0")]
    OutOfRange {
        /// Index of the face.
        face: u64,
        /// Index of the vertex, as the file has it.
        vertex: i64,
        /// Number of vertices.
        count: usize,
    },
    /// The file has no vertices.
    #[error("no vertices: the file has no mesh")]
    NoVertices,
    /// The file has no faces with three corners or more.
    #[error("no faces: planish works on surfaces, and these are points")]
    NoFaces,
    /// The file has more vertices or corners than 32 bits can count.
    #[error("more than 2^32 − 2 elements")]
    TooLarge,
}

impl ReadErrorKind {
    /// Makes the error at a place.
    pub(super) fn at(self, place: Place) -> ReadError {
        ReadError { place, kind: self }
    }
}

/// Text of a token for an error message, cut to 40 characters and escaped.
pub(super) fn shown(token: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(token).chars().take(40).collect();
    text.escape_debug().to_string()
}
