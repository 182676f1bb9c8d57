//! Where the work is, on a terminal.

use planish_geometry::progress::Progress;
use std::io::{IsTerminal as _, Write as _};
use std::sync::Mutex;
use std::sync::PoisonError;

/// Rewrites one line of standard error; writes nothing where that is not a terminal. Ctrl-C ends the program at any time:
/// files appear by renaming, so that none is left half written.
pub(crate) struct Terminal {
    shown: Option<Mutex<(&'static str, u32)>>,
}

impl Terminal {
    pub(crate) fn new() -> Self {
        Self { shown: std::io::stderr().is_terminal().then(Mutex::default) }
    }

    fn show(&self, change: impl FnOnce(&mut (&'static str, u32))) {
        let Some(shown) = &self.shown else { return };
        let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
        let before = *shown;
        change(&mut shown);
        if *shown != before {
            let (stage, percent) = *shown;
            // If nobody looks, the work goes on all the same. The rest of the line is erased.
            let _ = write!(std::io::stderr(), "\r{stage} {percent} %\x1b[K");
        }
    }

    /// Takes the line away.
    pub(crate) fn clear(&self) {
        if self.shown.is_some() {
            let _ = write!(std::io::stderr(), "\r\x1b[K");
        }
    }
}

impl Progress for Terminal {
    fn stage(&self, name: &'static str) {
        self.show(|shown| *shown = (name, 0));
    }

    fn done(&self, share: f64) {
        self.show(|shown| shown.1 = (100.0 * share.clamp(0.0, 1.0)) as u32);
    }
}
