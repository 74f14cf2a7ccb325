//! The way out: pictures are written, and the observer hears of it.

use crossbeam_channel::{Receiver, Sender};

use crate::error::{Error, Result};
use crate::frame::Buffers;
use crate::sink::Sink;
use crate::stage::Stage;

use super::admission::Stop;
use super::hop::Painted;
use super::report::{Ending, FrameReport};
use super::station::Clock;

/// The sink, and the ways from it.
pub(super) struct Delivery<'a> {
    /// Where pictures are written.
    pub(super) sink: Box<dyn Sink>,
    /// The way to the observer.
    pub(super) tell: Sender<FrameReport>,
    /// The memory of pictures that have been written, on their way back to the rasteriser.
    pub(super) return_canvas: Sender<Buffers>,
    /// The user's wish to stop.
    pub(super) stop: &'a Stop,
    /// Whether an input that breaks off still gives an output, of the frames before.
    pub(super) keep_truncated: bool,
}

impl Delivery<'_> {
    /// Writes all pictures. The sink is finished unless an error comes in, or out of it.
    pub(super) fn run(mut self, inbox: Receiver<Result<Painted>>) -> Result<Ending> {
        let mut clock = Clock::new(Stage::Encode);
        let mut written = 0u64;
        for hop in inbox {
            let Painted { mut report, picture, origin, .. } = match hop {
                Ok(hop) if hop.rehearsal => continue,
                Ok(hop) => hop,
                Err(error) if self.keep_truncated && written > 0 && is_truncation(&error) => {
                    return self.finish(Ending::Truncated(error));
                }
                Err(error) => return Err(error),
            };
            let written_out =
                clock.time(Stage::Encode, &mut report, || self.sink.write(picture, origin));
            let canvas = match written_out {
                Err(Error::Closed) => return Ok(Ending::Closed),
                done => done?,
            };
            written += 1;
            if !canvas.is_empty() {
                // Without room the rasteriser has enough of them: then it is let go.
                let _ = self.return_canvas.try_send(canvas);
            }
            if self.tell.send(report).is_err() {
                // The caller's thread is unwinding; the sink goes unfinished, as in any failure.
                return Ok(Ending::Stopped);
            }
        }
        match (written, self.stop.is_requested()) {
            (0, true) => Ok(Ending::Stopped),
            (0, false) => Err(Error::usage("there are no frames to render")),
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

/// Whether `error` says that the input broke off, rather than that we failed.
fn is_truncation(error: &Error) -> bool {
    matches!(error, Error::Input { .. } | Error::Frame { stage: Stage::Decode, .. })
}
