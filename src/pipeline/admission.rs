//! The way in: frames of a file wait for their turn, frames of a live source do not.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crossbeam_channel::Receiver;

use crate::error::Result;
use crate::frame::Frame;
use crate::source::{Decoded, Source};
use crate::stage::Stage;

use super::controls::Controls;
use super::hop::{Admitted, Orders, Ticket};
use super::pilot::Pilot;
use super::report::FrameReport;
use super::station::Station;

/// Asks a run to stop early. Clones ask for the same. To stop is to have a shorter input: what is in
/// flight is finished, and the output is complete and valid.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Asks for the stop.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether somebody asked.
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Where frames are let in.
#[derive(Debug)]
pub(super) struct Door<'a> {
    /// What is asked for.
    pub(super) controls: &'a Controls,
    /// What decides the detail.
    pub(super) pilot: &'a Pilot,
    /// The user's wish to stop.
    pub(super) stop: &'a Stop,
    /// Set when the rest of the pipeline has ended.
    pub(super) over: &'a AtomicBool,
    /// For a live source, the far end of the way out, to take stale frames back.
    pub(super) queue: Option<Receiver<Result<Admitted>>>,
    /// Frames that have been painted, on their way back to the source, which fills them again.
    pub(super) spent: Receiver<Frame>,
    /// Counts frames that were not let in.
    pub(super) dropped: &'a AtomicU64,
}

impl Door<'_> {
    fn is_shut(&self) -> bool {
        self.stop.is_requested() || self.over.load(Ordering::Relaxed)
    }

    /// Lets `hop` in: waits for room, or, live, takes the place of a frame that nobody has fetched yet.
    /// Whether to go on.
    fn admit(&self, station: &Station<Admitted>, mut hop: Result<Admitted>) -> bool {
        let Some(queue) = self.queue.as_ref().filter(|_| hop.is_ok()) else {
            return station.send(hop);
        };
        while let Some(refused) = station.offer(hop) {
            // The frame may have been fetched in between; then there is room now.
            if queue.try_recv().is_ok() {
                self.dropped.fetch_add(1, Ordering::Relaxed);
            }
            hop = refused;
        }
        true
    }
}

/// Starts the source and reads it to its end, on the thread that calls.
pub(super) fn decode(
    start: impl FnOnce() -> Result<Box<dyn Source>>,
    mut station: Station<Admitted>,
    door: &Door,
) {
    let mut source = match start() {
        Ok(source) => source,
        Err(error) => {
            station.send(Err(error));
            return;
        }
    };
    let (mut index, mut rehearsing) = (0, false);
    loop {
        if door.is_shut() {
            return;
        }
        source.wait();
        if let Ok(frame) = door.spent.try_recv() {
            source.recycle(frame);
        }
        let mut report = FrameReport::new(index);
        let hop = match station.clock.time(Stage::Decode, &mut report, || source.next()) {
            Ok(None) if door.stop.is_requested() => return,
            Ok(None) => match door.pilot.end(index) {
                Ok(()) => return,
                Err(error) => Err(error),
            },
            // What interrupts us may interrupt a program that we read from as well.
            Err(_) if door.stop.is_requested() => return,
            Err(error) => Err(error),
            Ok(Some(Decoded { frame, span, is_warmup: rehearsal })) => {
                if rehearsing && !rehearsal {
                    // In earnest: counted from the beginning.
                    (index, report.index) = (0, 0);
                }
                rehearsing = rehearsal;
                report.pts_s = span.start.to_f64();
                let options = door.controls.options();
                door.pilot.in_charge(rehearsal).detail(index).map(|detail| {
                    let orders = Orders { options, detail };
                    Admitted { ticket: Ticket { orders, asked: 0, span, rehearsal, report }, frame }
                })
            }
        };
        if !door.admit(&station, hop) {
            return;
        }
        index += 1;
    }
}
