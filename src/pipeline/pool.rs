//! Where the work inside a frame is done.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use crate::error::{Error, Result};

/// A stage's pool of threads, the first of which is the stage's own: it does not hand its work over and
/// wait. It waits for channels between frames only; nothing inside the pool's work does.
///
/// Level one, the mesh and the rasteriser have one each: in a common queue a short piece of work waits
/// for a long one of another stage, and takes as long as it. Measured on 720p video with one step of
/// refinement: a quarter more frames a second, and half of the time in each stage.
pub(super) struct Pool {
    threads: rayon::ThreadPool,
    /// Whether [`Pool::work_awake`] keeps a thread awake.
    awake: bool,
}

/// The threads of a pool.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crew {
    /// How many, the calling one among them; `None` is one a core.
    pub(super) threads: Option<NonZeroUsize>,
    /// Whether nobody [else](crate::sink::Sink::feeds_others) needs the cores.
    pub(super) alone: bool,
}

impl Pool {
    /// The calling thread and as many more as make a `crew`. A thread can be in one pool only, and rayon
    /// keeps what it knows of that pool, some 10 KiB, for good.
    pub(super) fn here(Crew { threads, alone }: Crew) -> Result<Self> {
        // Nought is rayon's word for a thread a core.
        let threads = threads.map_or(0, NonZeroUsize::get);
        let threads = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|n| format!("inside-{n}"))
            .use_current_thread()
            .build()
            .map_err(|error| Error::usage(format!("{threads} threads cannot be had: {error}")))?;
        // Once, not for each frame: on Linux it reads several files.
        let cores = thread::available_parallelism().map_or(1, NonZeroUsize::get);
        let awake = alone && threads.current_num_threads() == 2 && cores >= 2;
        Ok(Self { threads, awake })
    }

    /// As [`Pool::work`], for a job that asks for help again and again, each time for less than it takes to
    /// wake up a thread, 60 us here: where there is one other, a core for it and nobody else who needs that,
    /// it stays awake until the job is done. Measured with one step of refinement at 1080p: 7 % less time, for
    /// 6 % more of the processor's.
    ///
    /// With more threads one that waits in the middle of a piece of work might take up the staying awake of
    /// another, and that piece would never end.
    pub(super) fn work_awake<T: Send>(&self, job: impl FnOnce() -> T + Send) -> T {
        if !self.awake {
            return self.work(job);
        }
        let done = AtomicBool::new(false);
        self.work(|| {
            let this = rayon::current_thread_index();
            rayon::scope(|scope| {
                // The other thread takes the oldest of what waits here, so this before any of the job. In
                // case that this thread comes across it all the same, it must not wait for itself.
                scope.spawn(|_| {
                    if rayon::current_thread_index() != this {
                        stay_awake(&done);
                    }
                });
                // However the job ends.
                let _done = Done(&done);
                job()
            })
        })
    }

    /// Does `job` on the calling thread, [which the pool was made on](Pool::here), with the others' help.
    pub(super) fn work<T: Send>(&self, job: impl FnOnce() -> T + Send) -> T {
        self.threads.install(job)
    }
}

/// Looks for work this often before others may have the core.
const PATIENCE: u32 = 64;

/// Works on what there is until all is `done`.
fn stay_awake(done: &AtomicBool) {
    let mut idle = 0;
    while !done.load(Ordering::Acquire) {
        if rayon::yield_now() == Some(rayon::Yield::Executed) {
            idle = 0;
            continue;
        }
        idle += 1;
        if idle % PATIENCE == 0 { thread::yield_now() } else { std::hint::spin_loop() }
    }
}

/// Says that all is done when it is let go.
struct Done<'a>(&'a AtomicBool);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    /// On a thread of its own: a thread is in one pool for good.
    fn in_pool<T: Send>(threads: usize, job: impl FnOnce(&Pool) -> T + Send) -> thread::Result<T> {
        let crew = Crew { threads: NonZeroUsize::new(threads), alone: true };
        let job = || job(&Pool::here(crew).expect("a pool"));
        thread::scope(|scope| scope.spawn(job).join())
    }

    #[test]
    fn what_stays_awake_does_the_same_work() {
        for threads in [1, 2, 3, 8] {
            let sum = |n: u64| (0..n * 50).into_par_iter().sum::<u64>();
            let sums = in_pool(threads, |pool| {
                (0..200).map(|n| pool.work_awake(|| sum(n))).collect::<Vec<_>>()
            });
            let slowly = (0..200).map(|n| (0..n * 50).sum::<u64>());
            assert!(sums.expect("no panic").into_iter().eq(slowly), "{threads} threads");
        }
    }

    #[test]
    fn a_panic_ends_the_staying_awake() {
        let ended = in_pool(2, |pool| pool.work_awake(|| panic!("an invented panic")));
        assert!(ended.is_err());
    }
}
