//! Tests of the spellings that files in the wild use, and of the bytes that are written.

mod corner_spellings;
mod errors;
mod layout;
mod numbers;
mod other_statements;
mod pieces;
mod writing;

use super::*;
use glam::{DVec2, DVec3, Vec2, Vec3};

/// Three vertices that a face can name.
const THREE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[track_caller]
fn parse(text: impl AsRef<[u8]>) -> Obj {
    Obj::parse(text.as_ref().to_vec()).unwrap()
}

/// Line and kind of the error.
#[track_caller]
fn error(text: impl AsRef<[u8]>) -> (Option<u32>, ObjErrorKind) {
    let ObjError { line, kind } = Obj::parse(text.as_ref().to_vec()).unwrap_err();
    (line, kind)
}

/// Indices that a corner names, counted from 0: position, uv, normal.
type Named = (Index, Option<Index>, Option<Index>);

fn corners(obj: &Obj) -> Vec<Vec<Named>> {
    obj.data().faces().iter().map(|face| face.iter().map(|c| (c.position, c.uv(), c.normal())).collect()).collect()
}

/// Position of each corner of each face.
fn faces(obj: &Obj) -> Vec<Vec<Index>> {
    obj.data().faces().iter().map(|face| face.iter().map(|c| c.position).collect()).collect()
}

/// A file must be the plain triangle, whatever its spelling.
#[track_caller]
fn is_the_triangle(text: impl AsRef<[u8]>) {
    let obj = parse(text);
    assert_eq!(obj.data().positions(), [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(faces(&obj), [[0, 1, 2]]);
}

fn bits(positions: &[DVec3]) -> Vec<[u64; 3]> {
    positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
}
