//! The threads that work inside a frame.

use std::num::NonZeroUsize;

use crate::error::{Error, Result};

/// A stage's pool of threads, the first of which is the stage's own, which works rather than wait for the
/// others. It waits for channels between frames only, never inside the pool's work.
///
/// Level one, the mesh and the rasteriser have a pool each: in a common one a short piece of work waits for
/// a long one of another stage. Measured with `cargo bench -p polyreel-bench --bench pipeline`
/// on 720p video with one step of refinement: a quarter more frames a second, and half of the time in
/// each stage.
pub(super) struct Pool(rayon::ThreadPool);

impl Pool {
    /// A pool of `threads`, the calling thread among them; `None` is one a core. A thread can be in one
    /// pool only, and rayon keeps what it knows of that pool, some 10 KiB, for good.
    ///
    /// # Errors
    /// When the system gives no more threads.
    pub(super) fn with_this_thread(threads: Option<NonZeroUsize>) -> Result<Self> {
        // Zero is rayon's word for a thread a core.
        let threads = threads.map_or(0, NonZeroUsize::get);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|n| format!("inside-{n}"))
            .use_current_thread()
            .build();
        pool.map(Self).map_err(|error| Error::thread("inside-frame", error))
    }

    /// Does `job` on the calling thread, which must be [the one that made the pool](Self::with_this_thread),
    /// with the others' help.
    pub(super) fn work<T: Send>(&self, job: impl FnOnce() -> T + Send) -> T {
        self.0.install(job)
    }
}
