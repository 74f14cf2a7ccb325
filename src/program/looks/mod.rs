//! `polyreel looks`: the source and every preset on it, as one labelled picture.

mod sheet;

use std::io::{IsTerminal, stderr};
use std::path::{Path, PathBuf};

use image::DynamicImage;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use polyreel::Renderer;
use polyreel::error::{Error, Result};
use polyreel::ffmpeg::Ffmpeg;
use polyreel::frame::{Frame, Rational};
use polyreel::options::{Options, PRESETS, STUDIES, Shape};
use polyreel::pipeline::Stop;
use polyreel::sink::{self, Picture, SinkOptions, is_still};
use polyreel::source::{self, Input, SourceOptions};
use polyreel::stream::{Span, StreamInfo};

use crate::program::Outcome;
use crate::program::cli::LooksArgs;
use crate::program::interrupt::Interrupt;
use crate::program::look::{preset, study};
use crate::program::progress::TICK;
use sheet::{Cell, Layout, tile};

/// Writes the contact sheet.
pub(crate) fn looks(args: &LooksArgs) -> Result<Outcome> {
    // Programs that read for us must not outlive us.
    let interrupt = Interrupt::listen(&Stop::default());
    check_output(&args.output)?;
    let looks = chosen(args)?;
    if let Some(threads) = args.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.get())
            .build_global()
            .map_err(|error| Error::thread("rendering", error))?;
    }
    let (info, paths, frames) = read(args, &interrupt)?;
    let counts = (looks.len() as u32 + 1, frames.len() as u32);
    let columns = args.columns.map(std::num::NonZeroU32::get);
    let layout = Layout::new(info.size, counts, args.tile, columns)?;
    let to = SinkOptions {
        overwrite: args.overwrite,
        inputs: paths,
        unfinished: interrupt.unfinished(),
        ..SinkOptions::default()
    };
    let still = StreamInfo { still: true, frames: Some(1), size: layout.size(), ..info.clone() };
    let mut sink = sink::create(&args.output, &still, &to)?;
    let bar = bar(looks.len() as u64, args.quiet);
    let mut cells = vec![source_cell(&frames, layout)];
    for (name, options) in looks {
        bar.set_message(crate::program::terminal::escape(&name).into_owned());
        cells.push(cell(name, options, &frames, layout)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let sheet = DynamicImage::from(layout.draw(&cells)).to_rgba8();
    let span = Span { start: Rational::ZERO, length: None };
    sink.write(Picture { frame: Frame::from_image(sheet)?, fills: Vec::new(), span }, None)?;
    sink.finish()?;
    Ok(Outcome::Done)
}

fn check_output(output: &Path) -> Result<()> {
    let extension = output.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if is_still(&extension) {
        return Ok(());
    }
    Err(Error::usage(format!(
        "{}: a contact sheet is one picture: name it sheet.png, or .jpg, .webp, .bmp, .tiff",
        output.display()
    )))
}

/// The looks to show, by their names: those that were asked for, or all.
fn chosen(args: &LooksArgs) -> Result<Vec<(String, Options)>> {
    if !args.presets.is_empty() {
        return args.presets.iter().map(|name| Ok((label(name), preset(name)?))).collect();
    }
    if args.studies {
        return STUDIES.iter().map(|s| Ok((s.name.to_owned(), study(s.name)?))).collect();
    }
    if !args.study.is_empty() {
        return args.study.iter().map(|name| Ok((name.clone(), study(name)?))).collect();
    }
    let all: Result<Vec<_>> =
        PRESETS.iter().map(|p| Ok((p.name.to_owned(), Options::preset(p.name)?))).collect();
    let mut all = all?;
    // First what one gets without any.
    all.sort_by_key(|(_, options)| *options != Options::default());
    Ok(all)
}

/// The name of a preset, or of a preset file without its folder and extension.
fn label(name: &str) -> String {
    if !name.ends_with(".toml") {
        return name.to_owned();
    }
    Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The frames to show, what is known of their stream, and the files that it is in.
fn read(args: &LooksArgs, interrupt: &Interrupt) -> Result<(StreamInfo, Vec<PathBuf>, Vec<Frame>)> {
    let starts: Vec<Option<Rational>> = match args.start.as_slice() {
        [] => vec![None],
        times => times.iter().copied().map(Some).collect(),
    };
    let mut frames = Vec::new();
    let mut known = None;
    for start in starts {
        let input = open(args, start, interrupt)?;
        let (info, paths) = (input.info().clone(), input.paths().to_vec());
        let Some(decoded) = input.start()?.next()? else {
            let at = start.map_or_else(String::new, |at| format!(" at {:.3} s", at.to_f64()));
            return Err(Error::input(&args.input, format!("has no frame{at} to look at")));
        };
        frames.push(decoded.frame);
        known.get_or_insert((info, paths));
    }
    let Some((info, paths)) = known else { return Err(Error::NoFrames) };
    Ok((info, paths, frames))
}

fn open(args: &LooksArgs, start: Option<Rational>, interrupt: &Interrupt) -> Result<Input> {
    let wanted = SourceOptions {
        start,
        frames: Some(1),
        max_size: args.max_size,
        max_memory: args.max_memory,
        ffmpeg: Ffmpeg { program: args.ffmpeg.clone(), processes: interrupt.processes() },
        to_sdr: true,
        to_bt709: true,
        ..SourceOptions::default()
    };
    let input = source::open(&[&args.input], &wanted)?;
    if args.start.len() > 1 && !input.repeats() {
        return Err(Error::usage(
            "what can be read only once has one frame to show: give one time to --start, or name a file",
        ));
    }
    Ok(input)
}

fn source_cell(frames: &[Frame], layout: Layout) -> Cell {
    let size = frames.first().map(|frame| frame.size().to_string());
    Cell {
        name: "source".to_owned(),
        remark: size.unwrap_or_default(),
        tiles: frames.iter().map(|frame| tile(frame, layout.tile)).collect(),
    }
}

/// The `frames`, each by itself, in the look of `options`.
fn cell(name: String, options: Options, frames: &[Frame], layout: Layout) -> Result<Cell> {
    // As of a still: no frame follows.
    let mut renderer = Renderer::new(&Options { coherence: 0.0, ..options })?;
    let (mut points, unit) = (0, if options.shape == Shape::Voronoi { "cells" } else { "points" });
    let tiles = frames.iter().map(|frame| {
        renderer.reset();
        let rendered = renderer.render(frame)?;
        points = rendered.mesh.seed_ids().count();
        Ok(tile(&rendered.picture, layout.tile))
    });
    let tiles = tiles.collect::<Result<Vec<_>>>()?;
    Ok(Cell { name, remark: format!("{points} {unit}"), tiles })
}

fn bar(looks: u64, quiet: bool) -> ProgressBar {
    let shown = !quiet && stderr().is_terminal();
    let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(looks), target);
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} looks, {msg}, {eta} left");
    bar.set_style(style.expect("the template is a fixed, sound one"));
    if shown {
        bar.enable_steady_tick(TICK);
    }
    bar
}
