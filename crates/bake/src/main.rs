//! The `planish` binary.

use std::process::ExitCode;

fn main() -> ExitCode {
    planish_bake::run(std::env::args_os())
}
