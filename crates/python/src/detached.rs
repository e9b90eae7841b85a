//! Work without Python's lock that Ctrl-C ends.
//!
//! Python hears a signal in its main thread only, between two steps of its own. So the work goes to another thread, and this one
//! looks for signals in between.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::pool::entered;
use crate::refused;

/// How often signals are looked for.
const PAUSE: Duration = Duration::from_millis(50);

/// Who is told how far work that takes long has come: seconds since it began, steps done and all of them (0 if they are not counted), and
/// whether it ended.
static WATCH: Mutex<Option<Py<PyAny>>> = Mutex::new(None);

/// Sets who is told.
#[pyfunction]
pub(crate) fn watched_by(watch: Py<PyAny>) {
    *WATCH.lock().unwrap_or_else(PoisonError::into_inner) = Some(watch);
}

/// Whether the work is to end, and how far it is.
#[derive(Debug, Default)]
pub(crate) struct Stop {
    is_set: AtomicBool,
    done: AtomicUsize,
    all: AtomicUsize,
}

impl Stop {
    pub(crate) fn is_set(&self) -> bool {
        self.is_set.load(Ordering::Relaxed)
    }

    /// Itself, for work that looks by its own.
    pub(crate) const fn flag(&self) -> &AtomicBool {
        &self.is_set
    }

    fn set(&self) {
        self.is_set.store(true, Ordering::Relaxed);
    }

    /// There are so many steps.
    pub(crate) fn expect(&self, steps: usize) {
        self.all.store(steps, Ordering::Relaxed);
    }

    /// So many are done.
    pub(crate) fn step(&self, steps: usize) {
        self.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// Tells who watches.
    fn tell(&self, py: Python<'_>, start: Instant, ended: bool) -> PyResult<()> {
        let watch = WATCH.lock().unwrap_or_else(PoisonError::into_inner).as_ref().map(|watch| watch.clone_ref(py));
        let Some(watch) = watch else { return Ok(()) };
        let [done, all] = [&self.done, &self.all].map(|count| count.load(Ordering::Relaxed));
        watch.call1(py, (start.elapsed().as_secs_f64(), done, all, ended)).map(drop)
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
    let ended = |ended| match ended {
        Ended::Refused(reason) => refused(reason),
        Ended::Stopped => PyRuntimeError::new_err("the work was ended"),
    };
    let inside = entered()?;
    if is_short {
        return py.detach(|| inside.install(|| work(&stop))).map_err(ended);
    }
    let start = Instant::now();
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        // A thread that fails drops its sender.
        let stopping = &stop;
        scope.spawn(move || sender.send(inside.install(|| work(stopping))));
        let receiver = Mutex::new(receiver);
        let wait = || match receiver.lock() {
            Ok(receiver) => receiver.recv_timeout(PAUSE),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        };
        loop {
            match py.detach(wait) {
                Ok(result) => {
                    stop.tell(py, start, true)?;
                    return result.map_err(ended);
                }
                Err(RecvTimeoutError::Disconnected) => return Err(failed()),
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(signal) = py.check_signals().and_then(|()| stop.tell(py, start, false)) {
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

/// Does work that cannot look whether to stop, and is bounded. After Ctrl-C the signal's exception is raised at once, and the work is left to
/// itself.
pub(crate) fn left<T: Send + 'static>(py: Python<'_>, work: impl FnOnce() -> Result<T, Ended> + Send + 'static) -> PyResult<T> {
    let (sender, receiver) = channel();
    let inside = entered()?;
    // Nobody may listen any more.
    std::thread::spawn(move || drop(sender.send(inside.install(work))));
    let receiver = Mutex::new(receiver);
    loop {
        let heard = py.detach(|| match receiver.lock() {
            Ok(receiver) => receiver.recv_timeout(PAUSE),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        });
        match heard {
            Ok(Ok(found)) => return Ok(found),
            Ok(Err(Ended::Refused(reason))) => return Err(refused(reason)),
            Ok(Err(Ended::Stopped)) | Err(RecvTimeoutError::Disconnected) => return Err(failed()),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
        }
    }
}

/// The exception for a fault of the program itself, which no input should cause.
pub(crate) fn failed() -> PyErr {
    PyRuntimeError::new_err("the computation failed: please report it")
}
