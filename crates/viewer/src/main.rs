//! `planish-viewer`: draws a mesh.

mod args;
mod run;
mod timings;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    planish_files::terminal::conclude(run::run(&args::Args::parse()))
}
