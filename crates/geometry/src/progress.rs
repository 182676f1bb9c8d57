//! Progress of long work, and its cancellation by the caller.
//!
//! ```
//! use planish_geometry::denoise::Denoiser;
//! use planish_geometry::mesh::shapes;
//! use planish_geometry::progress::{Cancelled, Progress};
//! use std::sync::atomic::{AtomicUsize, Ordering};
//!
//! /// Counts the reports and stops the work at the third.
//! #[derive(Default)]
//! struct Third(AtomicUsize);
//!
//! impl Progress for Third {
//!     fn done(&self, _fraction: f64) {
//!         self.0.fetch_add(1, Ordering::Relaxed);
//!     }
//!     fn cancelled(&self) -> bool {
//!         self.0.load(Ordering::Relaxed) >= 3
//!     }
//! }
//!
//! let result = Denoiser::named("sun").unwrap().deltas(&shapes::dented_sphere(3), &Third::default());
//! assert_eq!(result, Err(Cancelled));
//! ```

use std::sync::atomic::{AtomicUsize, Ordering};

/// The work was stopped because the caller asked for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("interrupted")]
pub struct Cancelled;

/// Receiver of progress, which may be called from any thread.
pub trait Progress: Sync {
    /// Reports that a stage begins. Its name is short and understood by users, such as "smoothing" or "rasterising".
    fn stage(&self, name: &'static str) {
        let _ = name;
    }
    /// Reports the fraction of the stage that is done, 0..=1.
    fn done(&self, fraction: f64) {
        let _ = fraction;
    }
    /// Returns true if the work should stop.
    fn cancelled(&self) -> bool {
        false
    }
    /// Returns [`Cancelled`] if the work should stop.
    fn check(&self) -> Result<(), Cancelled> {
        if self.cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// Progress that is reported to nobody, of work that is never stopped.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {}

/// Counter of the finished parts of a stage that several threads work on.
pub(crate) struct Parts<'a> {
    progress: &'a dyn Progress,
    total: usize,
    finished: AtomicUsize,
}

impl<'a> Parts<'a> {
    pub(crate) fn new(progress: &'a dyn Progress, total: usize) -> Self {
        Self { progress, total, finished: AtomicUsize::new(0) }
    }
    /// Does one part and reports it, unless the work should stop.
    pub(crate) fn run<T>(&self, part: impl FnOnce() -> T) -> Result<T, Cancelled> {
        self.progress.check()?;
        let out = part();
        let finished = self.finished.fetch_add(1, Ordering::Relaxed) + 1;
        self.progress.done(finished as f64 / self.total as f64);
        Ok(out)
    }
}
