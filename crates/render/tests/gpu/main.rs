//! The renderer on a graphics adapter; Debian's mesa-vulkan-drivers has one that needs no GPU.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod alike;
mod golden;
mod light;
mod loss;
mod positions;
mod support;
mod twin;
