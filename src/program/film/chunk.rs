//! `polyreel render --plan`: one chunk, in this process.

use std::ffi::OsStr;
use std::fs;
use std::io::Read;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use polyreel::error::{Error, Result};
use polyreel::film::part::{self, Stale};
use polyreel::film::plan::Chunk;
use polyreel::film::range::{Range, Seek};
use polyreel::pipeline::{self, Ending, Settings, Stop, Summary};
use polyreel::source::Source;

use super::bar::Bar;
use super::plan::adapted;
use super::{Work, all};
use crate::program::Outcome;
use crate::program::cli::RenderArgs;
use crate::program::interrupt::Interrupt;
use crate::program::terminal;

/// Renders what `args` ask for of a planned film.
pub(crate) fn render_parts(args: &RenderArgs, plan: &std::path::Path) -> Result<Outcome> {
    let film = &args.film;
    // A chunk that ends early is of no use: the first Ctrl-C ends the program.
    let interrupt = Interrupt::listen(&Stop::default());
    if film.until_input_ends {
        end_with_input(interrupt.clone());
    }
    let folder = args.output.clone().map(PathBuf::from);
    let ffmpeg = args.input.options(interrupt.processes()).ffmpeg;
    let work = Work::open(plan, folder, ffmpeg, &interrupt)?;
    let work = Work { film: film.film.clone(), quiet: args.run.quiet, ..work };
    make_folder(&work)?;
    if film.all {
        let jobs = film.jobs.unwrap_or_else(all::cores);
        all::render_all(&work, jobs, args.run.threads)?;
        return Ok(Outcome::Done);
    }
    let Some(chunk) = &film.chunk else {
        return Err(Error::usage("say which part of the plan to render: --chunk K, or --all"));
    };
    if film.jobs.is_some() {
        return Err(Error::usage("--jobs goes with --all: one chunk is one job"));
    }
    let chunk = chosen(&work, chunk)?;
    render_chunk(&work, &chunk, args.run.threads)?;
    Ok(Outcome::Done)
}

/// Ends the program with its standard input: whoever started it holds the other end.
fn end_with_input(interrupt: Interrupt) {
    std::thread::spawn(move || {
        let mut input = std::io::stdin();
        let mut nothing = [0; 64];
        while input.read(&mut nothing).is_ok_and(|read| read > 0) {}
        interrupt.end_at_once();
    });
}

/// Makes the folder of the parts.
pub(super) fn make_folder(work: &Work) -> Result<()> {
    fs::create_dir_all(&work.folder).map_err(|error| {
        Error::output(&work.folder, format!("cannot be made: {error}")).caused_by(error)
    })
}

/// The chunk that `asked` names: a number, or `env:NAME`.
fn chosen(work: &Work, asked: &str) -> Result<Chunk> {
    let (text, from) = match asked.strip_prefix("env:") {
        None => (asked.to_owned(), String::new()),
        Some(name) => {
            let value = std::env::var(name).map_err(|_| {
                Error::usage(format!(
                    "--chunk {asked}: there is no variable {name} in the environment"
                ))
            })?;
            (value, format!(" (from {name})"))
        }
    };
    let number: usize = text
        .trim()
        .parse()
        .map_err(|_| Error::usage(format!("--chunk {text}{from}: write a number, or env:NAME")))?;
    let chunks = &work.plan.chunks;
    chunks.get(number).cloned().ok_or_else(|| {
        Error::usage(format!(
            "there is no chunk {number}{from}: the plan's are 0 to {}",
            chunks.len() - 1
        ))
    })
}

/// Renders `chunk`, unless it is there.
pub(super) fn render_chunk(
    work: &Work,
    chunk: &Chunk,
    threads: Option<NonZeroUsize>,
) -> Result<()> {
    let path = part::meshes(&work.folder, chunk.chunk);
    match part::check(&work.plan, chunk, &work.folder) {
        Ok(()) => {
            if !work.quiet {
                terminal::say(format_args!("{}: is complete already", path.display()));
            }
            return Ok(());
        }
        Err(Stale::Missing) => {}
        Err(stale) => {
            if !work.quiet {
                terminal::say(format_args!("{}: {stale}; it is rendered anew", path.display()));
            }
            part::forget(chunk, &work.folder);
        }
    }
    let seek = Seek::default();
    let rendered = match attempt(work, chunk, threads, &seek) {
        // Where a seek went wrong nothing has been written.
        Err(_) if seek.missed.load(std::sync::atomic::Ordering::Relaxed) => {
            attempt(work, chunk, threads, &Seek { from_start: true, ..Seek::default() })
        }
        done => done,
    };
    let summary = rendered?;
    part::complete(&work.plan, chunk, &work.folder, &work.unfinished)?;
    if !work.quiet {
        let wall = summary.wall.as_secs_f64();
        let frames = chunk.frames;
        terminal::say(format_args!(
            "{}: {frames} frames in {wall:.2} s ({:.1} fps)",
            path.display(),
            summary.fps()
        ));
    }
    Ok(())
}

/// Renders `chunk` once, sought as `seek` says.
fn attempt(
    work: &Work,
    chunk: &Chunk,
    threads: Option<NonZeroUsize>,
    seek: &Seek,
) -> Result<Summary> {
    let input = work.open_for_chunk()?;
    let sink = part::create(&work.plan, chunk, &work.folder, input.info(), &work.unfinished)?;
    let settings = Settings {
        options: adapted(&work.plan.options, work.plan.read.kind),
        threads,
        ..Settings::default()
    };
    let mut bar = Bar::new(Some(chunk.frames), work.quiet);
    let start = || Ok(Box::new(Range::start(input, &work.plan, chunk, seek)?) as Box<dyn Source>);
    let ended = pipeline::run(start, sink, &settings, &mut bar, &Stop::default());
    bar.finish();
    let summary = ended.map_err(|error| match error {
        // The frame's number in the chunk says nothing to anybody.
        Error::Frame { source, .. } if matches!(*source, Error::Failed { .. }) => {
            named_film(work, *source)
        }
        other => other,
    })?;
    match summary.ending {
        Ending::Complete => Ok(summary),
        _ => Err(Error::output(part::meshes(&work.folder, chunk.chunk), "was not completed")),
    }
}

/// `error` as one of the film.
fn named_film(work: &Work, error: Error) -> Error {
    let film = work.inputs().into_iter().next().unwrap_or_default();
    Error::input(film, error.to_string())
}

/// The name of a chunk's file, for messages.
pub(super) fn name(work: &Work, chunk: &Chunk) -> String {
    let path = part::meshes(&work.folder, chunk.chunk);
    path.file_name().unwrap_or(OsStr::new("part")).to_string_lossy().into_owned()
}
