//! Panics: a message in place of a trace, and exit code 1.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::{Mutex, MutexGuard, PoisonError};

use polyreel::error::{Error, Result};

/// What the panics of this process said. One that somebody catches and reports on is not shown.
static PANICS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Panics that are kept. When one thread panics others may follow.
const MOST_KEPT: usize = 4;

/// The result of `job`. A panic in it, or in a stage that it waits for, is an error; by then all that the
/// job held has been dropped, unfinished outputs with it.
pub(crate) fn catch<T>(job: impl FnOnce() -> Result<T>) -> Result<T> {
    panic::set_hook(Box::new(note));
    // Nothing that the job changed is looked at after a panic.
    panic::catch_unwind(AssertUnwindSafe(job)).unwrap_or_else(|_| {
        let what = panics().join("; ");
        Err(Error::failed(format!(
            "{what}; this is a fault in polyreel: please report it, with the input that led to it"
        )))
    })
}

fn note(panic: &PanicHookInfo<'_>) {
    let payload = panic.payload();
    let message = payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_default();
    let place = panic.location().map_or_else(String::new, |at| format!(" at {at}"));
    // Only where RUST_BACKTRACE asks for it.
    let trace = Backtrace::capture();
    if trace.status() == BacktraceStatus::Captured {
        crate::program::terminal::say_lines(&format!(
            "polyreel panicked{place}: {message}\n{trace}"
        ));
    }
    let mut panics = panics();
    if panics.len() < MOST_KEPT {
        panics.push(format!("panicked{place}: {message}"));
    }
}

fn panics() -> MutexGuard<'static, Vec<String>> {
    PANICS.lock().unwrap_or_else(PoisonError::into_inner)
}
