//! `planish-viewer`: draws a mesh.

mod args;
mod drawer;
mod make_report;
mod run;
mod timings;

use clap::Parser;
use planish_files::terminal;
use planish_memory::WatchedAllocator;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: WatchedAllocator = WatchedAllocator;

fn main() -> ExitCode {
    let args = args::Args::parse();
    terminal::watch_memory();
    terminal::conclude(run::run(&args))
}
