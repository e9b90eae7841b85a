//! Work without Python's lock that Ctrl-C ends.
//!
//! Python hears a signal in its main thread only, between two steps of its own. So the work goes to another thread, and this one
//! looks for signals in between.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::refused;

/// How often signals are looked for.
const PAUSE: Duration = Duration::from_millis(50);

/// Whether the work is to end.
#[derive(Debug, Default)]
pub(crate) struct Stop(AtomicBool);

impl Stop {
    pub(crate) fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Why work ended early.
#[derive(Debug)]
pub(crate) enum Ended {
    /// A wrong input.
    Refused(String),
    /// [`Stop`].
    Stopped,
}

impl<E: std::error::Error> From<E> for Ended {
    fn from(error: E) -> Self {
        Self::Refused(error.to_string())
    }
}

/// Does work without Python's lock. After Ctrl-C `stop` is set, and the work should end soon; then the signal's exception is raised.
///
/// Work that is short is done in this thread.
pub(crate) fn detached<T: Send>(
    py: Python<'_>,
    is_short: bool,
    work: impl FnOnce(&Stop) -> Result<T, Ended> + Send,
) -> PyResult<T> {
    let stop = Stop::default();
    let work = |stop: &Stop| {
        // Another library of the process may have set another rounding: threads inherit it.
        radgrad_scene::check_host()?;
        work(stop)
    };
    let ended = |ended| match ended {
        Ended::Refused(reason) => refused(reason),
        Ended::Stopped => PyRuntimeError::new_err("the work was ended"),
    };
    if is_short {
        return py.detach(|| work(&stop)).map_err(ended);
    }
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        // A thread that fails drops its sender.
        let stopping = &stop;
        scope.spawn(move || sender.send(work(stopping)));
        let receiver = Mutex::new(receiver);
        let wait = || match receiver.lock() {
            Ok(receiver) => receiver.recv_timeout(PAUSE),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        };
        loop {
            match py.detach(wait) {
                Ok(result) => return result.map_err(ended),
                Err(RecvTimeoutError::Disconnected) => return Err(failed()),
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(signal) = py.check_signals() {
                        stop.set();
                        // The scope waits for the thread.
                        py.detach(|| while !matches!(wait(), Ok(_) | Err(RecvTimeoutError::Disconnected)) {});
                        return Err(signal);
                    }
                }
            }
        }
    })
}

/// The exception for a fault of the program itself, which no input should cause.
pub(crate) fn failed() -> PyErr {
    PyRuntimeError::new_err("the computation failed: please report it")
}
