//! `polyreel join`: parts become one film.

use std::ffi::OsStr;
use std::path::Path;
use std::time::Instant;

use indicatif::HumanBytes;
use polyreel::error::{Error, Result};
use polyreel::ffmpeg::{Ffmpeg, Processes};
use polyreel::film::hash;
use polyreel::film::part::{self, Stale};
use polyreel::film::parts::Parts;
use polyreel::film::plan::Kind;
use polyreel::frame::Rational;
use polyreel::mesh_stream::Grid;
use polyreel::options::{Edges, Options};
use polyreel::pipeline::{self, Ending, Part, Stop};
use polyreel::sink::ffmpeg::VideoOptions;
use polyreel::sink::repainted::Repainted;
use polyreel::sink::{self, SinkOptions};
use polyreel::source::{Input, Sound};
use polyreel::stream::StreamInfo;
use polyreel::svg::Seams;

use super::Work;
use super::bar::Bar;
use crate::program::Outcome;
use crate::program::cli::{JoinArgs, scaled};
use crate::program::interrupt::Interrupt;
use crate::program::render::bytes_of;
use crate::program::terminal;

/// Joins the parts of a film.
pub(crate) fn join(args: &JoinArgs) -> Result<Outcome> {
    let interrupt = Interrupt::listen(&Stop::default());
    let ffmpeg = Ffmpeg { program: args.ffmpeg.clone(), processes: interrupt.processes() };
    let work = Work::open(&args.plan, args.parts.clone(), ffmpeg, &interrupt)?;
    let work = Work { film: args.film.clone(), quiet: args.quiet, ..work };
    check(&work)?;
    let film = Film { output: &args.output, overwrite: args.overwrite, temporaries: None };
    join_to(&work, &film, interrupt.processes())?;
    Ok(Outcome::Done)
}

/// Checks that all parts are there, and names those that are not.
fn check(work: &Work) -> Result<()> {
    let (mut missing, mut stale) = (0, 0);
    for chunk in &work.plan.chunks {
        let Err(why) = part::check(&work.plan, chunk, &work.folder) else { continue };
        let path = part::meshes(&work.folder, chunk.chunk);
        terminal::say(format_args!("chunk {}: {} {why}", chunk.chunk, path.display()));
        *if why == Stale::Missing { &mut missing } else { &mut stale } += 1;
    }
    if missing + stale == 0 {
        return Ok(());
    }
    let all = work.plan.chunks.len();
    Err(Error::input(
        &work.path,
        format!(
            "{missing} of {all} parts are missing and {stale} are not what the plan asks for: render them with \
             --plan, by --chunk K or --all"
        ),
    ))
}

/// Where the joined film goes.
pub(super) struct Film<'a> {
    pub(super) output: &'a OsStr,
    pub(super) overwrite: bool,
    /// See [`SinkOptions::temporaries`].
    pub(super) temporaries: Option<&'a Path>,
}

/// Writes the film. The parts have been checked.
pub(super) fn join_to(work: &Work, film: &Film<'_>, processes: Processes) -> Result<()> {
    let (began, output) = (Instant::now(), film.output);
    fits(work, output)?;
    let input = work.open_film()?;
    if hash::of_files(input.paths())?.0 != work.plan.film.hash {
        return Err(work.other_film(input.paths()));
    }
    let plan = &work.plan;
    let look = plan.options.enlarged(plan.write.scale);
    let info = input.info();
    let info = StreamInfo { size: scaled(info.size, plan.write.scale)?, ..info.clone() };
    let options = sink_options(work, &input, &look, film, processes)?;
    let sink = sink::create(output, &info, &options)?;
    if !work.quiet {
        sink.warnings().iter().for_each(terminal::warn);
    }
    let sink = Box::new(Repainted::new(sink, &look, info.size));
    let mut bar = Bar::new(Some(plan.frames), work.quiet);
    let open = || Ok(Parts::of(plan, &work.folder));
    let ended = pipeline::repaint(open, &Part::default(), sink, false, &mut bar, &Stop::default());
    bar.finish();
    let summary = ended?;
    if !work.quiet && !matches!(summary.ending, Ending::Closed) {
        let bytes =
            bytes_of(output).map_or_else(String::new, |bytes| format!(", {}", HumanBytes(bytes)));
        terminal::say(format_args!(
            "{}: {} frames of {} in {:.2} s{bytes}",
            output.display(),
            summary.frames,
            info.size,
            began.elapsed().as_secs_f64()
        ));
    }
    Ok(())
}

/// Checks that the film was planned for outputs such as `output`.
fn fits(work: &Work, output: &OsStr) -> Result<()> {
    let (plan, kind) = (&work.plan, Kind::of(output));
    let planned = plan.read.kind;
    if kind == planned {
        return Ok(());
    }
    let gif = [kind, planned].contains(&Kind::Gif);
    let why = if plan.film.hdr && [kind, planned].contains(&Kind::Video) {
        "it is HDR, which only video can say"
    } else if gif && plan.film.format == "gif" {
        "a GIF's shortest delays are shown for longer elsewhere"
    } else if gif && plan.options.error.is_some() && plan.options.edges != Edges::Hard {
        "--error is measured with the edges that it is painted with, and those of GIFs are hard"
    } else {
        return Ok(());
    };
    Err(Error::usage(format!(
        "the film was planned for outputs such as {}, not {}: {why}; plan it again with --for {}",
        planned.example(),
        output.display(),
        kind.example()
    )))
}

fn sink_options(
    work: &Work,
    input: &Input,
    look: &Options,
    film: &Film<'_>,
    processes: Processes,
) -> Result<SinkOptions> {
    let (write, read) = (&work.plan.write, &work.plan.read);
    let own = write.sound.as_ref().map(|path| {
        Sound::new(
            path,
            read.start.unwrap_or(Rational::ZERO),
            read.end.is_some() || read.frames.is_some(),
        )
    });
    let seams = write.svg_seams.as_deref().unwrap_or_default();
    Ok(SinkOptions {
        overwrite: film.overwrite,
        temporaries: film.temporaries.map(Path::to_owned),
        background: write.background,
        inputs: input.paths().to_vec(),
        video: VideoOptions {
            codec: write.codec.clone(),
            crf: write.crf,
            encoder_preset: write.encoder_preset.clone(),
            audio: write.audio,
            metadata: write.metadata,
            hdr: read.keep_hdr,
            ffmpeg_args: write.ffmpeg_args.clone(),
            ffmpeg: Ffmpeg { processes, ..work.ffmpeg.clone() },
            ..VideoOptions::default()
        },
        sound: own.or_else(|| input.sound().cloned()),
        look: look.clone(),
        seams: Seams::ALL.into_iter().find(|s| s.name() == seams).unwrap_or_default(),
        format: write.format.clone(),
        quality: write.lossy,
        grid: Grid::of_parts(write.vertex_grid).unwrap_or_default(),
        colour_error: write.colour_error,
        unfinished: work.unfinished.clone(),
        ..SinkOptions::default()
    })
}
