//! Meshes that are larger than memory: cut into tiles, denoised tile by tile, and written back into their file.
//!
//! A working folder holds all that lies between these steps, so that each of them may be done by another process or on another
//! machine that sees the folder, and again if it was interrupted:
//!
//! 1. [`spread`] reads the file once, piece by piece, and gives each vertex to one tile. A tile has the faces at its vertices.
//! 2. [`measure`] adds up lengths that a method takes from the whole mesh, in the order in which it would add them there.
//! 3. [`denoise`] denoises a [`Part`]: a tile and a halo of so many rings around it.
//! 4. [`merge`] puts the tiles together.
//! 5. [`write()`] writes the file again, piece by piece, with other positions.
//!
//! The vertices and faces of a part keep their order, so that sums over neighbours have the same order as in the whole mesh. With a halo as
//! wide as a method [reaches](reach::rings), its results in the tile are those of the whole mesh, bit for bit.

mod anchor;
mod denoise;
mod measure;
mod merge;
mod part;
mod plan;
pub mod reach;
mod records;
mod spread;
mod write;

pub use denoise::{Job, TileReport, denoise};
pub use measure::{Lengths, lengths, measure};
pub use merge::{Borders, done, merge};
pub use part::Part;
pub use plan::{Plan, Split};
pub use spread::{Cut, spread};
pub use write::{check_output, write};

/// Number of bytes that are read from a file at a time.
const PIECE: usize = 16 << 20;

#[cfg(test)]
mod tests;
