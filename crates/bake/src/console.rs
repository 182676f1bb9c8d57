//! What the user sees: results on stdout, progress and complaints on stderr.

use crate::args::OutputArgs;
use crate::failure::Failure;
use indicatif::{ProgressBar, ProgressStyle};
use planish_geometry::progress::Progress;
use serde::Serialize;
use std::io::{IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, Once};
use std::time::Instant;

/// Set by Ctrl-C.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Prints results and shows progress.
pub(crate) struct Console {
    json: bool,
    quiet: bool,
    verbose: bool,
    bar: ProgressBar,
    stages: Mutex<Vec<(&'static str, Instant)>>,
    start: Instant,
}

impl Console {
    pub(crate) fn new(args: &OutputArgs) -> Self {
        static HANDLER: Once = Once::new();
        HANDLER.call_once(|| {
            let interrupt = || {
                if INTERRUPTED.swap(true, Ordering::Relaxed) {
                    // The second time somebody means it. Nothing is half written: files appear by renaming.
                    std::process::exit(1);
                }
            };
            // Without a handler Ctrl-C ends the program at once, which is fine as well.
            let _ = ctrlc::set_handler(interrupt);
        });
        let shown = !args.quiet && !args.json && std::io::stderr().is_terminal();
        let bar = if shown { ProgressBar::new(1000) } else { ProgressBar::hidden() };
        if let Ok(style) = ProgressStyle::with_template("{msg:16} [{bar:40}] {percent:>3} % {elapsed}") {
            bar.set_style(style.progress_chars("=> "));
        }
        let start = Instant::now();
        Self { json: args.json, quiet: args.quiet, verbose: args.verbose, bar, stages: Mutex::default(), start }
    }

    /// Whether stdout is for one value of JSON.
    pub(crate) fn is_json(&self) -> bool {
        self.json
    }

    /// A result: `text` for people, or `value` as JSON.
    pub(crate) fn report<T: Serialize>(&self, value: &T, text: impl FnOnce() -> String) {
        self.bar.finish_and_clear();
        if self.json {
            let mut value = serde_json::to_value(value).unwrap_or_default();
            if self.verbose
                && let Some(object) = value.as_object_mut()
            {
                object.insert(
                    "seconds".to_owned(),
                    self.seconds().into_iter().map(|(name, s)| (name.to_owned(), serde_json::Value::from(s))).collect(),
                );
            }
            let json = serde_json::to_string_pretty(&value).unwrap_or_default();
            self.print_bytes(format!("{json}\n").as_bytes());
        } else if !self.quiet {
            self.print_bytes(text().as_bytes());
            if self.verbose {
                self.print_bytes(self.stage_table().as_bytes());
            }
        }
    }

    /// Something the user should know although all went well.
    pub(crate) fn warn(&self, text: &str) {
        if !self.quiet {
            self.bar.suspend(|| {
                let _ = writeln!(std::io::stderr(), "warning: {text}");
            });
        }
    }

    /// Writes to stdout. A reader that went away is not an error.
    pub(crate) fn print_bytes(&self, bytes: &[u8]) {
        let mut out = std::io::stdout().lock();
        let _ = out.write_all(bytes).and_then(|()| out.flush());
    }

    /// Takes the progress bar away.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Seconds of each stage so far, summed by name, in the order of first appearance; last the total.
    fn seconds(&self) -> Vec<(&'static str, f64)> {
        let now = Instant::now();
        let stages = self.stages.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mut sums: Vec<(&'static str, f64)> = Vec::new();
        for (i, (name, start)) in stages.iter().enumerate() {
            let seconds = stages.get(i + 1).map_or(now, |next| next.1).duration_since(*start).as_secs_f64();
            match sums.iter_mut().find(|sum| sum.0 == *name) {
                Some(sum) => sum.1 += seconds,
                None => sums.push((name, seconds)),
            }
        }
        sums.push(("total", now.duration_since(self.start).as_secs_f64()));
        sums
    }

    fn stage_table(&self) -> String {
        let seconds = self.seconds();
        let total = seconds.last().map_or(0.0, |(_, s)| *s);
        let row = |(name, s): &(&str, f64)| format!("  {name:16} {s:8.3} s {:5.1} %\n", 100.0 * s / total);
        seconds.iter().map(row).collect()
    }
}

impl Progress for Console {
    fn stage(&self, name: &'static str) {
        self.stages.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push((name, Instant::now()));
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

/// Tells why a command failed.
pub(crate) fn complain(failure: &Failure) {
    let _ = writeln!(std::io::stderr(), "error: {failure}");
}
