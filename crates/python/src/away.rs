//! Work without the interpreter's lock, which threads must not ask for again once the interpreter ends: it would end
//! them in the middle of what they do, and with them, by an abort, the process.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{self, ThreadId};
use std::time::Duration;

use pyo3::prelude::*;

/// The thread that ends the interpreter, once it does.
static ENDING: OnceLock<ThreadId> = OnceLock::new();

/// Threads that are about to take the lock again.
static RETURNING: AtomicUsize = AtomicUsize::new(0);

/// Does `work` without the interpreter's lock. A thread that is still at it when the interpreter ends does not come
/// back.
pub(crate) fn away<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    let done = py.detach(|| {
        let done = work();
        RETURNING.fetch_add(1, Ordering::SeqCst);
        if ENDING.get().is_some_and(|&ending| ending != thread::current().id()) {
            RETURNING.fetch_sub(1, Ordering::SeqCst);
            loop {
                thread::park();
            }
        }
        done
    });
    RETURNING.fetch_sub(1, Ordering::SeqCst);
    done
}

/// From here on no thread but this one comes back; those that are on their way are waited for.
pub(crate) fn end(py: Python<'_>) {
    let _ = ENDING.set(thread::current().id());
    py.detach(|| {
        while RETURNING.load(Ordering::SeqCst) > 0 {
            thread::sleep(Duration::from_millis(1));
        }
    });
}
