//! The thread of a stage: its timer, its pool, its output, and its errors and panics.

use std::num::NonZeroUsize;
use std::time::Instant;

use crossbeam_channel::{Receiver, Sender};

use crate::chain::StageProbe;
use crate::error::{Error, Result};
use crate::stage::Stage;

use super::pool::Pool;
use super::report::FrameReport;

/// Measures the stages of one thread, and knows the current one. No other clock is read for a frame.
#[derive(Debug)]
pub(super) struct StageTimer {
    stage: Stage,
}

impl StageTimer {
    pub(super) fn new(stage: Stage) -> Self {
        Self { stage }
    }

    /// Runs `job`, the work of `stage` on the frame of `report`, and adds its time to the report. An error gets the
    /// frame's number and the stage.
    pub(super) fn time<T>(
        &mut self,
        stage: Stage,
        report: &mut FrameReport,
        job: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        let done = self.measure(stage, report, job);
        done.map_err(|error| error.at(report.index, stage))
    }

    fn measure<T>(&mut self, stage: Stage, report: &mut FrameReport, job: impl FnOnce() -> T) -> T {
        self.stage = stage;
        let started = Instant::now();
        let done = job();
        report.timing.add(stage, started.elapsed());
        done
    }

    /// A probe that runs the chain's stages in `pool` and adds their times to `report`.
    pub(super) fn probe<'a>(
        &'a mut self,
        pool: &'a Pool,
        report: &'a mut FrameReport,
    ) -> FrameProbe<'a> {
        FrameProbe { timer: self, pool, report }
    }
}

/// Runs the work of the chain on one frame.
pub(super) struct FrameProbe<'a> {
    timer: &'a mut StageTimer,
    pool: &'a Pool,
    report: &'a mut FrameReport,
}

impl FrameProbe<'_> {
    /// The `error` of the stage that ran last, with the frame's number.
    pub(super) fn error(&self, error: impl Into<Error>) -> Error {
        error.into().at(self.report.index, self.timer.stage)
    }
}

impl StageProbe for FrameProbe<'_> {
    fn stage<T: Send>(&mut self, stage: Stage, work: impl FnOnce() -> T + Send) -> T {
        self.timer.measure(stage, self.report, || self.pool.work(work))
    }
}

/// The work of a stage's thread on each frame.
pub(super) trait Process: Send {
    type Input: Send;
    type Output: Send;
    /// Its first stage.
    const STAGE: Stage;
    /// The thread's name.
    const NAME: &'static str;

    /// Works on one frame.
    ///
    /// # Errors
    /// With the frame's number and the stage.
    fn process(
        &mut self,
        hop: Self::Input,
        pool: &Pool,
        timer: &mut StageTimer,
    ) -> Result<Self::Output>;
}

/// The output of a stage, with its timer. If the stage's thread panics, the next stage gets an error in place of the
/// frame; otherwise it would take the closed channel for the end of the input.
#[derive(Debug)]
pub(super) struct StageWorker<T> {
    pub(super) timer: StageTimer,
    outbox: Sender<Result<T>>,
}

impl<T> StageWorker<T> {
    pub(super) fn new(stage: Stage, outbox: Sender<Result<T>>) -> Self {
        Self { timer: StageTimer::new(stage), outbox }
    }

    /// Sends `hop`, and waits if the channel is full. Returns whether the stage should go on: not after an error, nor
    /// without a receiver, which means that the run has ended.
    pub(super) fn send(&self, hop: Result<T>) -> bool {
        let failed = hop.is_err();
        self.outbox.send(hop).is_ok() && !failed
    }

    /// Sends `hop` if the channel has room; returns it otherwise.
    pub(super) fn try_send(&self, hop: Result<T>) -> Option<Result<T>> {
        self.outbox.try_send(hop).err().map(crossbeam_channel::TrySendError::into_inner)
    }

    /// Works on all input, until it ends or fails.
    pub(super) fn run<A>(
        mut self,
        inbox: Receiver<Result<A>>,
        mut work: impl FnMut(&mut StageTimer, A) -> Result<T>,
    ) {
        for hop in inbox {
            let done = hop.and_then(|hop| work(&mut self.timer, hop));
            if !self.send(done) {
                return;
            }
        }
    }

    /// As [`StageWorker::run`], with a pool of `threads`, the first of which is this thread.
    pub(super) fn run_in_pool<P: Process<Output = T>>(
        self,
        threads: Option<NonZeroUsize>,
        inbox: Receiver<Result<P::Input>>,
        mut process: P,
    ) {
        match Pool::with_this_thread(threads) {
            Ok(pool) => self.run(inbox, |timer, hop| process.process(hop, &pool, timer)),
            Err(error) => {
                self.send(Err(error));
            }
        }
    }
}

impl<T> Drop for StageWorker<T> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            // Without a receiver the run has ended already.
            let _ = self.outbox.send(Err(Error::Panicked(self.timer.stage)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crossbeam_channel::bounded;

    /// What two workers send on when the first, of `stage`, does `work` on the numbers from 0 to 9,
    /// and whether its thread panicked.
    fn through(
        stage: Stage,
        work: impl Fn(&mut StageTimer, u64) -> Result<u64> + Send,
    ) -> (Vec<Result<u64>>, bool) {
        let (put, first) = bounded(1);
        let (hand, second) = bounded(1);
        let (out, end) = bounded(1);
        std::thread::scope(|scope| {
            let worker = scope.spawn(|| StageWorker::new(stage, hand).run(first, work));
            scope.spawn(|| StageWorker::new(Stage::Encode, out).run(second, |_, n| Ok(n)));
            let feeder = scope.spawn(move || (0..10).all(|n| put.send(Ok(n)).is_ok()));
            let got = end.iter().collect();
            // Whoever feeds a stage that has ended stops too, and does not hang.
            feeder.join().expect("the feeder does not panic");
            (got, worker.join().is_err())
        })
    }

    #[test]
    fn a_panic_arrives_as_an_error_in_the_place_of_its_frame() {
        for stage in [Stage::Features, Stage::Sample, Stage::Triangulate, Stage::Rasterise] {
            let (got, panicked) = through(stage, |timer, n| {
                timer.time(stage, &mut FrameReport::new(n), || {
                    assert!(n != 4, "an invented panic");
                    Ok(n)
                })
            });
            assert!(panicked);
            assert_eq!(got.len(), 5, "four frames, and the error");
            assert!(got[..4].iter().zip(0..).all(|(hop, n)| matches!(hop, Ok(m) if *m == n)));
            assert!(matches!(got[4], Err(Error::Panicked(s)) if s == stage), "{:?}", got[4]);
        }
    }

    #[test]
    fn an_error_arrives_with_frame_and_stage_and_ends_the_stage() {
        let (got, panicked) = through(Stage::Sample, |timer, n| {
            timer.time(Stage::Triangulate, &mut FrameReport::new(n), || match n {
                7 => Err(Error::usage("an invented error")),
                n => Ok(n),
            })
        });
        assert!(!panicked);
        assert_eq!(got.len(), 8);
        let error = got[7].as_ref().expect_err("frame 7 fails").to_string();
        assert_eq!(error, "frame 7, triangulate: an invented error");
    }
}
