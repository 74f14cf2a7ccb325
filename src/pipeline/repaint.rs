//! Writes mesh streams to any output, without the stages that make meshes.

use std::thread;
use std::time::Instant;

use crossbeam_channel::{Sender, bounded};

use super::hop::Painted;
use super::report::{Ending, FrameReport, Summary};
use super::sink_loop::SinkLoop;
use super::worker::StageTimer;
use super::{CAPACITY, Observer, Stop, Totals, resume, spawn};
use crate::error::Result;
use crate::frame::{Fill, Rational};
use crate::mesh_stream::MeshFrame;
use crate::sink::repainted::nothing;
use crate::sink::{Origin, Picture, Sink};
use crate::source::mesh_stream::Meshes;
use crate::stage::Stage;
use crate::stream::Span;

/// The part of a mesh stream that is written.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Start of the part, in seconds: earlier frames are skipped, and times count from here.
    pub start: Option<Rational>,
    /// End of the part, in seconds: frames that start then or later are skipped.
    pub end: Option<Rational>,
    /// The most frames that are written.
    pub frames: Option<u64>,
}

/// Writes the `part` of the mesh stream of `open` to `sink`, which must take [plain](crate::sink::Needs::plain)
/// colours and their mesh. With `allow_truncated` a truncated input still gives an output.
///
/// # Errors
/// As [`super::run`].
pub fn repaint<M: Meshes>(
    open: impl FnOnce() -> Result<M> + Send,
    part: &Part,
    sink: Box<dyn Sink>,
    allow_truncated: bool,
    observer: &mut dyn Observer,
    stop: &Stop,
) -> Result<Summary> {
    let began = Instant::now();
    let mut totals = Totals::new(None);
    let ending = thread::scope(|scope| -> Result<Ending> {
        let (frame_tx, frame_rx) = bounded(CAPACITY);
        let (report_tx, report_rx) = bounded(CAPACITY);
        let (buffers, _) = bounded(CAPACITY);
        let decoding = spawn(scope, "decode", move || {
            if let Err(error) = decode(open, part, stop, &frame_tx) {
                // The receiver is gone if the run has ended.
                let _ = frame_tx.send(Err(error));
            }
        })?;
        let keep_truncated = allow_truncated;
        let sink_loop = SinkLoop { sink, reports: report_tx, buffers, stop, keep_truncated };
        let encoding = spawn(scope, "encode", move || sink_loop.run(frame_rx))?;
        for report in report_rx {
            totals.add(&report);
            if observer.frame_done(&report).is_break() {
                stop.request();
            }
        }
        resume(decoding);
        resume(encoding)
    })?;
    Ok(totals.summary(0, began.elapsed(), ending))
}

/// Sends the frames of `part` on.
fn decode<M: Meshes>(
    open: impl FnOnce() -> Result<M>,
    part: &Part,
    stop: &Stop,
    frames: &Sender<Result<Painted>>,
) -> Result<()> {
    let mut source = open()?;
    let mut timer = StageTimer::new(Stage::Decode);
    let from = part.start.unwrap_or(Rational::ZERO);
    let mut index = 0;
    while part.frames.is_none_or(|most| index < most) && !stop.is_requested() {
        let mut report = FrameReport::new(index);
        let Some(frame) = timer.time(Stage::Decode, &mut report, || source.next_mesh())? else {
            break;
        };
        if frame.time.start < from {
            continue;
        }
        if part.end.is_some_and(|end| frame.time.start >= end) {
            break;
        }
        if frames.send(Ok(painted(frame, report, from)?)).is_err() {
            break;
        }
        index += 1;
    }
    Ok(())
}

fn painted(frame: MeshFrame, mut report: FrameReport, from: Rational) -> Result<Painted> {
    let MeshFrame { mesh, colours, time, .. } = frame;
    let span = Span { start: time.start - from, length: time.length };
    report.pts_s = span.start.to_f64();
    (report.seeds, report.triangles) = (mesh.seeds().len(), mesh.triangles.len());
    let fills = colours.iter().map(|&colour| Fill { colour, area: 0 }).collect();
    let picture = Picture { frame: nothing()?, fills, span };
    let origin = Some(Origin { frame: nothing()?, mesh });
    Ok(Painted { is_warmup: false, report, picture, origin })
}
