//! Waiting for something that another process does, with a deadline.

use std::time::{Duration, Instant};

/// How long anything may take before a test gives up. Nothing depends on how long it does take.
const DEADLINE: Duration = Duration::from_secs(60);

/// Tries `look` until it finds something; panics after a minute.
pub(crate) fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let began = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(began.elapsed() < DEADLINE, "{what}: it never happened");
        std::thread::sleep(Duration::from_millis(5));
    }
}
