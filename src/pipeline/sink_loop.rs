//! The encode stage: pictures are written, and their reports go to the observer.

use crossbeam_channel::{Receiver, Sender};

use crate::error::{Error, Result};
use crate::frame::Buffers;
use crate::sink::Sink;
use crate::stage::Stage;

use super::admission::Stop;
use super::hop::Painted;
use super::report::{Ending, FrameReport};
use super::worker::StageTimer;

/// The sink, and the channels from it.
pub(super) struct SinkLoop<'a> {
    /// Where pictures are written.
    pub(super) sink: Box<dyn Sink>,
    /// To the observer.
    pub(super) reports: Sender<FrameReport>,
    /// Takes the buffers of pictures that have been written back to the rasteriser.
    pub(super) buffers: Sender<Buffers>,
    /// The user's request to stop.
    pub(super) stop: &'a Stop,
    /// Whether an input that breaks off still gives an output, of the frames before.
    pub(super) keep_truncated: bool,
}

impl SinkLoop<'_> {
    /// Writes all pictures. The sink is finished unless an error comes in, or comes out of it.
    pub(super) fn run(mut self, inbox: Receiver<Result<Painted>>) -> Result<Ending> {
        let mut timer = StageTimer::new(Stage::Encode);
        let mut written = 0u64;
        for hop in inbox {
            let Painted { mut report, picture, origin, .. } = match hop {
                Ok(hop) if hop.is_warmup => continue,
                Ok(hop) => hop,
                Err(error) if self.keep_truncated && written > 0 && error.breaks_off() => {
                    return self.finish(Ending::Truncated(error));
                }
                Err(error) => return Err(error),
            };
            let sink = &mut self.sink;
            let result = timer.time(Stage::Encode, &mut report, || sink.write(picture, origin));
            let buffers = match result {
                Err(Error::Closed) => return Ok(Ending::Closed),
                done => done?,
            };
            report.delay_ms = report.arrived.map(|then| then.elapsed().as_secs_f64() * 1e3);
            written += 1;
            if !buffers.is_empty() {
                // Where there is no room the rasteriser has enough: then these are dropped.
                let _ = self.buffers.try_send(buffers);
            }
            if self.reports.send(report).is_err() {
                // The caller's thread is unwinding; the sink goes unfinished, as in any failure.
                return Ok(Ending::Stopped);
            }
        }
        match (written, self.stop.is_requested()) {
            (0, true) => Ok(Ending::Stopped),
            (0, false) => Err(Error::NoFrames),
            (_, true) => self.finish(Ending::Stopped),
            (_, false) => self.finish(Ending::Complete),
        }
    }

    fn finish(self, ending: Ending) -> Result<Ending> {
        match self.sink.finish() {
            Err(Error::Closed) => Ok(Ending::Closed),
            done => done.map(|()| ending),
        }
    }
}
