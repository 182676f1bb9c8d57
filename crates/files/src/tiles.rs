//! Meshes that are larger than memory: cut into tiles, denoised tile by tile, and written back into their file.
//!
//! A working folder holds all that lies between these steps, so that each of them may be done by another process or on another
//! machine that sees the folder, and again if it was interrupted:
//!
//! 1. [`spread`] reads the file once, piece by piece, and gives each vertex to one tile. A tile has the faces at its vertices.
//! 2. [`measure`] adds up lengths that a method takes from the whole mesh, in the order in which it would add them there.
//! 3. [`denoise`] denoises a [`Part`]: a tile and a halo of so many rings around it.
//!    Where the method measures the whole mesh again and again, all tiles take its rounds together before ([`round()`], [`end_round`]).
//! 4. [`merge`] puts the tiles together.
//! 5. [`write()`] writes the file again, piece by piece, with other positions.
//!
//! Or, for a map that takes the noise off, after [`merge`]:
//!
//! 5. [`heights`] finds what the map holds for the vertices of a tile.
//! 6. [`page`] writes the page of a tile.
//! 7. [`bundle`] writes pages, carrier and manifest to a folder. Where the method [looks farther](reach) than a halo, [`write()`] and
//!    [`take_positions`] come first, and the denoised mesh becomes a file of the bundle.
//!
//! The vertices and faces of a part keep their order, so that sums over neighbours have the same order as in the whole mesh. With a halo as
//! wide as a method [reaches](reach::rings), its results in the tile are those of the whole mesh, bit for bit.
//!
//! ```
//! use planish_files::tiles::{self, Cut, Job, reach};
//! use planish_geometry::denoise::{Denoiser, Denoising};
//! use planish_geometry::mesh::{shapes, weld::Welding};
//! use planish_geometry::progress::Silent;
//!
//! let folder = tempfile::tempdir()?;
//! let (mesh, denoised) = (folder.path().join("mesh.obj"), folder.path().join("denoised.obj"));
//! let surface = shapes::dented_sphere(4);
//! # let vertices = surface.positions().iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
//! # let faces = surface.topology().faces().iter().map(|f| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1));
//! # std::fs::write(&mesh, vertices.chain(faces).collect::<String>())?;
//! let cut = Cut { key: "first try".to_owned(), tiles: 3, welding: Welding::Exact };
//! tiles::spread(&mesh, folder.path(), &cut, &Silent)?;
//!
//! let method: Denoising = Denoiser::named("laplacian").unwrap().into();
//! let halo = reach::halo(&method, None);
//! let job = Job { key: "laplacian".to_owned(), method: method.clone(), halo, lengths: None, weights: None };
//! for tile in 0..cut.tiles {
//!     tiles::denoise(folder.path(), tile, &job, &Silent)?;
//! }
//! tiles::merge(folder.path(), &job, &Silent)?;
//! tiles::write(&mesh, &denoised, folder.path(), &Silent)?;
//!
//! // They are the bits of the whole mesh.
//! let whole = method.denoiser.denoised(&surface, &Silent)?;
//! # use planish_files::input::{self, Trust};
//! let written = input::source(&denoised, Trust::Folder)?;
//! assert_eq!(written.data().positions(), whole);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod anchor;
mod bundle;
mod denoise;
mod heights;
mod job;
mod measure;
mod merge;
mod page;
mod part;
mod plan;
pub mod reach;
mod records;
mod results;
mod rounds;
mod spread;
mod write;

pub use bundle::{TilesMethod, bundle, take_positions};
pub use denoise::{TileReport, denoise};
pub use heights::{MapJob, heights};
pub use job::Job;
pub use measure::{Lengths, lengths, measure};
pub use merge::{Borders, done, merge};
pub use page::page;
pub use part::Part;
pub use plan::{Plan, Split};
pub use rounds::{AfterRound, end_round, last_round, round};
pub use spread::{Cut, spread};
pub use write::{check_folder, check_output, write};

/// Number of bytes that are read from a file at a time.
const PIECE: usize = 16 << 20;

#[cfg(test)]
mod tests;
