//! The command line of planish. It reads and writes files; all arithmetic is in `planish-geometry`.

mod args;
mod commands;
mod console;
mod csv;
mod heat_map;
mod method_table;

use args::{Cli, Command};
use clap::{CommandFactory as _, Parser as _};
use console::Console;
use planish_files::failure::Failure;
use planish_files::{failure, input, output, terminal};
use std::ffi::OsString;
use std::process::ExitCode;

/// Runs one command line, whose first argument is the name of the program. The exit code is 0 if the command succeeded, 1 if
/// something failed that is not the user's doing, and 2 if input or usage is wrong.
pub fn run(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(e) => {
            let code = ExitCode::from(u8::try_from(e.exit_code()).unwrap_or(2));
            if e.use_stderr() {
                let _ = e.print();
                return code;
            }
            // Help and version go to standard output and are no error, but for a full disk.
            return match e.print() {
                Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
                    let reason = format!("standard output cannot be written: {}", input::plain(&e));
                    terminal::conclude(Err(Failure::Internal(reason)))
                }
                _ => code,
            };
        }
    };
    terminal::watch_memory();
    let console = Console::new(&cli.output);
    let result = terminal::with_threads(|| dispatch(cli.command, &console));
    console.finish();
    terminal::conclude(result)
}

/// Calls the function of a command.
fn dispatch(command: Command, console: &Console) -> Result<(), Failure> {
    match command {
        Command::Bake(args) => commands::bake::run(&args, console),
        Command::Apply(args) => commands::apply::run(&args, console),
        Command::Check(args) => commands::check::run(&args, console),
        Command::Denoise(args) => commands::denoise::run(&args, console),
        Command::Compare(args) => commands::compare::run(&args, console),
        Command::BenchQuality(args) => commands::bench_quality::run(&args, console),
        Command::Noise(args) => commands::noise::run(&args, console),
        Command::Info(args) => commands::info::run(&args, console),
        Command::Methods(args) => commands::methods::run(&args, console),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "planish", &mut script);
            console.print_bytes(&script)
        }
    }
}
