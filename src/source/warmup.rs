//! An input that is played twice, so that the mesh at its beginning has adapted to its end.

use std::sync::{Arc, Mutex, PoisonError};

use super::{Decoded, Source, Starter};
use crate::error::Result;
use crate::frame::Frame;

/// An input as a warm-up pass, then the same input again.
pub(super) struct WarmedUp {
    starter: Arc<Mutex<Starter>>,
    pass: Box<dyn Source>,
    is_warmup: bool,
    /// Whether an input that breaks off is kept. Then the warm-up pass ends there without an error, which
    /// the second pass reports.
    allow_truncated: bool,
}

impl WarmedUp {
    /// Plays what `starter` starts.
    ///
    /// # Errors
    /// When it cannot be started.
    pub(super) fn new(starter: Arc<Mutex<Starter>>, allow_truncated: bool) -> Result<Self> {
        let pass = start(&starter)?;
        Ok(Self { starter, pass, is_warmup: true, allow_truncated })
    }
}

/// A new pass. A starter whose last user panicked still works: it opens the input anew.
fn start(starter: &Mutex<Starter>) -> Result<Box<dyn Source>> {
    starter.lock().unwrap_or_else(PoisonError::into_inner)()
}

impl Source for WarmedUp {
    fn wait(&mut self) {
        self.pass.wait();
    }

    fn next(&mut self) -> Result<Option<Decoded>> {
        if self.is_warmup {
            match self.pass.next() {
                Ok(None) => {}
                Err(error) if self.allow_truncated && error.breaks_off() => {}
                Err(error) => return Err(error),
                Ok(Some(decoded)) => return Ok(Some(Decoded { is_warmup: true, ..decoded })),
            }
            self.is_warmup = false;
            self.pass = start(&self.starter)?;
        }
        self.pass.next()
    }

    fn recycle(&mut self, frame: Frame) {
        self.pass.recycle(frame);
    }
}
