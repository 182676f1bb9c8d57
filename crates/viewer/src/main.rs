//! `planish-viewer`: draws a mesh.

mod args;
mod headless;
mod terminal;
mod timings;

use clap::Parser;
use std::io::Write as _;
use std::process::ExitCode;

fn main() -> ExitCode {
    match headless::run(&args::Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // If nobody listens, the exit status still tells.
            let _ = writeln!(std::io::stderr(), "planish-viewer: {failure}");
            ExitCode::from(failure.status())
        }
    }
}
