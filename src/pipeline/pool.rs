//! The threads that work inside a frame.

use std::num::NonZeroUsize;

use crate::error::{Error, Result};

/// A stage's thread pool. Its first thread is the stage's own, which works rather than waits for the others. It waits
/// for channels only between frames, never inside the pool.
///
/// Level one, the mesh and the rasteriser have their own pools: in a common one a short piece of work would wait for
/// a long one of another stage. Measured with `cargo bench -p polyreel-bench --bench pipeline` on 720p video with one
/// step of refinement: a quarter more frames a second, and half of the time in each stage.
pub(super) struct Pool(rayon::ThreadPool);

impl Pool {
    /// A pool of `threads`, including the calling thread; `None` is one for each core. A thread can be in only one
    /// pool, and rayon never frees some 10 KiB for each pool.
    ///
    /// # Errors
    /// When the system gives no more threads.
    pub(super) fn with_this_thread(threads: Option<NonZeroUsize>) -> Result<Self> {
        // Zero means one for each core.
        let threads = threads.map_or(0, NonZeroUsize::get);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|n| format!("inside-{n}"))
            .use_current_thread()
            .build();
        pool.map(Self).map_err(|error| Error::thread("inside-frame", error))
    }

    /// Runs `job` on the calling thread, which must be [the one that made the pool](Self::with_this_thread), with the
    /// help of the others.
    pub(super) fn work<T: Send>(&self, job: impl FnOnce() -> T + Send) -> T {
        self.0.install(job)
    }
}
