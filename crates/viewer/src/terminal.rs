//! Where the work is, on a terminal.

use indicatif::{ProgressBar, ProgressStyle};
use planish_geometry::progress::Progress;

/// A line on standard error; hidden where that is no terminal, and gone at the end. Ctrl-C ends the program at any time:
/// files appear by renaming, so that none is left half written.
pub(crate) struct Terminal(ProgressBar);

impl Terminal {
    pub(crate) fn new() -> Self {
        let bar = ProgressBar::new(100);
        if let Ok(style) = ProgressStyle::with_template("{msg} {percent} %") {
            bar.set_style(style);
        }
        Self(bar)
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

impl Progress for Terminal {
    fn stage(&self, name: &'static str) {
        self.0.set_message(name);
        self.0.set_position(0);
    }

    fn done(&self, share: f64) {
        self.0.set_position((100.0 * share.clamp(0.0, 1.0)) as u64);
    }
}
