//! A stage's place of work: its clock, its way out, and what it does about errors and panics.

use std::num::NonZeroUsize;
use std::time::Instant;

use crossbeam_channel::{Receiver, Sender};

use crate::error::{Error, Result};
use crate::stage::Stage;

use super::pool::Pool;
use super::report::FrameReport;

/// The only clock of the program that frames meet. It knows which stage its thread is working on.
#[derive(Debug)]
pub(super) struct Clock {
    stage: Stage,
}

impl Clock {
    pub(super) fn new(stage: Stage) -> Self {
        Self { stage }
    }

    /// Does `job`, the work of `stage` on the frame of `report`, and adds its time to the report. An
    /// error gets the frame's number and the stage.
    pub(super) fn time<T>(
        &mut self,
        stage: Stage,
        report: &mut FrameReport,
        job: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        self.stage = stage;
        let started = Instant::now();
        let done = job();
        report.timing.add(stage, started.elapsed());
        done.map_err(|error| error.at(report.index, stage))
    }
}

/// The way out of a stage, with its clock. If the stage's thread panics, the stage after hears of an
/// error in place of the frame, so that nobody takes the silence for the end of the input.
#[derive(Debug)]
pub(super) struct Station<T> {
    pub(super) clock: Clock,
    outbox: Sender<Result<T>>,
}

impl<T> Station<T> {
    pub(super) fn new(stage: Stage, outbox: Sender<Result<T>>) -> Self {
        Self { clock: Clock::new(stage), outbox }
    }

    /// Hands `hop` on, waiting for room. Whether the stage should go on: not after an error, and not
    /// when nobody listens any more, which is how a stage learns that the run has ended.
    pub(super) fn send(&self, hop: Result<T>) -> bool {
        let failed = hop.is_err();
        self.outbox.send(hop).is_ok() && !failed
    }

    /// Hands `hop` on if there is room at once; gives it back if there is not.
    pub(super) fn offer(&self, hop: Result<T>) -> Option<Result<T>> {
        self.outbox.try_send(hop).err().map(crossbeam_channel::TrySendError::into_inner)
    }

    /// Works on everything that comes in, until it ends or fails.
    pub(super) fn run<A>(
        mut self,
        inbox: Receiver<Result<A>>,
        mut work: impl FnMut(&mut Clock, A) -> Result<T>,
    ) {
        for hop in inbox {
            let done = hop.and_then(|hop| work(&mut self.clock, hop));
            if !self.send(done) {
                return;
            }
        }
    }

    /// As [`Station::run`], with a pool of `threads` of which this thread is the first.
    pub(super) fn run_in_pool<A>(
        self,
        threads: Option<NonZeroUsize>,
        inbox: Receiver<Result<A>>,
        mut work: impl FnMut(&Pool, &mut Clock, A) -> Result<T>,
    ) {
        match Pool::with_this_thread(threads) {
            Ok(pool) => self.run(inbox, |clock, hop| work(&pool, clock, hop)),
            Err(error) => {
                self.send(Err(error));
            }
        }
    }
}

impl<T> Drop for Station<T> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            // Nobody listening is fine: the run has ended already.
            let _ = self.outbox.send(Err(Error::Panicked(self.clock.stage)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crossbeam_channel::bounded;

    /// What two stations hand on when the first, of `stage`, does `work` on the numbers from 0 to 9,
    /// and whether its thread panicked.
    fn through(
        stage: Stage,
        work: impl Fn(&mut Clock, u64) -> Result<u64> + Send,
    ) -> (Vec<Result<u64>>, bool) {
        let (put, first) = bounded(1);
        let (hand, second) = bounded(1);
        let (out, end) = bounded(1);
        std::thread::scope(|scope| {
            let worker = scope.spawn(|| Station::new(stage, hand).run(first, work));
            scope.spawn(|| Station::new(Stage::Encode, out).run(second, |_, n| Ok(n)));
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
            let (got, panicked) = through(stage, |clock, n| {
                clock.time(stage, &mut FrameReport::new(n), || {
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
        let (got, panicked) = through(Stage::Sample, |clock, n| {
            clock.time(Stage::Triangulate, &mut FrameReport::new(n), || match n {
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
