//! Output of the command line: results on stdout, progress and warnings on stderr.

use crate::args::OutputArgs;
use crate::failure::Failure;
use crate::output::Output;
use planish_files::terminal::{self, Bar, Terminal};
use planish_geometry::progress::Progress;
use serde::Serialize;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Prints results and shows progress.
pub(crate) struct Console {
    json: bool,
    quiet: bool,
    verbose: bool,
    terminal: Terminal,
    stages: Mutex<Vec<(&'static str, Instant)>>,
    start: Instant,
    /// True if standard output gets a result, and nothing else may go there.
    is_stdout_taken: AtomicBool,
}

impl Console {
    pub(crate) fn new(args: &OutputArgs) -> Self {
        let bar = if args.quiet || args.json { Bar::Hidden } else { Bar::Shown };
        let (terminal, start) = (Terminal::new(bar), Instant::now());
        let OutputArgs { json, quiet, verbose, .. } = *args;
        let is_stdout_taken = AtomicBool::new(false);
        Self { json, quiet, verbose, terminal, stages: Mutex::default(), start, is_stdout_taken }
    }

    /// Returns whether stdout is reserved for one JSON value.
    pub(crate) fn is_json(&self) -> bool {
        self.json
    }

    /// Keeps standard output for a result, if one of the outputs is standard output. Text for people goes to standard error then.
    /// Fails if JSON goes to standard output as well, or another output does.
    pub(crate) fn reserve_stdout<'a>(&self, outputs: impl IntoIterator<Item = &'a Output>) -> Result<(), Failure> {
        let count = outputs.into_iter().filter(|output| output.is_stdout()).count();
        if count > 1 {
            return Err(Failure::Input(
                "two outputs cannot both go to standard output; name a file for one".to_owned(),
            ));
        }
        if count == 1 && self.json {
            return Err(Failure::Input("a mesh and --json cannot both go to standard output; name a file".to_owned()));
        }
        self.is_stdout_taken.store(count == 1, Ordering::Relaxed);
        Ok(())
    }

    /// Prints a result: `text` for people, or `value` as JSON.
    pub(crate) fn report<T: Serialize>(&self, value: &T, text: impl FnOnce() -> String) -> Result<(), Failure> {
        self.terminal.clear();
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
            self.print_bytes(format!("{json}\n").as_bytes())?;
        } else if !self.quiet {
            let stages = if self.verbose { self.stage_table() } else { String::new() };
            let text = text() + &stages;
            if self.is_stdout_taken.load(Ordering::Relaxed) {
                terminal::print_text_aside(&text);
            } else {
                terminal::print_text(&text)?;
            }
        }
        Ok(())
    }

    /// Prints a warning: the work succeeded, but the user should know this.
    pub(crate) fn warn(&self, text: &str) {
        if !self.quiet {
            self.terminal.warn(text);
        }
    }

    /// Prints a line of a result while work goes on, unless nothing but errors is printed.
    pub(crate) fn print_line(&self, line: &str) -> Result<(), Failure> {
        if self.quiet { Ok(()) } else { self.terminal.suspended(|| terminal::print(line.as_bytes())) }
    }

    /// Prints text for people on standard error, unless nothing but errors is printed.
    pub(crate) fn aside(&self, text: &str) {
        self.terminal.clear();
        if !self.quiet {
            terminal::print_text_aside(text);
        }
    }

    /// Writes to stdout. A closed pipe is not an error.
    pub(crate) fn print_bytes(&self, bytes: &[u8]) -> Result<(), Failure> {
        terminal::print(bytes)
    }

    /// Removes the progress bar.
    pub(crate) fn finish(&self) {
        self.terminal.clear();
    }

    /// Returns the seconds of each stage so far, summed by name, in the order of first appearance, and last the total.
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

    /// Formats the seconds of the stages, one line each.
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
        self.terminal.stage(name);
    }
    fn done(&self, share: f64) {
        self.terminal.done(share);
    }
    fn cancelled(&self) -> bool {
        self.terminal.cancelled()
    }
}
