//! The renderer on a GPU, or on a driver that computes like one. Without any these tests fail, and say what to install.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod agreement;
mod displacement;
mod golden;
mod loss;
mod support;
