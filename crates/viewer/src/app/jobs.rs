//! Work in the background: one thread a job, progress that can be looked at, and results that come in the right order.

use planish_files::failure::Failure;
use planish_geometry::progress::Progress;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Tells whoever looks at results that there is something to see; called from any thread.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// Shortest time between two wake-ups for progress.
const NEWS_EVERY: Duration = Duration::from_millis(50);

/// State that a job and its owner share.
pub struct Ticket {
    state: Mutex<State>,
    /// Progress of the stage, in thousandths.
    done: AtomicU32,
    cancelled: AtomicBool,
    wake: Wake,
}

struct State {
    stage: &'static str,
    last_news: Instant,
}

impl Ticket {
    fn new(wake: Wake) -> Self {
        let state = Mutex::new(State { stage: "", last_news: Instant::now() });
        Self { state, done: AtomicU32::new(0), cancelled: AtomicBool::new(false), wake }
    }

    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress for Ticket {
    fn stage(&self, name: &'static str) {
        let mut state = self.state();
        state.stage = name;
        state.last_news = Instant::now();
        drop(state);
        self.done.store(0, Ordering::Relaxed);
        (self.wake)();
    }
    fn done(&self, share: f64) {
        self.done.store((1000.0 * share) as u32, Ordering::Relaxed);
        // A thread that finds the lock taken has nothing new to say.
        if let Ok(mut state) = self.state.try_lock()
            && state.last_news.elapsed() >= NEWS_EVERY
        {
            state.last_news = Instant::now();
            drop(state);
            (self.wake)();
        }
    }
    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Progress of a job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// Name of the current stage.
    pub stage: &'static str,
    /// Fraction of the stage that is done, 0..=1.
    pub done: f32,
    /// Time for which the job has been running.
    pub running: Duration,
    /// Whether the job was asked to stop and has not stopped yet.
    pub stopping: bool,
}

/// Slot for one kind of work. A new job replaces the one before, whose result is never seen, however late it comes;
/// the new one begins when the old one has stopped, so that work does not pile up.
pub struct Slot<T> {
    running: Option<Running<T>>,
    /// Thread of a job that was replaced or dropped.
    leaving: Option<JoinHandle<()>>,
    wake: Wake,
}

struct Running<T> {
    ticket: Arc<Ticket>,
    result: Receiver<Result<T, Failure>>,
    /// Thread of the job; none where the system gave no thread, which is then the result.
    thread: Option<JoinHandle<()>>,
    since: Instant,
}

/// Wakes whoever looks at results when a thread ends, even by a panic.
struct WakeWhenDropped(Wake);

impl Drop for WakeWhenDropped {
    fn drop(&mut self) {
        (self.0)();
    }
}

impl<T: Send + 'static> Slot<T> {
    /// Creates a slot without a job.
    pub fn new(wake: Wake) -> Self {
        Self { running: None, leaving: None, wake }
    }

    /// Starts a job in place of whatever is running.
    pub fn start(&mut self, work: impl FnOnce(&Ticket) -> Result<T, Failure> + Send + 'static) {
        self.drop_running();
        let before = self.leaving.take();
        let ticket = Arc::new(Ticket::new(Arc::clone(&self.wake)));
        let (send, result) = channel();
        let at_the_end = WakeWhenDropped(Arc::clone(&self.wake));
        let own = Arc::clone(&ticket);
        let body = move || {
            // Dropped in reverse: whoever is woken finds the result, or that there will be none because the work panicked.
            let _at_the_end = at_the_end;
            let send = send;
            lower_priority();
            if let Some(before) = before {
                // A job that panicked has stopped as well.
                let _ = before.join();
            }
            let outcome = if own.cancelled() { Err(Failure::Interrupted) } else { work(&own) };
            // Nobody listens where the job was replaced.
            let _ = send.send(outcome);
        };
        let (thread, result) = match std::thread::Builder::new().name("planish-job".to_owned()).spawn(body) {
            Ok(thread) => (Some(thread), result),
            Err(e) => {
                let (send, result) = channel();
                let _ = send.send(Err(Failure::Internal(format!("no thread could be started: {e}"))));
                (None, result)
            }
        };
        self.running = Some(Running { ticket, result, thread, since: Instant::now() });
    }

    /// Takes the result, which is returned once.
    pub fn poll(&mut self) -> Option<Result<T, Failure>> {
        let running = self.running.as_ref()?;
        let outcome = match running.result.try_recv() {
            Ok(outcome) => outcome,
            Err(TryRecvError::Empty) => return None,
            // The thread is gone and has said nothing: it panicked.
            Err(TryRecvError::Disconnected) => Err(Failure::Internal(
                "the work ended unexpectedly, which is a fault of planish; the details are on the terminal".to_owned(),
            )),
        };
        self.running = None;
        Some(outcome)
    }

    /// Asks the job to stop; it ends with [`Failure::Interrupted`], or with its result if that is sooner.
    pub fn cancel(&self) {
        if let Some(running) = &self.running {
            running.ticket.cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// Returns the progress of the job; none if there is none.
    pub fn status(&self) -> Option<Status> {
        let Running { ticket, since, .. } = self.running.as_ref()?;
        Some(Status {
            stage: ticket.state().stage,
            done: ticket.done.load(Ordering::Relaxed) as f32 / 1000.0,
            running: since.elapsed(),
            stopping: ticket.cancelled(),
        })
    }

    /// Stops the job and forgets it.
    pub fn drop_running(&mut self) {
        self.cancel();
        if let Some(running) = self.running.take() {
            // Dropping the receiver is what keeps a late result from ever being seen.
            self.leaving = running.thread;
        }
    }

    /// Stops the job and waits until it has stopped: it may be writing files, which it leaves whole or takes away.
    pub fn finish(&mut self) {
        self.drop_running();
        if let Some(thread) = self.leaving.take() {
            // A job that panicked has stopped as well.
            let _ = thread.join();
        }
    }

    /// Whether a job is running.
    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }
}

impl<T> Drop for Slot<T> {
    fn drop(&mut self) {
        if let Some(running) = &self.running {
            running.ticket.cancelled.store(true, Ordering::Relaxed);
        }
    }
}

/// Drops something large on a thread of its own: giving its memory back takes longer than a frame may.
pub fn drop_in_background(large: impl Send + 'static) {
    // Where no thread can be started it is dropped here, with the closure.
    let _ = std::thread::Builder::new().name("planish-discard".to_owned()).spawn(move || drop(large));
}

/// The window goes before work in the background: on few cores that is what keeps it smooth.
pub fn lower_priority() {
    #[cfg(target_os = "linux")]
    {
        // On Linux priorities are those of threads. Where it is refused, work goes on as it would elsewhere.
        let _ = rustix::process::setpriority_process(Some(rustix::thread::gettid()), 10);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    /// Wakes the thread of the test.
    fn waking() -> Wake {
        let test = std::thread::current();
        Arc::new(move || test.unpark())
    }

    fn wait<T: Send + 'static>(slot: &mut Slot<T>) -> Result<T, Failure> {
        loop {
            if let Some(outcome) = slot.poll() {
                return outcome;
            }
            std::thread::park();
        }
    }

    #[test]
    fn a_late_result_never_replaces_a_newer_one() {
        let mut slot = Slot::new(waking());
        let (open, gate) = mpsc::channel::<()>();
        let (told, heard) = mpsc::channel();
        // The first job does not look at its ticket and ends with a result, but late.
        slot.start(move |_| {
            told.send(()).unwrap();
            gate.recv().unwrap();
            told.send(()).unwrap();
            Ok("old")
        });
        heard.recv().unwrap();
        slot.start(|_| Ok("new"));
        assert_eq!(slot.poll(), None, "the new one waits for the old one to stop");
        open.send(()).unwrap();
        assert_eq!(wait(&mut slot), Ok("new"));
        heard.recv().unwrap();
        assert_eq!(slot.poll(), None);
    }

    #[test]
    fn a_cancelled_job_stops_and_says_so() {
        let mut slot: Slot<()> = Slot::new(waking());
        slot.start(|ticket| {
            ticket.stage("waiting");
            loop {
                ticket.check()?;
                std::thread::yield_now();
            }
        });
        while slot.status().is_some_and(|s| s.stage.is_empty()) {
            std::thread::park();
        }
        assert_eq!(slot.status().map(|s| (s.stage, s.stopping)), Some(("waiting", false)));
        slot.cancel();
        assert_eq!(wait(&mut slot), Err(Failure::Interrupted));
        assert!(slot.status().is_none() && !slot.is_busy());
    }

    #[test]
    fn a_job_that_panics_is_an_error_like_any_other() {
        let mut slot: Slot<()> = Slot::new(waking());
        slot.start(|_| std::panic::resume_unwind(Box::new("on purpose")));
        assert!(matches!(wait(&mut slot), Err(Failure::Internal(_))));
        slot.start(|_| Ok(()));
        assert_eq!(wait(&mut slot), Ok(()));
    }

    #[test]
    fn leaving_stops_the_work() {
        let (told, heard) = mpsc::channel();
        let mut slot: Slot<()> = Slot::new(waking());
        let (begun, begins) = mpsc::channel();
        slot.start(move |ticket| {
            begun.send(()).unwrap();
            while !ticket.cancelled() {
                std::thread::yield_now();
            }
            told.send(()).unwrap();
            Err(Failure::Interrupted)
        });
        begins.recv().unwrap();
        drop(slot);
        heard.recv_timeout(Duration::from_secs(60)).unwrap();
    }
}
