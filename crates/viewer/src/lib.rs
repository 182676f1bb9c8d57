//! The window of planish, and what it does with files. [`planish_render`] draws.
//!
//! [`app`] holds what is open, chosen and going on, without GPU or widgets; [`window`] draws it.

pub mod app;
pub mod environment;
mod image_file;
pub mod open;
pub mod report;
pub mod vertex_error;
pub mod volume;
pub mod window;
