//! `planish-viewer`: draws a mesh.

mod args;
mod headless;
mod timings;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    planish_files::terminal::conclude(headless::run(&args::Args::parse()))
}
