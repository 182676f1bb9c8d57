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
use planish_files::{failure, input, method_list, output, terminal};
use planish_geometry::bake::BakeSettings;
use planish_geometry::denoise::Denoiser;
use planish_geometry::mesh::synthetic_noise::{SyntheticKind, SyntheticNoise};
use std::ffi::OsString;
use std::process::ExitCode;

/// Runs one command line, whose first argument is the name of the program. The exit code is 0 if the command succeeded, 1 if
/// something failed that is not the user's doing, and 2 if input or usage is wrong.
pub fn run(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    ExitCode::from(status(args))
}

/// Runs one command line as [`run`] does, and returns its exit code as a number.
pub fn status(args: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(e) => {
            let code = u8::try_from(e.exit_code()).unwrap_or(2);
            if e.use_stderr() {
                let _ = e.print();
                return code;
            }
            // Help and version go to standard output and are no error, but for a full disk.
            return match e.print() {
                Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
                    let reason = format!("standard output cannot be written: {}", input::plain(&e));
                    terminal::status(Err(Failure::Internal(reason)))
                }
                _ => code,
            };
        }
    };
    terminal::watch_memory();
    let console = Console::new(&cli.output);
    let result = terminal::with_threads(|| dispatch(cli.command, &console));
    console.finish();
    terminal::status(result)
}

/// Lists all methods and their parameters, as `planish methods --json` prints them.
pub fn methods() -> serde_json::Value {
    method_list::json(&Denoiser::every())
}

/// Reads the options of `planish bake`, such as `--size=1024`, as settings of a bake by the default method.
pub fn bake_settings(options: impl IntoIterator<Item = String>) -> Result<BakeSettings, Failure> {
    match parsed("bake", options)? {
        Command::Bake(args) => commands::bake::settings(&args.map, args.welding.weld),
        _ => Ok(BakeSettings::default()),
    }
}

/// Reads the options of `planish noise`, such as `--sigma=0.2`, as settings of the noise.
pub fn synthetic_noise(options: impl IntoIterator<Item = String>) -> Result<SyntheticNoise, Failure> {
    match parsed("noise", options)? {
        Command::Noise(args) => args.noise(),
        _ => Ok(SyntheticNoise::of_kind(SyntheticKind::default(), 1)),
    }
}

/// Parses options of a command whose mesh and output are not files.
fn parsed(command: &str, options: impl IntoIterator<Item = String>) -> Result<Command, Failure> {
    let fixed = ["planish", command, "-o=mesh", "mesh"].map(str::to_owned);
    let cli = Cli::try_parse_from(fixed.into_iter().chain(options)).map_err(|e| {
        let text = e.to_string();
        // The first line says what is wrong; others show the usage of the program.
        let reason = text.lines().next().unwrap_or_default();
        Failure::Input(reason.strip_prefix("error: ").unwrap_or(reason).to_owned())
    })?;
    Ok(cli.command)
}

/// Calls the function of a command.
fn dispatch(command: Command, console: &Console) -> Result<(), Failure> {
    match command {
        Command::Bake(args) => commands::bake::run(&args, console),
        Command::Apply(args) => commands::apply::run(&args, console),
        Command::Check(args) => commands::check::run(&args, console),
        Command::Denoise(args) => commands::denoise::run(&args, console),
        Command::Batch(args) => commands::batch::run(&args, console),
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
