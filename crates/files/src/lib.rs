//! What the command line and the window share about files: reading, with errors that name file and line; writing, whole
//! or not at all; the bake from a mesh on disk to files on disk, so that both write the same bytes; and how a program on
//! a terminal shows progress, is interrupted and fails.

pub mod bake_files;
pub mod failure;
pub mod info;
pub mod input;
pub mod map_files;
pub mod method;
pub mod output;
pub mod terminal;
pub mod text;
