//! Ctrl-C: the first asks for a shorter output, the second ends the program at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use polyreel::pipeline::Stop;
use polyreel::sink;

/// Whether Ctrl-C was pressed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on; the first Ctrl-C (or a request to terminate) makes `stop` ask for the end.
    pub(crate) fn listen(stop: &Stop) -> Self {
        let interrupt = Self::default();
        let (pressed, stop) = (interrupt.0.clone(), stop.clone());
        // Without a handler Ctrl-C still ends the program, as the system has it.
        let _ = ctrlc::set_handler(move || {
            if pressed.swap(true, Ordering::SeqCst) {
                sink::remove_unfinished();
                std::process::exit(130);
            }
            stop.request();
        });
        interrupt
    }

    /// Whether it was pressed.
    pub(crate) fn happened(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}
