//! An input that is played twice, so that what learns from it knows its end at its beginning.

use std::sync::{Arc, Mutex, PoisonError};

use super::{Decoded, Source, Starter};
use crate::error::Result;
use crate::frame::Frame;

/// An input as a rehearsal, then the same once more in earnest.
pub(super) struct Rehearsed {
    starter: Arc<Mutex<Starter>>,
    round: Box<dyn Source>,
    rehearses: bool,
    /// Whether an input that breaks off is kept. Then the rehearsal breaks off in silence, and the error
    /// comes in its place in the second round.
    allow_truncated: bool,
}

impl Rehearsed {
    /// What `starter` starts.
    ///
    /// # Errors
    /// As it has them.
    pub(super) fn new(starter: Arc<Mutex<Starter>>, allow_truncated: bool) -> Result<Self> {
        let round = start(&starter)?;
        Ok(Self { starter, round, rehearses: true, allow_truncated })
    }
}

/// A new round. A starter whose last user panicked is as good as any: it opens the input anew.
fn start(starter: &Mutex<Starter>) -> Result<Box<dyn Source>> {
    starter.lock().unwrap_or_else(PoisonError::into_inner)()
}

impl Source for Rehearsed {
    fn wait(&mut self) {
        self.round.wait();
    }

    fn next(&mut self) -> Result<Option<Decoded>> {
        if self.rehearses {
            match self.round.next() {
                Ok(None) => {}
                Err(_) if self.allow_truncated => {}
                done => return done,
            }
            self.rehearses = false;
            self.round = start(&self.starter)?;
        }
        self.round.next()
    }

    fn reuse(&mut self, spent: Frame) {
        self.round.reuse(spent);
    }

    fn rehearses(&self) -> bool {
        self.rehearses
    }
}
