//! Threads that compute: a pool of this process, so that a child that was forked has its own, and `threads` may change how many they are.
//!
//! A fork copies only the thread that asks for it. What is forked while another thread computes may have its locks in any state: it is
//! refused at once.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::refused;

/// The threads, and the process that they are in.
struct Pool {
    process: u32,
    threads: Arc<ThreadPool>,
}

/// Held only by who has Python's lock, so that no fork finds it locked.
static POOL: Mutex<Option<Pool>> = Mutex::new(None);

/// Computations that run now, of all threads.
static RUNNING: AtomicUsize = AtomicUsize::new(0);

/// A computation that runs.
struct Running;

impl Running {
    fn begun() -> Self {
        RUNNING.fetch_add(1, Ordering::SeqCst);
        Self
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        RUNNING.fetch_sub(1, Ordering::SeqCst);
    }
}

fn made(count: usize) -> PyResult<Arc<ThreadPool>> {
    let of = ThreadPoolBuilder::new().num_threads(count).build();
    of.map(Arc::new).map_err(|error| PyRuntimeError::new_err(format!("{count} threads cannot be started: {error}")))
}

/// The threads of this process: those that are there, or with `count` so many new ones.
fn pool(count: Option<usize>) -> PyResult<Arc<ThreadPool>> {
    let process = std::process::id();
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let mut wanted = 0;
    if let Some(before) = pool.as_ref() {
        if before.process == process {
            if count.is_none() {
                return Ok(Arc::clone(&before.threads));
            }
        } else {
            if RUNNING.load(Ordering::SeqCst) > 0 {
                let why = "this process was forked while another thread computed here, and cannot compute: start processes with \
                           multiprocessing.get_context(\"spawn\"), or fork when nothing runs";
                return Err(PyRuntimeError::new_err(why));
            }
            wanted = before.threads.current_num_threads();
        }
    }
    let threads = made(count.unwrap_or(wanted))?;
    let before = pool.replace(Pool { process, threads: Arc::clone(&threads) });
    // Threads of the parent are not here: to end them would wait for them.
    if let Some(before) = before.filter(|before| before.process != process) {
        std::mem::forget(before);
    }
    Ok(threads)
}

/// Computes with the threads of this process. Every door leads through here: the host's arithmetic is checked, and the process.
///
/// # Errors
/// If the host rounds otherwise than bounds are proven for, or the process was forked while it computed.
pub(crate) fn computed<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let inside = entered()?;
    Ok(py.detach(|| inside.install(work)))
}

/// The threads, for work that another thread waits for.
pub(crate) struct Inside {
    threads: Arc<ThreadPool>,
    running: Running,
}

impl Inside {
    /// Does work on the threads, on which other work may run meanwhile.
    pub(crate) fn install<T: Send>(self, work: impl FnOnce() -> T + Send) -> T {
        let Self { threads, running } = self;
        let done = threads.install(work);
        drop(running);
        done
    }
}

/// Enters; as [`computed`] says.
pub(crate) fn entered() -> PyResult<Inside> {
    // Another library of the process may have set another rounding, which new threads inherit.
    radgrad_scene::check_host().map_err(refused)?;
    Ok(Inside { threads: pool(None)?, running: Running::begun() })
}

/// Sets how many threads computations use that begin from now on, 0 for one a core, or leaves it. Returns how many there are.
#[pyfunction]
#[pyo3(signature = (count=None))]
pub(crate) fn threads(count: Option<usize>) -> PyResult<usize> {
    /// More would only cost memory.
    const MOST: usize = 1024;
    if let Some(count) = count.filter(|count| *count > MOST) {
        return Err(refused(format!("count is {count}: it must be a number of threads, at most {MOST}, or 0 for one a core")));
    }
    radgrad_scene::check_host().map_err(refused)?;
    Ok(pool(count)?.current_num_threads())
}
