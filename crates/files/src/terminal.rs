//! The terminal that a program runs in: a progress bar, warnings and errors on standard error, results on standard output,
//! and Ctrl-C.

use crate::failure::Failure;
use indicatif::{ProgressBar, ProgressStyle};
use planish_geometry::progress::Progress;
use std::io::{IsTerminal as _, Write as _};
use std::process::ExitCode;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

/// True after Ctrl-C. It is global because a process has one handler for Ctrl-C.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Whether a progress bar is shown. If standard error is not a terminal, there is none in either case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bar {
    /// Progress is shown.
    Shown,
    /// Progress is not shown.
    Hidden,
}

/// Progress on standard error, which Ctrl-C can cancel. The bar disappears when this value is dropped.
#[derive(Debug)]
pub struct Terminal {
    bar: ProgressBar,
}

impl Terminal {
    /// Takes over Ctrl-C: the first one cancels the work that reports its progress here, the second one ends the program.
    pub fn new(bar: Bar) -> Self {
        take_over_interrupts();
        let is_seen = bar == Bar::Shown && std::io::stderr().is_terminal();
        let bar = if is_seen { ProgressBar::new(1000) } else { ProgressBar::hidden() };
        if let Ok(style) = ProgressStyle::with_template("{msg:16} [{bar:40}] {percent:>3} % {elapsed}") {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar }
    }

    /// Prints a warning: the work succeeded, but the user should know this.
    pub fn warn(&self, text: &str) {
        self.bar.suspend(|| say("warning", &text));
    }

    /// Removes the progress bar, so that results can be printed.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.clear();
    }
}

impl Progress for Terminal {
    fn stage(&self, name: &'static str) {
        self.bar.set_position(0);
        self.bar.set_message(name);
    }
    fn done(&self, share: f64) {
        self.bar.set_position((share * 1000.0) as u64);
    }
    fn cancelled(&self) -> bool {
        INTERRUPTED.load(Ordering::Relaxed)
    }
}

/// Installs the handler for Ctrl-C, once for each process.
fn take_over_interrupts() {
    static HANDLER: Once = Once::new();
    HANDLER.call_once(|| {
        let interrupt = || {
            if INTERRUPTED.swap(true, Ordering::Relaxed) {
                // The second Ctrl-C ends the program at once. Nothing is half written, because files appear by renaming.
                std::process::exit(1);
            }
        };
        // Without a handler Ctrl-C ends the program at once, which is fine as well.
        let _ = ctrlc::set_handler(interrupt);
    });
}

/// Writes to standard output. A closed pipe is not an error.
pub fn print(bytes: &[u8]) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(bytes).and_then(|()| out.flush());
}

/// Ends a program: says on standard error why it failed, and returns the exit code.
pub fn conclude(outcome: Result<(), Failure>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            say("error", &failure);
            failure.exit_code()
        }
    }
}

/// Writes a line to standard error. Errors are ignored: the exit code still tells what happened.
fn say(kind: &str, text: &dyn std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "{kind}: {text}");
}
