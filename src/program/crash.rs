//! Reports panics as messages without a trace, with exit code 1.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::{Mutex, MutexGuard, PoisonError};

use polyreel::error::{Error, Result};

/// The messages of panics. A panic that is caught and reported elsewhere is not shown. The panic hook belongs to the
/// process, and so does this list.
static PANICS: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// The most panics that are kept. A panic of one thread may cause others.
const MOST_KEPT: usize = 4;

/// The result of `job`. A panic in it, or in a stage that it waits for, becomes an error; by then all data of the job
/// has been dropped, unfinished outputs too.
pub(crate) fn catch<T>(job: impl FnOnce() -> Result<T>) -> Result<T> {
    panic::set_hook(Box::new(note));
    // The data of the job is not used after a panic.
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
    // Only if RUST_BACKTRACE is set.
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
