//! The terminal that a program runs in: a progress bar, warnings and errors on standard error, results on standard output,
//! and Ctrl-C.
//!
//! ```
//! use planish_files::failure::Failure;
//! use planish_files::terminal::{self, Bar, Terminal};
//! use planish_geometry::denoise::Denoiser;
//! use planish_geometry::mesh::shapes;
//!
//! // Ctrl-C cancels what reports its progress to the terminal.
//! let terminal = Terminal::new(Bar::Shown);
//! let method = Denoiser::named("laplacian").unwrap();
//! let denoised = terminal::with_threads(|| method.denoised(&shapes::gridded_box(4), &terminal));
//! terminal.clear();
//! let outcome = match denoised {
//!     Ok(positions) => terminal::print_text(&format!("{} vertices\n", positions.len())),
//!     Err(cancelled) => Err(Failure::from(cancelled)),
//! };
//! // The exit code of the program.
//! assert_eq!(terminal::status(outcome), 0);
//! ```

use crate::cleanup;
use crate::failure::Failure;
use crate::text::{escaped, plain, shown};
use indicatif::{ProgressBar, ProgressStyle};
use planish_geometry::progress::Progress;
use std::io::{IsTerminal as _, Write as _};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, Once};
use std::time::Duration;

/// True after Ctrl-C. It is global because a process has one handler for Ctrl-C.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// True once a report is being printed, so that the work is about to end by itself.
static REPORTING: AtomicBool = AtomicBool::new(false);

/// Time that work has after Ctrl-C to hear of it and to end.
const PATIENCE: Duration = Duration::from_millis(400);
/// Further time for a report that is being printed.
const PATIENCE_FOR_REPORT: Duration = Duration::from_secs(2);

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

    /// Does something that prints, without the progress bar.
    pub fn suspended<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
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

/// File that is being worked on, and the stage of the work, for a program that runs out of memory.
static WORK: Mutex<(String, &'static str)> = Mutex::new((String::new(), "reading"));

/// Notes the file that is being worked on.
pub(crate) fn work_on(path: &Path) {
    if let Ok(mut work) = WORK.lock() {
        work.0 = shown(path);
    }
}

/// Bytes that are kept for the last words of a program that has run out of memory.
static RESERVE: Mutex<Vec<u8>> = Mutex::new(Vec::new());

/// Ends the program in order when memory is exhausted: one line that names file and stage, exit code 1, and nothing left behind.
/// Works in programs that have [`planish_memory::WatchedAllocator`].
pub fn watch_memory() {
    if let Ok(mut reserve) = RESERVE.lock() {
        reserve.resize(1 << 18, 1);
    }
    planish_memory::on_exhaustion(|bytes| {
        // Whoever holds one of these is in the middle of an allocation, and cannot be waited for.
        if let Ok(mut reserve) = RESERVE.try_lock() {
            *reserve = Vec::new();
        }
        let (file, stage) = WORK.try_lock().map(|work| work.clone()).unwrap_or_default();
        let place = if file.is_empty() { String::new() } else { format!("{file}: ") };
        let during = if stage.is_empty() { String::new() } else { format!(" while {stage}") };
        let missed = if bytes > 0 { format!(" ({bytes} bytes more were needed)") } else { String::new() };
        let text = format!("{place}out of memory{during}{missed}; nothing was written");
        cleanup::give_up_now(|| {
            say("error", &text);
            std::process::exit(1);
        });
    });
    watch_stacks();
}

/// Treats a thread that gets no memory for its stack of signals as memory that is exhausted. The standard library asks the system
/// for that stack itself, before a thread runs anything of ours, and panics where nobody can catch it.
fn watch_stacks() {
    let of_panics = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if panic.payload_as_str().is_some_and(|text| text.contains("alternative stack")) {
            planish_memory::exhausted(0);
        }
        of_panics(panic);
    }));
}

/// Largest number of threads. More would cost memory and gain nothing.
const MOST_THREADS: usize = 256;

/// Does work with as many threads as the processor has, or as RAYON_NUM_THREADS says, or as the system allows: a limit on threads
/// or memory makes the work slower, and results are the same.
pub fn with_threads<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    with_part_of_threads(1, work)
}

/// Number of threads that [`with_threads`] tries to have.
pub fn thread_count() -> usize {
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|count| count.parse().ok()).filter(|count| *count > 0);
    let available = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    asked.unwrap_or_else(available).min(MOST_THREADS)
}

/// Does work as [`with_threads`] does, beside other work of the kind: with an equal part of the threads, at least one.
pub fn with_part_of_threads<T: Send>(parts: usize, work: impl FnOnce() -> T + Send) -> T {
    let mut count = (thread_count() / parts.max(1)).max(1);
    loop {
        match rayon::ThreadPoolBuilder::new().num_threads(count).build() {
            Ok(pool) => return pool.install(work),
            Err(_) if count > 1 => count /= 2,
            Err(_) => break,
        }
    }
    // Not even one: this thread does everything.
    match rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

impl Progress for Terminal {
    fn stage(&self, name: &'static str) {
        if let Ok(mut work) = WORK.lock() {
            work.1 = name;
        }
        self.bar.set_position(0);
        self.bar.set_message(name);
    }
    fn done(&self, share: f64) {
        self.bar.set_position((share * 1000.0) as u64);
    }
    fn cancelled(&self) -> bool {
        is_interrupted()
    }
}

/// Installs the handler for Ctrl-C, once for each process.
fn take_over_interrupts() {
    static HANDLER: Once = Once::new();
    HANDLER.call_once(|| {
        let interrupt = || {
            if INTERRUPTED.swap(true, Ordering::Relaxed) {
                // The second Ctrl-C ends the program at once, but for files that are being renamed.
                cleanup::give_up(|| std::process::exit(1));
            }
            // Some work cannot ask, such as reading from a pipe; it does not have to.
            std::thread::spawn(|| {
                std::thread::sleep(PATIENCE);
                if cleanup::has_committed() || REPORTING.load(Ordering::Relaxed) {
                    // Only the report is missing.
                    std::thread::sleep(PATIENCE_FOR_REPORT);
                    std::process::exit(1);
                }
                cleanup::give_up(|| {
                    if !cleanup::has_committed() {
                        say("error", &Failure::Interrupted);
                    }
                    std::process::exit(1);
                });
            });
        };
        // Without a handler Ctrl-C ends the program at once, which is fine as well.
        let _ = ctrlc::set_handler(interrupt);
    });
}

/// Returns a failure if Ctrl-C was pressed, for work that has no [`Progress`].
pub(crate) fn check_interrupt() -> Result<(), Failure> {
    if is_interrupted() { Err(Failure::Interrupted) } else { Ok(()) }
}

fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// Writes to standard output. A closed pipe is not an error: the reader has seen enough.
pub fn print(bytes: &[u8]) -> Result<(), Failure> {
    REPORTING.store(true, Ordering::Relaxed);
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Internal(format!("standard output cannot be written: {}", plain(&e))))
        }
        _ => Ok(()),
    }
}

/// Writes text for people to standard output; control characters in it are escaped, but for line ends and tabs.
pub fn print_text(text: &str) -> Result<(), Failure> {
    print(escaped(text, &['\n', '\t']).as_bytes())
}

/// Writes text for people to standard error, because standard output has a result.
pub fn print_text_aside(text: &str) {
    let _ = std::io::stderr().write_all(escaped(text, &['\n', '\t']).as_bytes());
}

/// Ends a program: says on standard error why it failed, and returns the exit code.
pub fn conclude(outcome: Result<(), Failure>) -> ExitCode {
    ExitCode::from(status(outcome))
}

/// Says on standard error why a program failed, and returns the exit code as a number.
pub fn status(outcome: Result<(), Failure>) -> u8 {
    match outcome {
        Ok(()) => 0,
        Err(failure) => {
            say("error", &failure);
            failure.status()
        }
    }
}

/// Writes a line to standard error, and it is one line whatever names are in it. Errors are ignored: the exit code still tells
/// what happened.
fn say(kind: &str, text: &dyn std::fmt::Display) {
    let line = format!("{kind}: {}\n", escaped(&text.to_string(), &[]));
    let _ = std::io::stderr().write_all(line.as_bytes());
}
