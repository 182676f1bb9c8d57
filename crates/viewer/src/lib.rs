//! The window of planish, and what it does with files. [`planish_render`] draws.
//!
//! [`app`] holds what is open, chosen and going on, without GPU or widgets; [`window`] draws it.

pub mod app;
pub mod environment;
pub mod errors;
mod image_file;
pub mod open;
pub mod window;
