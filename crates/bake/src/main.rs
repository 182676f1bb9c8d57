//! The program `planish`.

use planish_memory::WatchedAllocator;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: WatchedAllocator = WatchedAllocator;

fn main() -> ExitCode {
    planish::run(std::env::args_os())
}
