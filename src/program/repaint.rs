//! `polyreel render` of a mesh stream: painted anew, without its source.

use std::ffi::OsStr;

use polyreel::error::{Error, Result};
use polyreel::frame::Rational;
use polyreel::pipeline::{self, InputReport, OutputReport, Part, Report, Stop};
use polyreel::sink::repainted::Repainted;
use polyreel::sink::{self, SinkOptions};
use polyreel::source::mesh_stream::MeshSource;
use polyreel::stream::StreamInfo;

use crate::program::cli::RenderArgs;
use crate::program::embed::Watcher;
use crate::program::interrupt::Interrupt;
use crate::program::render::{Frames, bytes_of, record_of, sound};

/// Renders the mesh stream `source` to `output`, as [`render_for`](super::render::render_for) does other inputs.
pub(crate) fn repaint(
    args: &RenderArgs,
    source: MeshSource,
    output: &OsStr,
    stop: &Stop,
    interrupt: &Interrupt,
    watcher: &mut dyn Watcher,
) -> Result<()> {
    let run = &args.run;
    if run.budget.is_some() || run.replay.is_some() || run.looped || run.preview {
        return Err(Error::usage(
            "--budget, --replay, --loop and --preview are for inputs that become a mesh; a mesh stream is one",
        ));
    }
    if args.input.max_size.is_some() {
        return Err(Error::usage(
            "--max-size is for inputs that become a mesh; a mesh stream is painted at any size: --scale",
        ));
    }
    let scale = args.write.scale.unwrap_or(1.0);
    let look = args.look.repaint(&source.look())?.enlarged(scale);
    let part = Part {
        start: args.input.start,
        end: args.input.end,
        frames: args.input.frames.map(std::num::NonZeroU64::get),
    };
    let info = info_of_part(source.info(), &part);
    let info = StreamInfo { size: args.write.scaled(info.size)?, ..info };
    let inputs: Vec<_> = source.path().map(Into::into).into_iter().collect();
    let record = record_of(args, &inputs, output, interrupt)?;
    let options = SinkOptions {
        inputs,
        sound: sound(args),
        look: look.clone(),
        ..crate::program::render::write_options(args, interrupt)?
    };
    let sink = sink::create(output, &info, &options)?;
    let warnings = sink.warnings().to_vec();
    warnings.iter().for_each(|warning| watcher.warns(warning));
    let sink = watcher.taps(Box::new(Repainted::new(sink, &look, info.size)));
    let mut frames = Frames::begin(watcher, &info, record.is_some());
    interrupt.begin();
    let allowed = args.input.allow_truncated;
    let ended = pipeline::repaint(|| Ok(source), &part, sink, allowed, &mut frames, stop);
    let per_frame = frames.end();
    let summary = ended?;
    let path = output.to_string_lossy().into_owned();
    let written = OutputReport { path, size: info.size, bytes: bytes_of(output), warnings };
    watcher.ended(&info, &written, &summary);
    if let Some(record) = record {
        let input = InputReport::new(&args.input.inputs, info);
        record.write(&Report::new(input, written, look, &summary, per_frame))?;
    }
    Ok(())
}

/// The properties of a part of the stream `info`. The number of frames is known if only that is limited.
fn info_of_part(info: &StreamInfo, part: &Part) -> StreamInfo {
    let cut = part.start.is_some_and(|start| start > Rational::ZERO) || part.end.is_some();
    let most = part.frames.unwrap_or(u64::MAX);
    let frames = if cut { None } else { info.frames.map(|frames| frames.min(most)) };
    let frames = if part.frames == Some(1) { Some(1) } else { frames };
    let whole = frames == info.frames;
    StreamInfo { frames, duration: info.duration.filter(|_| whole), ..info.clone() }
}
