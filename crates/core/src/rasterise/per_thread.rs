//! Scratch memory for each thread, kept from picture to picture.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// A `T` for each thread of the pool that works on a picture.
#[derive(Debug, Default)]
pub(super) struct PerThread<T>(Vec<Mutex<T>>);

impl<T: Default> PerThread<T> {
    /// Makes one for each thread of the pool.
    pub(super) fn prepare(&mut self) -> &Self {
        self.0.resize_with(crate::parallel::current_num_threads(), Mutex::default);
        self
    }

    /// The value of this thread, after [`PerThread::prepare`].
    pub(super) fn local(&self) -> MutexGuard<'_, T> {
        let slot = &self.0[crate::parallel::current_thread_index().unwrap_or(0)];
        slot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
