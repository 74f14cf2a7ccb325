//! The decode stage: frames of a file wait until the next stage is free; frames of a live source do not.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use crossbeam_channel::Receiver;

use crate::error::Result;
use crate::frame::Frame;
use crate::source::{Decoded, Source};
use crate::stage::Stage;

use super::controls::Controls;
use super::detail::DetailController;
use super::hop::{Admitted, FrameContext, FrameSettings};
use super::report::FrameReport;
use super::worker::StageWorker;

/// A request to stop a run early; clones stop the same run. A stop has the effect of a shorter input: frames in
/// flight are finished, and the output is complete and valid.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Requests the stop.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether a stop was requested.
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The state that decides which frames are admitted, and with which settings.
#[derive(Debug)]
pub(super) struct Admission<'a> {
    /// The options of the run.
    pub(super) controls: &'a Controls,
    /// Chooses the detail.
    pub(super) controller: &'a DetailController,
    /// The user's request to stop.
    pub(super) stop: &'a Stop,
    /// True when the rest of the pipeline has ended.
    pub(super) over: &'a AtomicBool,
    /// For a live source: the receiver of the next stage, from which stale frames are removed.
    pub(super) queue: Option<Receiver<Result<Admitted>>>,
    /// Painted frames, recycled by the source.
    pub(super) frames: Receiver<Frame>,
    /// The number of frames that were not admitted.
    pub(super) dropped: &'a AtomicU64,
}

impl Admission<'_> {
    fn is_over(&self) -> bool {
        self.stop.is_requested() || self.over.load(Ordering::Relaxed)
    }

    /// Admits `hop`. A file's frame waits until the channel has room; a live source's frame replaces one that the
    /// next stage has not taken yet. Returns whether to go on.
    fn admit(&self, worker: &StageWorker<Admitted>, mut hop: Result<Admitted>) -> bool {
        let Some(queue) = self.queue.as_ref().filter(|_| hop.is_ok()) else {
            return worker.send(hop);
        };
        while let Some(refused) = worker.try_send(hop) {
            // The next stage may have taken the frame meanwhile; then the channel has room.
            if queue.try_recv().is_ok() {
                self.dropped.fetch_add(1, Ordering::Relaxed);
            }
            hop = refused;
        }
        true
    }
}

/// Now, if the source is live.
fn arrival(admission: &Admission) -> Option<Instant> {
    admission.queue.as_ref().map(|_| Instant::now())
}

/// Starts the source and reads it to its end, on the calling thread.
pub(super) fn decode(
    start: impl FnOnce() -> Result<Box<dyn Source>>,
    mut worker: StageWorker<Admitted>,
    admission: &Admission,
) {
    let mut source = match start() {
        Ok(source) => source,
        Err(error) => {
            worker.send(Err(error));
            return;
        }
    };
    let (mut index, mut in_warmup) = (0, false);
    loop {
        if admission.is_over() {
            return;
        }
        source.wait();
        if let Ok(frame) = admission.frames.try_recv() {
            source.recycle(frame);
        }
        let mut report = FrameReport::new(index);
        let hop = match worker.timer.time(Stage::Decode, &mut report, || source.next()) {
            Ok(None) if admission.stop.is_requested() => return,
            Ok(None) => match admission.controller.check_end(index) {
                Ok(()) => return,
                Err(error) => Err(error),
            },
            // A signal may have stopped the program that the source reads from, too.
            Err(_) if admission.stop.is_requested() => return,
            Err(error) => Err(error),
            Ok(Some(Decoded { frame, span, is_warmup })) => {
                if in_warmup && !is_warmup {
                    // Frames are counted from the end of the warm-up.
                    (index, report.index) = (0, 0);
                }
                in_warmup = is_warmup;
                report.pts_s = span.start.to_f64();
                report.arrived = arrival(admission);
                let options = admission.controls.options();
                let is_full = is_warmup || admission.controls.is_full_detail();
                let detail = admission.controller.for_frame(is_full).initial_detail(index);
                detail.map(|detail| {
                    let settings = FrameSettings { options, detail };
                    let requested_steps = 0;
                    let context = FrameContext {
                        settings,
                        requested_steps,
                        span,
                        is_warmup,
                        is_full,
                        report,
                    };
                    Admitted { context, frame }
                })
            }
        };
        if !admission.admit(&worker, hop) {
            return;
        }
        index += 1;
    }
}
