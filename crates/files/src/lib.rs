//! What the command line and the window share about files: reading, with errors that name file and line; writing, whole
//! or not at all; and the bake from a mesh on disk to files on disk, so that both write the same bytes.

pub mod bake;
pub mod failure;
pub mod info;
pub mod input;
pub mod method;
pub mod output;
pub mod words;
