//! Catches panics of third-party decoders: a panic means that the file is broken.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

use super::broken::title;

thread_local! {
    /// Whether panics of this thread are caught, and thus not printed.
    static FENCED: Cell<bool> = const { Cell::new(false) };
}

/// Runs `decode` and returns its result, or a message for the user if it panics. `format` is the name of the file's
/// format. Data that `decode` changed must not be used after a panic.
pub(crate) fn run<T>(format: &str, decode: impl FnOnce() -> T) -> Result<T, String> {
    keep_quiet();
    let before = FENCED.replace(true);
    let done = panic::catch_unwind(AssertUnwindSafe(decode));
    FENCED.set(before);
    done.map_err(|cause| {
        let text = cause.downcast_ref::<&str>().copied();
        let text = text.or_else(|| cause.downcast_ref::<String>().map(String::as_str));
        let cause = text.unwrap_or("it panicked").lines().next().unwrap_or_default();
        format!("the {} is broken (its decoder failed: {cause}); get another copy", title(format))
    })
}

/// Installs a panic hook that prints nothing for panics that are caught here. The hook belongs to the process, so
/// that it is installed once.
fn keep_quiet() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let hook = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !FENCED.get() {
                hook(info);
            }
        }));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_message() {
        assert_eq!(run("webp", || 7), Ok(7));
        let index = std::hint::black_box(9);
        let message = run("webp", || [1, 2][index]).expect_err("a panic");
        assert!(message.contains("the WebP is broken") && message.contains("index"), "{message}");
        assert!(!FENCED.get());
    }
}
