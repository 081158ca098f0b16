//! Work during which the interpreter keeps responding: it runs on threads of its own, while the
//! caller's thread reports progress and checks for Ctrl-C.
//!
//! The work never waits for the interpreter. The caller's thread lets other Python threads run, and
//! ten times a second calls `progress` and lets Python handle signals. An exception from either
//! cancels the work, and is raised again when the work has stopped.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, Thread};
use std::time::Duration;

use pyo3::prelude::*;
use tashika::error::Result;
use tashika::render::{Finished, Progress, with_threads};
use tashika::renderer::Observer;

use crate::errors::raised;

/// Time between two checks.
const PACE: Duration = Duration::from_millis(100);

/// State that the work and the caller's thread share.
#[derive(Default)]
pub struct Watch {
    cancel: AtomicBool,
    latest: Mutex<Option<Progress>>,
    over: AtomicBool,
}

impl Watch {
    /// Stores the progress of the work.
    pub fn tell(&self, progress: &Progress) {
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner) = Some(*progress);
    }

    /// Flag that becomes true when the work is to stop.
    pub fn cancel(&self) -> &AtomicBool {
        &self.cancel
    }

    fn take(&self) -> Option<Progress> {
        self.latest.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn is_over(&self) -> bool {
        self.over.load(Ordering::SeqCst)
    }
}

impl Observer for Watch {
    fn tile(&self, done: &Finished<'_>) {
        self.tell(&done.progress);
    }

    fn progress(&self, progress: &Progress) {
        self.tell(progress);
    }

    fn cancel(&self) -> &AtomicBool {
        &self.cancel
    }
}

/// Marks the work as over when dropped, also when the work panics.
struct End<'a> {
    watch: &'a Watch,
    caller: Thread,
}

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.watch.over.store(true, Ordering::SeqCst);
        self.caller.unpark();
    }
}

/// Runs `work` on a pool of `threads` threads; zero stands for one a core. `progress` is called
/// with finished pixels, all pixels, pixels with a claim within their budget, and rays.
///
/// # Errors
/// Errors of the work, as exceptions; exceptions of `progress` or of a signal's handler.
pub fn attended<T: Send>(
    py: Python<'_>,
    threads: usize,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> Result<T> + Send,
) -> PyResult<T> {
    let watch = Watch::default();
    thread::scope(|scope| {
        let (watch, caller) = (&watch, thread::current());
        let worker = scope.spawn(move || {
            let _end = End { watch, caller };
            with_threads(threads, || work(watch))?
        });
        let mut stopped_by = None;
        loop {
            let over = py.detach(|| {
                if !watch.is_over() {
                    thread::park_timeout(PACE);
                }
                watch.is_over()
            });
            if stopped_by.is_none()
                && let Err(exception) = attend(py, progress, watch)
            {
                watch.cancel.store(true, Ordering::SeqCst);
                stopped_by = Some(exception);
            }
            if over {
                break;
            }
        }
        let outcome = py.detach(|| worker.join());
        match (stopped_by, outcome) {
            (Some(exception), _) => Err(exception),
            (None, Ok(outcome)) => outcome.map_err(raised),
            (None, Err(panic)) => std::panic::resume_unwind(panic),
        }
    })
}

fn attend(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, watch: &Watch) -> PyResult<()> {
    py.check_signals()?;
    if let (Some(progress), Some(Progress { tally, of, rays })) = (progress, watch.take()) {
        progress.call1((tally.rendered(), of, tally.claiming(), rays))?;
    }
    Ok(())
}
