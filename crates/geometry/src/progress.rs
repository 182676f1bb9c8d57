//! How long work tells its caller where it is, and how the caller stops it.

use std::sync::atomic::{AtomicUsize, Ordering};

/// The caller asked for the work to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("interrupted")]
pub struct Cancelled;

/// Receives progress; may be called from any thread.
pub trait Progress: Sync {
    /// A new stage begins. Names are short and in the reader's language: "smoothing", "rasterising".
    fn stage(&self, name: &'static str) {
        let _ = name;
    }
    /// Share of the stage that is done, 0..=1.
    fn done(&self, share: f64) {
        let _ = share;
    }
    /// Whether the work should stop.
    fn cancelled(&self) -> bool {
        false
    }
    /// [`Cancelled`] where the work should stop.
    fn check(&self) -> Result<(), Cancelled> {
        if self.cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// Tells nobody and never stops.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {}

/// Counts the parts of a stage that several threads work on.
pub(crate) struct Parts<'a> {
    progress: &'a dyn Progress,
    total: usize,
    finished: AtomicUsize,
}

impl<'a> Parts<'a> {
    pub(crate) fn new(progress: &'a dyn Progress, total: usize) -> Self {
        Self { progress, total, finished: AtomicUsize::new(0) }
    }
    /// Does one part, unless the work should stop.
    pub(crate) fn run<T>(&self, part: impl FnOnce() -> T) -> Result<T, Cancelled> {
        self.progress.check()?;
        let out = part();
        let finished = self.finished.fetch_add(1, Ordering::Relaxed) + 1;
        self.progress.done(finished as f64 / self.total as f64);
        Ok(out)
    }
}
