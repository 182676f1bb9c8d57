//! A piece of a mesh file, and what is found in it.

use crate::mesh::jagged::Index;
use glam::DVec3;

/// Receiver of the elements of a mesh, in the order of the file.
pub trait Receiver {
    /// Takes the position of the next source vertex (model units), which is finite.
    fn vertex(&mut self, position: DVec3);
    /// Takes the source vertices of the next face, of which there are at least three.
    fn face(&mut self, vertices: &[Index]);
}

/// A piece of a file.
#[derive(Clone, Copy, Debug)]
pub struct Piece<'a> {
    /// Bytes that follow those that were taken before.
    pub bytes: &'a [u8],
    /// Whether the file ends with them.
    pub is_last: bool,
}

/// Positions of one source vertex before and after, model units.
pub type Change = [DVec3; 2];
