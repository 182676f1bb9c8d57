//! Files and the terminal, for the command line and the window of planish. The crate reads files, with errors that name file
//! and line; writes files whole or not at all; bakes a mesh on disk into files on disk, so that both programs write the same
//! bytes; and shows progress, handles Ctrl-C and reports failures on a terminal.
//!
//! ```
//! use planish_files::input::{self, Trust};
//! use planish_files::mesh_output;
//! use planish_files::output::Output;
//! use planish_geometry::denoise::Denoiser;
//! use planish_geometry::mesh::weld::Welding;
//! use planish_geometry::progress::Silent;
//!
//! # let folder = tempfile::tempdir()?;
//! # let [input, output] = ["tent.obj", "denoised.ply"].map(|name| folder.path().join(name));
//! # std::fs::write(&input, "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n")?;
//! // A tent, whose only vertex inside sinks: from an OBJ file to a PLY file.
//! let model = input::model(&input, Welding::Exact, Trust::Folder, &Silent)?;
//! let denoised = Denoiser::named("laplacian").unwrap().denoised(model.surface(), &Silent)?;
//! let mesh = mesh_output::write(&output, model.source(), &model.weld().spread(&denoised), None)?;
//! Output::open(&output, &[&input])?.write(&mesh.bytes)?;
//!
//! let written = input::model(&output, Welding::Exact, Trust::Folder, &Silent)?;
//! let top = written.surface().positions().iter().map(|p| p.z).fold(0.0, f64::max);
//! assert!(top < 0.5, "{top}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod bake_files;
pub mod bake_report;
#[cfg(not(target_family = "wasm"))]
mod cleanup;
pub mod compression;
pub mod denoise_mesh;
pub mod disk;
pub mod failure;
pub mod info;
pub mod input;
pub mod map_files;
pub mod mask;
pub mod mesh_output;
pub mod method;
pub mod method_list;
mod named_file;
pub mod named_path;
#[cfg(not(target_family = "wasm"))]
pub mod output;
#[cfg(not(target_family = "wasm"))]
pub mod terminal;
pub mod text;
#[cfg(not(target_family = "wasm"))]
pub mod tiles;
