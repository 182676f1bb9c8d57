//! The window of planish, and what it does with files. [`planish_render`] draws.
//!
//! [`app`] holds what is open, chosen and going on, without GPU or widgets; [`window`] draws it.

pub use planish_render::gpu::{painter, renderer};
pub use planish_render::settings::{camera, ground, lights, shadow};
pub use planish_render::{bounds, colour, gpu, input, mesh, relief, scene, settings, software, texture};

pub mod app;
pub mod environment;
pub mod errors;
mod image_file;
pub mod open;
pub mod window;
