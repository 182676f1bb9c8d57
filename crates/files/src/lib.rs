//! Files and the terminal, for the command line and the window of planish. The crate reads files, with errors that name file
//! and line; writes files whole or not at all; bakes a mesh on disk into files on disk, so that both programs write the same
//! bytes; and shows progress, handles Ctrl-C and reports failures on a terminal.

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
pub mod named_path;
#[cfg(not(target_family = "wasm"))]
pub mod output;
#[cfg(not(target_family = "wasm"))]
pub mod terminal;
pub mod text;
#[cfg(not(target_family = "wasm"))]
pub mod tiles;
