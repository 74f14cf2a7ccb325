//! `polyreel render`: input, pipeline, output, and what there is to say of it.

mod summary;

use std::ffi::{OsStr, OsString};
use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use polyreel::error::{Error, Result};
use polyreel::frame::Rational;
use polyreel::options::{Options, Points};
use polyreel::pipeline::{
    self, Controls, DetailPolicy, FrameReport, InputReport, Observer, OutputReport, Report, Script,
    Settings, Stop,
};
use polyreel::refine::RefineOptions;
use polyreel::sink::ffmpeg::VideoOptions;
use polyreel::sink::repainted::Repainted;
use polyreel::sink::{self, Sink, SinkOptions};
use polyreel::source::Sound;
use polyreel::source::{self, Input, SourceOptions};
use polyreel::stream::{StreamInfo, is_hdr};

use crate::program::Outcome;
use crate::program::batch::{is_meant, render_batch};
use crate::program::cli::RenderArgs;
use crate::program::embed::Watcher;
use crate::program::film;
use crate::program::interrupt::Interrupt;
use crate::program::look::of_a_stream;
use crate::program::preview::RenderWindow;
use crate::program::progress::Progress;
use crate::program::record::Record;
use crate::program::remark::remarks;
use crate::program::repaint::repaint;
use crate::program::terminal;

use summary::faceless;
pub(crate) use summary::{fell_short, say_summary};

/// Renders the input to the output, and reports on the terminal.
pub(crate) fn render(args: &RenderArgs) -> Result<Outcome> {
    if let Some(plan) = &args.film.plan {
        return film::render_parts(args, plan);
    }
    if args.film.resume {
        let output = args.output.as_deref().ok_or_else(|| no_output(&args.input.inputs))?;
        return film::resume(args, output);
    }
    if args.film.jobs.is_some() {
        return Err(Error::usage("--jobs is for films in parts: it goes with --all or --resume"));
    }
    let stop = Stop::default();
    let interrupt = Interrupt::listen(&stop);
    let output = args.output.as_deref().ok_or_else(|| no_output(&args.input.inputs))?;
    if args.batch {
        return render_batch(args, output, &stop, &interrupt);
    }
    let mut progress = Progress::new(&args.run).waiting_for(first_step(args));
    if let Err(error) = render_for(args, &stop, &interrupt, &mut progress) {
        // Pictures of several sizes are no sequence.
        let batch = matches!(error, Error::Input { .. }) && is_meant(args, output);
        return if batch { render_batch(args, output, &stop, &interrupt) } else { Err(error) };
    }
    Ok(if interrupt.happened() { Outcome::Interrupted } else { Outcome::Done })
}

/// What goes on until the first frame is done.
fn first_step(args: &RenderArgs) -> &'static str {
    match args.look.options() {
        Ok(options) if options.points == Points::Auto && options.error.is_some() => {
            "finding the fewest points that reach --error"
        }
        Ok(options) if options.error.is_some() => {
            "refining the first frame until it reaches --error"
        }
        _ => "rendering the first frame",
    }
}

/// Renders the input to the output. All that there is to say is said to `watcher`.
pub(crate) fn render_for(
    args: &RenderArgs,
    stop: &Stop,
    interrupt: &Interrupt,
    watcher: &mut dyn Watcher,
) -> Result<()> {
    let output = args.output.as_deref().ok_or_else(|| no_output(&args.input.inputs))?;
    render_to(args, &args.input.inputs, output, stop, interrupt, watcher)
}

/// As [`render_for`], of other inputs to another output.
pub(crate) fn render_to(
    args: &RenderArgs,
    inputs: &[OsString],
    output: &OsStr,
    stop: &Stop,
    interrupt: &Interrupt,
    watcher: &mut dyn Watcher,
) -> Result<()> {
    let format = args.write.format.as_deref();
    let to_video = output == "null:" || sink::is_video(output, format);
    let to_gif = format.map_or_else(|| has_extension(output, "gif"), |format| format == "gif");
    let wanted = SourceOptions {
        looped: args.run.looped,
        to_sdr: !(to_video && args.video.hdr),
        to_bt709: !to_video,
        browser_delays: !to_gif,
        ..args.input.options(interrupt.processes())
    };
    let input = source::open(inputs, &wanted);
    if let Some(meshes) = input.as_ref().ok().and_then(Input::take_meshes) {
        return repaint(args, meshes, output, stop, interrupt, watcher);
    }
    let mut options = args.look.options()?;
    let input = input?;
    let info = input.info().clone();
    if info.still {
        // Nothing comes after it: --refine STEPS means exactly that number.
        options.coherence = 0.0;
    } else {
        options = of_a_stream(options);
    }
    let record = record_of(args, input.paths(), output, interrupt)?;
    let controls = Controls::new(options.clone())?;
    let window = args.run.preview.then(|| RenderWindow::open(inputs, &info, controls.clone()));
    let window = window.transpose()?;
    let sink_options = sink_options(args, &options, &input, interrupt)?;
    let sink = create_sink(args, output, &info, &options, &sink_options)?;
    sink.needs().check(&options)?;
    sink.needs().adapt(&mut options);
    let remarks = remarks(&args.look, info.size, to_gif);
    let mut warnings = [input.warnings(), sink.warnings(), &remarks].concat();
    if wanted.to_sdr && info.colour.as_ref().is_some_and(is_hdr) {
        warnings.push(HDR_STAYS.to_owned());
    }
    warnings.iter().for_each(|warning| watcher.warns(warning));
    if args.run.verbose {
        input.notes().iter().for_each(terminal::say);
        terminal::say(settings_line(&options, args));
    }
    let settings = Settings {
        options: options.clone(),
        controls: Some(controls),
        detail_policy: detail_policy(args, &options, &info)?,
        threads: args.run.threads,
        live: info.live && sink.needs().live,
        allow_truncated: args.input.allow_truncated,
    };
    let sink = watcher.taps(sink);
    let mut frames = Frames::begin(watcher, &info, record.is_some());
    interrupt.begin();
    let start = move || input.start();
    let ended = match window {
        None => pipeline::run(start, sink, &settings, &mut frames, stop),
        Some(window) => {
            let sink = window.watch(sink);
            window.run(stop, &interrupt.processes(), &mut frames, |observer| {
                pipeline::run(start, sink, &settings, observer, stop)
            })
        }
    };
    let per_frame = frames.end();
    let summary = ended?;
    if let (Some(target), Some(least)) = (settings.options.error, summary.likeness)
        && let Some(warning) = fell_short(target, summary.short, least)
    {
        watcher.warns(&warning);
        warnings.push(warning);
    }
    if let Some(warning) = faceless(summary.faceless, summary.frames) {
        watcher.warns(&warning);
        warnings.push(warning);
    }
    let written = OutputReport {
        path: output.to_string_lossy().into_owned(),
        size: info.size,
        bytes: bytes_of(output),
        warnings,
    };
    watcher.ended(&info, &written, &summary);
    if let Some(record) = record {
        let input = InputReport::new(inputs, info);
        record.write(&Report::new(input, written, options, &summary, per_frame))?;
    }
    Ok(())
}

/// Passes the frames of a run to a watcher, and keeps their reports on request: about 200 bytes for each frame.
pub(crate) struct Frames<'a> {
    watcher: &'a mut dyn Watcher,
    reports: Option<Vec<FrameReport>>,
}

impl<'a> Frames<'a> {
    /// Informs `watcher` that frames of `info` follow.
    pub(crate) fn begin(watcher: &'a mut dyn Watcher, info: &StreamInfo, keep: bool) -> Self {
        watcher.begins(info);
        Self { watcher, reports: keep.then(Vec::new) }
    }

    /// Informs it that no more follow. Returns the reports that were kept.
    pub(crate) fn end(self) -> Vec<FrameReport> {
        self.watcher.frames_end();
        self.reports.unwrap_or_default()
    }
}

impl Observer for Frames<'_> {
    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()> {
        if let Some(reports) = &mut self.reports {
            reports.push(report.clone());
        }
        self.watcher.frame_done(report)
    }
}

/// What is said of HDR that cannot become SDR.
const HDR_STAYS: &str = "the input is HDR, and this ffmpeg has not the filters zscale and tonemap that would convert \
    it: its colours are those of HDR in 8 bits, and look dull";

fn has_extension(output: &OsStr, wanted: &str) -> bool {
    Path::new(output).extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}

/// What decides the detail: a budget, a former run, or nothing but the options.
fn detail_policy(args: &RenderArgs, options: &Options, info: &StreamInfo) -> Result<DetailPolicy> {
    if let Some(path) = &args.run.replay {
        if info.live {
            return Err(Error::usage("what is live never comes again: replay a file"));
        }
        let script = Script::read(path)?;
        script.check(options)?;
        return Ok(DetailPolicy::Replay(Arc::new(script)));
    }
    let Some(budget) = args.run.budget else { return Ok(DetailPolicy::Options) };
    let time = budget.time(info)?;
    // Of a single picture nothing is known before it, and nothing comes after it.
    Ok(if info.still { DetailPolicy::Options } else { DetailPolicy::Budget(time) })
}

fn sink_options(
    args: &RenderArgs,
    options: &Options,
    input: &Input,
    interrupt: &Interrupt,
) -> Result<SinkOptions> {
    let gives_way = RefineOptions::next(options, input.info().size).steps > 0;
    let written = write_options(args, interrupt)?;
    Ok(SinkOptions {
        inputs: input.paths().to_vec(),
        video: VideoOptions { gives_way, ..written.video },
        sound: sound(args).or_else(|| input.sound().cloned()),
        look: options.clone(),
        ..written
    })
}

/// What the command line says of writing, whatever the input.
pub(crate) fn write_options(args: &RenderArgs, interrupt: &Interrupt) -> Result<SinkOptions> {
    let defaults = SinkOptions::default();
    Ok(SinkOptions {
        overwrite: args.write.overwrite,
        background: args.write.background.map_or(defaults.background, |colour| colour.0),
        video: args.video.options(&args.input, interrupt.processes())?,
        seams: args.write.svg_seams,
        grid: args.write.vertex_grid,
        colour_error: args.write.colour_error,
        format: args.write.format.clone(),
        quality: args.write.lossy,
        unfinished: interrupt.unfinished(),
        ..defaults
    })
}

/// The sink for `output`, behind one that paints at another size where that is asked for.
fn create_sink(
    args: &RenderArgs,
    output: &OsStr,
    info: &StreamInfo,
    options: &Options,
    sink_options: &SinkOptions,
) -> Result<Box<dyn Sink>> {
    let Some(scale) = args.write.scale.filter(|&scale| scale != 1.0) else {
        return sink::create(output, info, sink_options);
    };
    let info = StreamInfo { size: args.write.scaled(info.size)?, ..info.clone() };
    let look = options.enlarged(scale);
    let sink_options = SinkOptions { look: look.clone(), ..sink_options.clone() };
    let sink = sink::create(output, &info, &sink_options)?;
    Ok(Box::new(Repainted::new(sink, &look, info.size)))
}

/// The sound of `--sound`.
pub(crate) fn sound(args: &RenderArgs) -> Option<Sound> {
    let path = args.write.sound.as_ref()?;
    let start = args.input.start.unwrap_or(Rational::ZERO);
    Some(Sound::new(path, start, args.input.end.is_some() || args.input.frames.is_some()))
}

/// The length of the file `output`, if it is one.
pub(crate) fn bytes_of(output: &OsStr) -> Option<u64> {
    let file = std::fs::metadata(output).ok().filter(|file| file.is_file())?;
    (output != "-").then_some(file.len())
}

pub(crate) fn record_of(
    args: &RenderArgs,
    inputs: &[PathBuf],
    output: &OsStr,
    interrupt: &Interrupt,
) -> Result<Option<Record>> {
    let Some(path) = &args.run.report else { return Ok(None) };
    let taken: Vec<_> = inputs.iter().cloned().chain([PathBuf::from(output)]).collect();
    Record::create(path, &taken, interrupt.unfinished()).map(Some)
}

/// What to answer when `-o` was not given: often it was only forgotten before the last name.
fn no_output(inputs: &[OsString]) -> Error {
    let missed = match inputs {
        [_, .., last] => Some(last).filter(|last| looks_like_output(last)),
        _ => None,
    };
    Error::usage(match missed {
        Some(last) => format!("no output is named; did you mean -o {}?", last.display()),
        None => "no output is named; add -o OUTPUT, for instance -o lowpoly.png".to_owned(),
    })
}

fn looks_like_output(name: &OsStr) -> bool {
    let path = Path::new(name);
    let folder = name.as_encoded_bytes().ends_with(b"/");
    name == "-" || (!path.exists() && (path.extension().is_some() || folder))
}

/// One line with everything that decides the bytes.
fn settings_line(options: &Options, args: &RenderArgs) -> String {
    let json = serde_json::to_value(options).expect("options are plain data");
    let fields = json.as_object().into_iter().flatten();
    let mut line = fields.fold("settings".to_owned(), |mut line, (name, value)| {
        let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        // Writing to a string cannot fail.
        let _ = write!(line, " {name}={value}");
        line
    });
    let threads = args.run.threads.map_or_else(|| "auto".to_owned(), |n| n.to_string());
    let _ = write!(line, " threads={threads}");
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_forgotten_o_is_recognised() {
        let said = |names: &[&str]| {
            no_output(&names.iter().map(OsString::from).collect::<Vec<_>>()).to_string()
        };
        assert!(said(&["in.png", "none/out.gif"]).contains("did you mean -o none/out.gif?"));
        assert!(said(&["in.png", "none/%04d.png"]).contains("did you mean -o none/%04d.png?"));
        assert!(said(&["-", "-"]).contains("did you mean -o -?"));
        assert!(!said(&["none.png"]).contains("did you mean"));
        // Two inputs that are there are two inputs.
        assert!(!said(&["none.png", "Cargo.toml"]).contains("did you mean"));
    }
}
