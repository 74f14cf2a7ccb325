//! Where the engine works: on threads of this module, while the caller waits and hears Ctrl-C. A process that was forked
//! gets threads of its own, because those of its parent are not in it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, bounded};
use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::away::away;
use crate::error::{PolyreelError, fault};

/// How often a wait looks whether Ctrl-C was pressed.
const TICK: Duration = Duration::from_millis(50);

/// The threads, and the process that they are in.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

fn pool() -> PyResult<Arc<ThreadPool>> {
    let mut held = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((process, pool)) = &*held
        && *process == process::id()
    {
        return Ok(pool.clone());
    }
    let made = rayon::ThreadPoolBuilder::new().thread_name(|n| format!("polyreel-{n}")).build();
    let pool = Arc::new(
        made.map_err(|error| PolyreelError::new_err(format!("threads cannot be had: {error}")))?,
    );
    // To drop a parent's pool would be to wake threads that are not there.
    std::mem::forget(held.replace((process::id(), pool.clone())));
    Ok(pool)
}

/// Does `job` on the module's threads. Ctrl-C ends the wait for it; then it goes on by itself, and its result is
/// dropped.
pub(crate) fn work<T: Send + 'static>(
    py: Python<'_>,
    job: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (done, result) = bounded(1);
    pool()?.spawn(move || {
        // Nobody may wait any more. What the job held is gone after a panic.
        let _ = done.send(catch_unwind(AssertUnwindSafe(job)));
    });
    match wait(py, &result)? {
        Some(Ok(value)) => Ok(value),
        _ => Err(fault()),
    }
}

/// The next message, `None` when none will come. Ctrl-C ends the wait.
pub(crate) fn wait<T: Send>(py: Python<'_>, channel: &Receiver<T>) -> PyResult<Option<T>> {
    loop {
        match away(py, || channel.recv_timeout(TICK)) {
            Ok(message) => return Ok(Some(message)),
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
        }
    }
}
