//! Long work beside Python: other threads of Python run meanwhile, progress is told, and Ctrl-C stops it.

use crate::errors::raised;
use planish_files::failure::Failure;
use planish_files::terminal;
use planish_geometry::progress::Progress;
use pyo3::prelude::*;
use pyo3::types::PyBool;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Time between two looks at Ctrl-C and two calls of the callable that is told of progress.
const INTERVAL: Duration = Duration::from_millis(30);

/// Progress of the work, which the thread of the caller reads.
#[derive(Default)]
struct Watch {
    stage: Mutex<&'static str>,
    /// Bits of the fraction that is done.
    fraction: AtomicU64,
    is_stopped: AtomicBool,
}

impl Watch {
    fn stage_now(&self) -> &'static str {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }
    fn fraction_now(&self) -> f64 {
        f64::from_bits(self.fraction.load(Ordering::Relaxed))
    }
}

impl Progress for Watch {
    fn stage(&self, name: &'static str) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = name;
        self.done(0.0);
    }
    fn done(&self, fraction: f64) {
        self.fraction.store(fraction.to_bits(), Ordering::Relaxed);
    }
    fn cancelled(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }
}

/// Does work in a thread of its own with a pool of its own, so that a process that was forked can do it as well. The calling thread
/// waits detached from Python, and looks at signals and calls `progress` between.
pub(crate) fn run<T: Send>(
    py: Python,
    progress: Option<&Bound<PyAny>>,
    work: impl FnOnce(&dyn Progress) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    let watch = Watch::default();
    let (result, stopped) = std::thread::scope(|scope| {
        let (sender, mut receiver) = channel();
        let watch = &watch;
        scope.spawn(move || {
            let done = catch_unwind(AssertUnwindSafe(|| terminal::with_threads(|| work(watch))));
            // The receiver waits for this.
            let _ = sender.send(done);
        });
        let mut stopped = None;
        loop {
            let (received, back) = py.detach(move || (receiver.recv_timeout(INTERVAL), receiver));
            receiver = back;
            match received {
                Ok(result) => return (Some(result), stopped),
                Err(RecvTimeoutError::Disconnected) => return (None, stopped),
                Err(RecvTimeoutError::Timeout) if stopped.is_some() => {}
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(error) = py.check_signals().and_then(|()| tell(progress, watch)) {
                        watch.is_stopped.store(true, Ordering::Relaxed);
                        stopped = Some(error);
                    }
                }
            }
        }
    });
    if let Some(error) = stopped {
        return Err(error);
    }
    match result {
        Some(Ok(result)) => result.map_err(raised),
        Some(Err(panic)) => resume_unwind(panic),
        None => Err(raised(Failure::Internal("the thread that worked is gone".to_owned()))),
    }
}

/// Tells the callable of the stage and of the fraction of it that is done. Fails if it returns False.
fn tell(progress: Option<&Bound<PyAny>>, watch: &Watch) -> PyResult<()> {
    let Some(progress) = progress else { return Ok(()) };
    let answer = progress.call1((watch.stage_now(), watch.fraction_now()))?;
    let is_false = answer.cast::<PyBool>().is_ok_and(|answer| !answer.is_true());
    if is_false { Err(raised(Failure::Interrupted)) } else { Ok(()) }
}
