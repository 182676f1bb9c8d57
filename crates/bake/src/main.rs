//! The program `planish`.

use std::process::ExitCode;

fn main() -> ExitCode {
    planish::run(std::env::args_os())
}
