//! Environments as the renderer has them, and how they are read from files.

pub mod file;

pub use planish_render::environment::{Environment, MAX_RADIANCE, cube, equirect, scenes};
pub use planish_render::settings::environment::{Part, Surroundings};
