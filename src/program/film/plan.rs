//! `polyreel plan`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use polyreel::error::{Error, Result};
use polyreel::ffmpeg::{Ffmpeg, Processes};
use polyreel::film::plan::{Kind, Plan, Reading, VERSION, Writing, film_of};
use polyreel::film::survey::{Division, chunks_of, survey};
use polyreel::film::{hash, plan};
use polyreel::options::{Edges, Options};
use polyreel::pipeline::Stop;
use polyreel::source::{self, Input, SourceOptions};
use polyreel::stream::is_hdr;

use super::bar::Bar;
use super::source_options;
use crate::program::Outcome;
use crate::program::cli::{DivisionArgs, InputArgs, PlanArgs, RefusedArgs, VideoArgs, WriteArgs};
use crate::program::interrupt::Interrupt;
use crate::program::look::of_a_stream;
use crate::program::{record, terminal};

/// What pieces of split shots are. Measured: docs/films.md.
const CLOSE: &str = "close to a render of the whole film, not the same: 2 to 3 of 255 off on average, and where a \
                     piece begins the mesh jumps as at a cut";

/// What is asked for, before the film is looked at.
pub(super) struct Request<'a> {
    pub(super) input: &'a InputArgs,
    pub(super) options: Options,
    pub(super) write: Writing,
    pub(super) kind: Option<Kind>,
    pub(super) division: Division,
    /// Whether HDR stays HDR in video.
    pub(super) hdr: bool,
}

/// Plans a film.
pub(crate) fn plan(args: &PlanArgs) -> Result<Outcome> {
    refuse(&args.refused)?;
    let interrupt = Interrupt::listen(&Stop::default());
    let processes = interrupt.processes();
    let request = Request {
        input: &args.input,
        options: of_a_stream(args.look.options()?),
        write: writing(&args.write, &args.video, &args.input, processes.clone())?,
        kind: args.kind.as_deref().map(Kind::of_ending),
        division: division(&args.division),
        hdr: args.video.hdr,
    };
    if args.output.exists() && !args.write.overwrite {
        return Err(Error::output(
            &args.output,
            "exists already; give another name, or replace it with -y",
        ));
    }
    let plan = make(&request, processes, args.quiet)?;
    if plan.film.inputs.iter().any(|input| record::same_file(Path::new(input), &args.output)) {
        return Err(Error::output(&args.output, "is the film, too; give another name"));
    }
    record::put(&args.output, plan.to_text().as_bytes(), args.write.overwrite)?;
    if !args.quiet {
        report(&plan, &args.output);
    }
    Ok(Outcome::Done)
}

/// Refuses what cannot be done in parts.
fn refuse(args: &RefusedArgs) -> Result<()> {
    let refused = |what: &str, why: &str| {
        Err(Error::usage(format!("{what} and parts of a film do not go together: {why}")))
    };
    if args.budget.is_some() {
        return refused(
            "--budget",
            "a clock decides what a frame gets, and no two machines agree on that",
        );
    }
    if args.looped {
        return refused(
            "--loop",
            "the first frame goes on from the last, which is in another part",
        );
    }
    if args.replay.is_some() {
        return refused("--replay", "a report is of one run; plan with the options of that run");
    }
    Ok(())
}

fn division(args: &DivisionArgs) -> Division {
    let warm_up = args.split_long_shots.then_some(args.warm_up);
    Division { max_frames: args.max_frames.get(), warm_up }
}

/// How the film is to be written.
pub(super) fn writing(
    write: &WriteArgs,
    video: &VideoArgs,
    input: &InputArgs,
    processes: Processes,
) -> Result<Writing> {
    let video = video.options(input, processes)?;
    let usual = Writing::default();
    let sound = write.sound.as_deref().map(absolute).transpose()?;
    Ok(Writing {
        codec: video.codec,
        crf: video.crf,
        encoder_preset: video.encoder_preset,
        audio: video.audio,
        metadata: video.metadata,
        ffmpeg_args: video.ffmpeg_args,
        sound,
        background: write.background.map_or(usual.background, |colour| colour.0),
        scale: write.scale.unwrap_or(1.0),
        format: write.format.clone(),
        svg_seams: Some(write.svg_seams.name().to_owned()),
        lossy: write.lossy,
        vertex_grid: write.vertex_grid.parts(),
        colour_error: write.colour_error,
    })
}

fn absolute(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path)
        .map_err(|error| Error::input(path, format!("cannot be found: {error}")).caused_by(error))
}

/// The inputs as absolute names, which every machine that shares the folder understands.
fn named(inputs: &[OsString]) -> Result<Vec<String>> {
    let name = |input: &OsString| {
        let path = absolute(Path::new(input))?;
        let name = path.to_str().map(str::to_owned);
        name.ok_or_else(|| Error::input(&path, "a plan is text, and this name is none (UTF-8)"))
    };
    inputs.iter().map(name).collect()
}

/// Looks through the film, and plans it.
pub(super) fn make(request: &Request<'_>, processes: Processes, quiet: bool) -> Result<Plan> {
    let ffmpeg = request.input.options(processes).ffmpeg;
    let opened = Opened::open(request, &ffmpeg)?;
    let Opened { input, read, hdr, inputs } = opened;
    if !quiet {
        input.warnings().iter().for_each(terminal::warn);
    }
    let info = input.info().clone();
    let asked = asked(request, &inputs, &read);
    let paths = input.paths().to_vec();
    let content = std::thread::spawn(move || hash::of_files(&paths));
    let bar = Bar::new(info.frames, quiet);
    let adapted = adapted(&request.options, read.kind);
    let found = survey(
        input,
        &adapted,
        request.division,
        read.allow_truncated,
        &Stop::default(),
        &mut || bar.add(1),
    );
    bar.finish();
    let found = found?;
    if let Some(error) = &found.truncated {
        terminal::warn(format_args!("{error}; what came before is planned"));
    }
    let content = content.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
    let options = Options { edges: request.options.edges, ..found.options };
    Ok(Plan {
        polyreel: VERSION.to_owned(),
        film: film_of(&info, inputs, content, hdr),
        read,
        options,
        write: request.write.clone(),
        asked,
        frames: found.frames,
        chunks: chunks_of(&found.shots, request.division),
        shots: found.shots,
    })
}

/// The options by which the chain renders for an output of that `kind`.
pub(super) fn adapted(options: &Options, kind: Kind) -> Options {
    let edges = if kind == Kind::Gif { Edges::Hard } else { options.edges };
    Options { edges, ..options.clone() }
}

/// A film that is about to be planned.
struct Opened {
    input: Input,
    read: Reading,
    hdr: bool,
    inputs: Vec<String>,
}

impl Opened {
    fn open(request: &Request<'_>, ffmpeg: &Ffmpeg) -> Result<Self> {
        let args = request.input;
        let plain = args.options(ffmpeg.processes.clone());
        let (input, kind, hdr) = Self::recognise(args, request.kind, &plain)?;
        let read = reading(&plain, kind, request.hdr);
        let inputs = named(&args.inputs)?;
        let options = source_options(&read, ffmpeg.clone());
        // It was opened as video that keeps its HDR.
        let is_as_read = kind == Kind::Video && (read.keep_hdr || !hdr);
        let input = if is_as_read { input } else { source::open(&args.inputs, &options)? };
        Ok(Self { input, read, hdr, inputs })
    }

    /// The film as for video, what kind of output it is planned for, and whether it is HDR.
    fn recognise(
        args: &InputArgs,
        kind: Option<Kind>,
        plain: &SourceOptions,
    ) -> Result<(Input, Kind, bool)> {
        if let [one] = &args.inputs[..]
            && one == "-"
        {
            return Err(unrepeatable("standard input"));
        }
        let as_video = SourceOptions { browser_delays: true, ..plain.clone() };
        let input = source::open(&args.inputs, &as_video)?;
        let info = input.info();
        if info.still {
            return Err(Error::usage("one still picture is no film: polyreel render takes it"));
        }
        if !input.repeats() || info.live || input.paths().is_empty() {
            return Err(unrepeatable("a pipe, a stream or a camera"));
        }
        if info.format == "polyreel" {
            return Err(Error::usage(
                "a mesh stream is rendered already: polyreel render paints it anew",
            ));
        }
        let usual = if info.format == "gif" { Kind::Gif } else { Kind::Video };
        let hdr = info.colour.as_ref().is_some_and(is_hdr);
        Ok((input, kind.unwrap_or(usual), hdr))
    }
}

fn unrepeatable(what: &str) -> Error {
    Error::usage(format!("{what} can be read only once, and parts read it many times: name a file"))
}

/// A hash of all that was asked for.
fn asked(request: &Request<'_>, inputs: &[String], read: &Reading) -> String {
    let all = (inputs, read, &request.options, &request.write, request.division);
    hash::of_text(&serde_json::to_string(&all).expect("a request is plain data"))
}

/// The hash of a request for a film that has not been opened, for outputs of that `kind`.
pub(super) fn asked_now(request: &Request<'_>, kind: Kind) -> Result<String> {
    let read = reading(&request.input.options(Processes::default()), kind, request.hdr);
    Ok(asked(request, &named(&request.input.inputs)?, &read))
}

/// How a film is read that is opened with `options`, for outputs of that `kind`.
fn reading(options: &SourceOptions, kind: Kind, hdr: bool) -> Reading {
    let keep_hdr = hdr && kind == Kind::Video;
    let SourceOptions { start, end, frames, fps, max_size, max_memory, allow_truncated, .. } =
        *options;
    Reading { start, end, frames, fps, max_size, max_memory, allow_truncated, keep_hdr, kind }
}

fn report(plan: &plan::Plan, output: &Path) {
    let count =
        |n: usize, what: &str| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
    let longest = plan.chunks.iter().map(|chunk| chunk.frames).max().unwrap_or(0);
    terminal::say(format_args!(
        "{}: {} frames, {}, {} (0 to {}), the longest of {longest} frames",
        output.display(),
        plan.frames,
        count(plan.shots.len(), "shot"),
        count(plan.chunks.len(), "chunk"),
        plan.chunks.len() - 1,
    ));
    let near = plan.chunks.iter().filter(|chunk| !chunk.exact).count();
    if near > 0 {
        terminal::warn(format_args!("{} of split shots, {CLOSE}", count(near, "piece")));
    }
}
