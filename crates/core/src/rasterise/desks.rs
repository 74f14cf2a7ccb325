//! Memory that each thread has for itself, kept from picture to picture.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// A `T` for each thread of the pool that works on a picture.
#[derive(Debug, Default)]
pub(super) struct Desks<T>(Vec<Mutex<T>>);

impl<T: Default> Desks<T> {
    /// As many as there are threads.
    pub(super) fn prepare(&mut self) -> &Self {
        self.0.resize_with(crate::parallel::current_num_threads(), Mutex::default);
        self
    }

    /// That of this thread, once they are [prepared](Self::prepare).
    pub(super) fn mine(&self) -> MutexGuard<'_, T> {
        let desk = &self.0[crate::parallel::current_thread_index().unwrap_or(0)];
        desk.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
