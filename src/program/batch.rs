//! `polyreel render --batch`: each input by itself, to a folder, under its own name.

use std::collections::{HashMap, HashSet};
use std::ffi::{OsStr, OsString};
use std::io::{IsTerminal, stderr};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use polyreel::error::{Error, Result};
use polyreel::ffmpeg::Processes;
use polyreel::pattern::Pattern;
use polyreel::pipeline::{Ending, FrameReport, OutputReport, Stop, Summary};
use polyreel::sink::is_still;
use polyreel::sink::place::Made;
use polyreel::source::{self, SourceOptions, is_called_picture};
use polyreel::stream::StreamInfo;

use crate::program::cli::{RenderArgs, RunArgs};
use crate::program::embed::Watcher;
use crate::program::interrupt::Interrupt;
use crate::program::progress::TICK;
use crate::program::render::{render_to, say_summary};
use crate::program::{Outcome, terminal};

/// Whether `args`, which are no sequence, ask for a batch without saying so: pictures of several sizes, or animations
/// among them, to a folder.
pub(crate) fn is_meant(args: &RenderArgs, output: &OsStr) -> bool {
    let run = &args.run;
    if run.report.is_some() || run.replay.is_some() || run.preview || !is_folder(output) {
        return false;
    }
    let Ok(files) = source::files(&args.input.inputs) else { return false };
    let wanted = SourceOptions { max_size: None, ..args.input.options(Processes::default()) };
    let pictures = files.iter().filter(|file| is_called_picture(file));
    let opened: Vec<StreamInfo> = pictures
        .filter_map(|file| source::open(&[file], &wanted).ok())
        .map(|input| input.info().clone())
        .collect();
    let Some(first) = opened.first() else { return false };
    opened.iter().any(|info| info.size != first.size)
        || (files.len() > 1 && opened.iter().any(|info| !info.still))
}

/// Renders every input to a file of its name in the folder `output`. One that fails is reported, and the others are
/// done all the same.
pub(crate) fn render_batch(
    args: &RenderArgs,
    output: &OsStr,
    stop: &Stop,
    interrupt: &Interrupt,
) -> Result<Outcome> {
    check(args, output)?;
    let began = Instant::now();
    let files = source::files(&args.input.inputs)?;
    let folder = Path::new(output);
    // It is removed again if it stays empty.
    let _made = if folder.is_dir() { None } else { Made::new(folder, &interrupt.unfinished())? };
    let mut progress = Progress::new(&args.run, files.len() as u64);
    let mut failed: Option<&Path> = None;
    let (mut done, mut failures) = (0, 0);
    for (file, stem) in files.iter().zip(stems(&files)) {
        if interrupt.happened() {
            break;
        }
        progress.begin(file);
        if let Some(other) = stem.taken_by {
            progress.warns(&format!(
                "{} is written as {}: its name is that of {}, too",
                file.display(),
                stem.name.display(),
                files[other].display()
            ));
        }
        match render_one(args, file, &folder.join(&stem.name), stop, interrupt, &mut progress) {
            Ok(()) => done += 1,
            // What was under way is given up.
            Err(_) if interrupt.happened() => break,
            Err(error) => {
                progress.say(&format!("error: {error}; it is passed over"));
                failures += 1;
                failed = failed.or(Some(file));
            }
        }
        progress.bar.inc(1);
    }
    progress.bar.finish_and_clear();
    let early = if interrupt.happened() { ", stopped early" } else { "" };
    if !args.run.quiet {
        terminal::say(format_args!(
            "{}: {done} of {} inputs in {:.2} s{early}",
            folder.display(),
            files.len(),
            began.elapsed().as_secs_f64()
        ));
    }
    match failed {
        _ if interrupt.happened() => Ok(Outcome::Interrupted),
        None => Ok(Outcome::Done),
        Some(first) => Err(Error::input(
            first,
            format!("could not be rendered, {failures} of {} inputs in all", files.len()),
        )),
    }
}

/// Whether `output` is a folder, or can be the name of one.
fn is_folder(output: &OsStr) -> bool {
    let path = Path::new(output);
    let ends = output.as_encoded_bytes().last();
    let is_named = ends.is_some_and(|&b| std::path::is_separator(char::from(b))) || path.is_dir();
    let special = output == "-" || output == "null:" || Pattern::parse(output).is_some();
    is_named || (path.extension().is_none() && !special)
}

/// Refuses what would fail for every input.
fn check(args: &RenderArgs, output: &OsStr) -> Result<()> {
    args.look.options()?;
    let shown = Path::new(output).display();
    if !is_folder(output) {
        return Err(Error::usage(format!(
            "{shown}: a batch is written to a folder, under the names of its inputs: write -o out/"
        )));
    }
    // Without its slash, after which nothing is a file.
    let name: PathBuf = Path::new(output).components().collect();
    if name.exists() && !name.is_dir() {
        return Err(Error::usage(format!("{shown} is a file, where a folder is wanted")));
    }
    if args.input.inputs.iter().any(|input| input == "-") {
        return Err(Error::usage("standard input has no name to write to: name files"));
    }
    let format = format(args);
    if !is_still(format) && format != "svg" {
        return Err(Error::usage(format!(
            "--format {format} is no format of pictures: png, svg, jpg, webp, bmp or tiff"
        )));
    }
    Ok(())
}

fn format(args: &RenderArgs) -> &str {
    args.write.format.as_deref().unwrap_or("png")
}

/// Renders `file` to `target` with the extension of what it becomes.
fn render_one(
    args: &RenderArgs,
    file: &Path,
    target: &Path,
    stop: &Stop,
    interrupt: &Interrupt,
    watcher: &mut dyn Watcher,
) -> Result<()> {
    let input = source::open(&[file], &args.input.options(interrupt.processes()))?;
    let extension = match input.info() {
        info if info.still || info.frames == Some(1) => format(args),
        _ if is_called_picture(file) => "gif",
        _ => "mp4",
    };
    let mut output = OsString::from(target);
    output.push(".");
    output.push(extension);
    render_to(args, &[file.into()], &output, stop, interrupt, watcher)
}

/// The name of an output, without its extension.
struct Stem {
    name: OsString,
    /// The input whose name it would have been.
    taken_by: Option<usize>,
}

/// A name for what becomes of each of `files`: its own, or with a number where an earlier file has the same. Case
/// does not count, as for many file systems.
fn stems(files: &[PathBuf]) -> Vec<Stem> {
    let own: Vec<OsString> =
        files.iter().map(|file| file.file_stem().unwrap_or_default().to_owned()).collect();
    let key = |name: &OsStr| name.to_string_lossy().to_lowercase();
    let keys: Vec<String> = own.iter().map(|name| key(name)).collect();
    let mut taken: HashSet<String> = keys.iter().cloned().collect();
    let mut first = HashMap::new();
    let stems = own.into_iter().zip(&keys).enumerate().map(|(index, (name, name_key))| {
        let owner = *first.entry(name_key).or_insert(index);
        if owner == index {
            return Stem { name, taken_by: None };
        }
        let mut numbered = (2u32..).map(|number| {
            let mut numbered = name.clone();
            numbered.push(format!("-{number}"));
            numbered
        });
        let free = numbered.find(|name| taken.insert(key(name)));
        Stem { name: free.unwrap_or(name), taken_by: Some(owner) }
    });
    stems.collect()
}

/// Reports the progress of a batch on the terminal.
struct Progress<'a> {
    run: &'a RunArgs,
    bar: ProgressBar,
    name: String,
    frames: u64,
}

impl<'a> Progress<'a> {
    fn new(run: &'a RunArgs, inputs: u64) -> Self {
        let shown = !run.quiet && stderr().is_terminal();
        let target =
            if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(inputs), target);
        let style = ProgressStyle::with_template("{wide_bar} {pos}/{len}, {msg}, {eta} left");
        bar.set_style(style.expect("the template is a fixed, sound one"));
        if shown {
            bar.enable_steady_tick(TICK);
        }
        Self { run, bar, name: String::new(), frames: 0 }
    }

    fn begin(&mut self, file: &Path) {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        self.name = terminal::escape(&name).into_owned();
        self.frames = 0;
        self.bar.set_message(self.name.clone());
    }

    fn say(&self, text: &str) {
        self.bar.suspend(|| terminal::say(text));
    }
}

impl Watcher for Progress<'_> {
    fn begins(&mut self, _: &StreamInfo) {}

    fn frame_done(&mut self, _: &FrameReport) -> ControlFlow<()> {
        self.frames += 1;
        if self.frames > 1 {
            self.bar.set_message(format!("{}, frame {}", self.name, self.frames));
        }
        ControlFlow::Continue(())
    }

    fn warns(&mut self, text: &str) {
        if !self.run.quiet {
            self.bar.suspend(|| terminal::warn(text));
        }
    }

    fn ended(&mut self, info: &StreamInfo, written: &OutputReport, summary: &Summary) {
        if self.run.verbose || matches!(summary.ending, Ending::Truncated(_)) {
            self.bar.suspend(|| say_summary(self.run, info, written, summary));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_kept_and_clashes_numbered() {
        let files = ["a/x.jpg", "b/x.png", "x-2.bmp", "B.png", "b.gif", "no"].map(PathBuf::from);
        let stems = stems(&files);
        let names: Vec<_> = stems.iter().map(|stem| stem.name.to_str().expect("text")).collect();
        assert_eq!(names, ["x", "x-3", "x-2", "B", "b-2", "no"]);
        let taken: Vec<_> = stems.iter().map(|stem| stem.taken_by).collect();
        assert_eq!(taken, [None, Some(0), None, None, Some(3), None]);
    }

    #[test]
    fn folders_are_told_from_files() {
        for (name, expected) in
            [("out/", true), ("out", true), ("src", true), ("-", false), ("null:", false)]
        {
            assert_eq!(is_folder(OsStr::new(name)), expected, "{name}");
        }
        assert!(!is_folder(OsStr::new("out.gif")) && !is_folder(OsStr::new("out_%04d")));
    }
}
