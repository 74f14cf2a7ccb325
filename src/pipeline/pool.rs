//! Where the work inside a frame is done.

use std::num::NonZeroUsize;

use crate::error::{Error, Result};

/// A stage's pool of threads. The stage's own thread waits for it, but nothing inside it waits for a
/// stage.
///
/// Level one, the mesh and the rasteriser have one each: in a common queue a short piece of work waits
/// for a long one of another stage, and takes as long as it. Measured on 720p video with one step of
/// refinement: a quarter more frames a second, and half of the time in each stage.
pub(super) struct Pool(rayon::ThreadPool);

impl Pool {
    /// Three pools of `threads` each; `None` is a thread a core.
    pub(super) fn three(threads: Option<NonZeroUsize>) -> Result<[Self; 3]> {
        Ok([Self::new(threads)?, Self::new(threads)?, Self::new(threads)?])
    }

    fn new(threads: Option<NonZeroUsize>) -> Result<Self> {
        // Nought is rayon's word for a thread a core.
        let threads = threads.map_or(0, NonZeroUsize::get);
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|n| format!("inside-{n}"))
            .build()
            .map(Self)
            .map_err(|error| Error::usage(format!("{threads} threads cannot be had: {error}")))
    }

    pub(super) fn work<T: Send>(&self, job: impl FnOnce() -> T + Send) -> T {
        self.0.install(job)
    }
}
