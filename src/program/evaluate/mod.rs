//! `polyreel evaluate`: the paper's tables on the user's own pictures.

mod csv;
mod page;

use std::path::{Path, PathBuf};

use crate::program::scores::clip::evaluate_clip;
use crate::program::scores::still::evaluate_still;
use crate::program::scores::summary::summaries;
use crate::program::scores::tables::{short_name, tables};
use crate::program::scores::thumbnail::thumbnail;
use crate::program::scores::{Evaluation, Failure, Plan, over_white};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use polyreel::error::{Error, Result};
use polyreel::ffmpeg::Processes;
use polyreel::frame::Frame;
use polyreel::options::{Options, Points};
use polyreel::source::{self, Input};

use crate::program::cli::EvaluateArgs;
use crate::program::{Outcome, print, record, terminal};

/// Bytes of all pictures of the page, about: more make a browser slow.
const PAGE_BYTES: f64 = 40e6;

/// Bytes of a pixel of a JPEG in base64, about.
const PIXEL_BYTES: f64 = 0.35;

/// The pictures of one input on the page.
struct Gallery {
    name: String,
    pictures: Vec<Shown>,
}

/// A picture on the page: what it shows, its figures, and a JPEG.
struct Shown {
    title: String,
    figures: String,
    jpeg: Vec<u8>,
}

/// Evaluates every input by itself.
pub(crate) fn evaluate(args: &EvaluateArgs) -> Result<Outcome> {
    let plan = plan(args)?;
    if args.input.inputs.iter().any(|input| input == "-") {
        return Err(Error::usage("evaluate reads files: name pictures, clips or folders of them"));
    }
    let files = source::files(&args.input.inputs)?;
    check_outputs(args, &files)?;
    if let Some(threads) = args.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.get())
            .build_global()
            .map_err(|error| Error::thread("evaluation", error))?;
    }
    let longest = longest_side(&plan, files.len());
    let mut work = Work {
        args,
        bar: bar(files.len() as u64, args.quiet),
        found: Evaluation { plan, stills: Vec::new(), clips: Vec::new(), failures: Vec::new() },
        galleries: Vec::new(),
        longest,
    };
    for file in &files {
        work.bar.set_message(short_name(file));
        if let Err(error) = work.one(file) {
            // Options that no input can be read with are the user's error, not the file's.
            if error.is_usage() && files.len() == 1 {
                return Err(error);
            }
            let message = error.to_string();
            work.bar.suspend(|| terminal::warn(format_args!("{message}; it is passed over")));
            work.found.failures.push(Failure { path: file.clone(), error: message });
        }
        work.bar.inc(1);
    }
    work.bar.finish_and_clear();
    let Work { found, galleries, .. } = work;
    write_all(args, &found, &galleries)?;
    match found.failures.len() {
        0 => Ok(Outcome::Done),
        n => Err(Error::input(
            found.failures[0].path.clone(),
            format!("could not be evaluated, {n} of {} inputs in all", files.len()),
        )),
    }
}

/// What is compared, as the arguments say.
fn plan(args: &EvaluateArgs) -> Result<Plan> {
    let options = args.look.options()?;
    let robustness = !args.no_robustness;
    if args.presets {
        return Ok(Plan::of_presets(options, robustness));
    }
    if args.look.points == Some(Points::Auto) {
        return Err(Error::usage(
            "evaluate compares methods at the same number of points: give --points N or N%; \
             render --points auto finds a number",
        ));
    }
    let study = args.look.study.as_deref();
    if args.studies || study.is_some() {
        let points = args.look.points.unwrap_or(Options::paper().points);
        let look = if study.is_some() { args.look.without_study()? } else { options };
        return Ok(Plan::of_studies(look, points, study, robustness));
    }
    if options.points == Points::Auto {
        return Err(Error::usage("the preset finds a number of points: give --points N or N%"));
    }
    Ok(Plan::of_methods(options, &args.chosen(), robustness))
}

/// The longest side of the pictures of `inputs` files, so that the page does not grow too large.
fn longest_side(plan: &Plan, inputs: usize) -> u32 {
    let pictures = inputs * (1 + plan.variants().count());
    let pixels = PAGE_BYTES / PIXEL_BYTES / pictures.max(1) as f64;
    // Of pictures in the proportions 3:2.
    ((pixels * 1.5).sqrt() as u32).clamp(320, 1280)
}

struct Work<'a> {
    args: &'a EvaluateArgs,
    bar: ProgressBar,
    found: Evaluation,
    galleries: Vec<Gallery>,
    /// Longest side of a picture on the page.
    longest: u32,
}

impl Work<'_> {
    fn one(&mut self, file: &Path) -> Result<()> {
        let input = source::open(&[file], &self.args.input.options(Processes::default()))?;
        let mut gallery = Gallery { name: short_name(file), pictures: Vec::new() };
        if input.info().still {
            self.still(file, input, &mut gallery)?;
        } else {
            self.clip(file, input, &mut gallery)?;
        }
        self.galleries.push(gallery);
        Ok(())
    }

    fn still(&mut self, file: &Path, input: Input, gallery: &mut Gallery) -> Result<()> {
        let size = input.info().size;
        let whole = source::open(&[file], &Default::default());
        let is_whole = whole.is_ok_and(|whole| whole.info().size == size);
        let bytes = std::fs::metadata(file).ok().filter(|_| is_whole).map(|file| file.len());
        let Some(decoded) = input.start()?.next()? else {
            return Err(Error::input(file, "has no frame to evaluate"));
        };
        let frame = decoded.frame;
        let (pages, longest) = (self.args.html.is_some(), self.longest);
        let mut shown = Ok(());
        let mut add = |title: &str, picture: &Frame| {
            if pages && shown.is_ok() {
                shown = show(gallery, title, picture, longest);
            }
        };
        add("source", &over_white(&frame));
        let scores =
            evaluate_still(file.to_owned(), &frame, bytes, &self.found.plan, &mut |variant, f| {
                add(&variant.to_string(), f);
            })?;
        shown?;
        let all = scores.methods.iter().chain(&scores.refined);
        for (shown, scores) in gallery.pictures.iter_mut().skip(1).zip(all) {
            shown.figures = page::figures(scores);
        }
        self.found.stills.push(scores);
        Ok(())
    }

    fn clip(&mut self, file: &Path, input: Input, gallery: &mut Gallery) -> Result<()> {
        let (pages, longest) = (self.args.html.is_some(), self.longest);
        let mut shown = Ok(());
        let mut frames = input.start()?;
        let bar = &self.bar;
        let mut count = 0;
        let scores = evaluate_clip(
            file.to_owned(),
            &mut *frames,
            &self.found.plan,
            &mut |variant, frame| {
                if pages && shown.is_ok() {
                    let title = variant.map_or_else(|| "source".to_owned(), |v| v.to_string());
                    shown = show(gallery, &title, frame, longest);
                }
            },
            &mut || {
                count += 1;
                bar.set_message(format!("{}, frame {count}", short_name(file)));
            },
        )?;
        shown?;
        if scores.frames == 0 {
            return Err(Error::input(file, "has no frame to evaluate"));
        }
        self.found.clips.push(scores);
        Ok(())
    }
}

fn show(gallery: &mut Gallery, title: &str, frame: &Frame, longest: u32) -> Result<()> {
    let jpeg = thumbnail(frame, longest)?;
    gallery.pictures.push(Shown { title: title.to_owned(), figures: String::new(), jpeg });
    Ok(())
}

fn bar(files: u64, quiet: bool) -> ProgressBar {
    use std::io::IsTerminal;
    let shown = !quiet && std::io::stderr().is_terminal();
    let target = if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(files), target);
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg}, {eta} left");
    bar.set_style(style.expect("the template is a fixed, sound one"));
    bar
}

/// Whether `path` stands for standard output.
fn is_stdout(path: &Path) -> bool {
    path == Path::new("-")
}

fn outputs(args: &EvaluateArgs) -> impl Iterator<Item = &PathBuf> {
    [&args.json, &args.csv, &args.markdown, &args.html].into_iter().flatten()
}

/// Checks, before any work is done, that outputs replace neither a file nor one another.
fn check_outputs(args: &EvaluateArgs, files: &[PathBuf]) -> Result<()> {
    let all: Vec<_> = outputs(args).collect();
    let same = |a: &Path, b: &Path| {
        a == b || matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
    };
    for (i, path) in all.iter().enumerate() {
        if all[..i].contains(path) {
            return Err(Error::usage(format!("{} is named for two outputs", path.display())));
        }
        if is_stdout(path) {
            continue;
        }
        if files.iter().any(|file| same(file, path)) {
            return Err(Error::usage(format!("{} is an input: name another file", path.display())));
        }
        if path.exists() && !args.overwrite {
            return Err(Error::output(*path, "is there already; -y replaces it"));
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if folder.is_some_and(|folder| !folder.is_dir()) || path.is_dir() {
            return Err(Error::output(*path, "is not a place for a file; check the folder's name"));
        }
    }
    Ok(())
}

fn write_all(args: &EvaluateArgs, found: &Evaluation, galleries: &[Gallery]) -> Result<()> {
    let (short, long) = (summaries(found), tables(found));
    if !args.quiet && !outputs(args).any(|path| is_stdout(path)) {
        let text: Vec<_> = short.iter().map(|table| table.to_text()).collect();
        print(text.join("\n").as_bytes())?;
    }
    let tables = [short, long].concat();
    if let Some(path) = &args.json {
        let value = serde_json::json!({ "evaluation": found, "tables": tables });
        let mut json = serde_json::to_vec_pretty(&value).expect("plain data becomes JSON");
        json.push(b'\n');
        write(path, &json)?;
    }
    if let Some(path) = &args.csv {
        write(path, csv::csv(found).as_bytes())?;
    }
    if let Some(path) = &args.markdown {
        let text: Vec<_> = tables.iter().map(|table| table.to_markdown()).collect();
        write(path, text.join("\n").as_bytes())?;
    }
    if let Some(path) = &args.html {
        write(path, page::page(found, &tables, galleries).as_bytes())?;
    }
    Ok(())
}

/// Writes a file, or standard output.
fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    if is_stdout(path) {
        return print(bytes).map(|_| ());
    }
    // Files that may not be replaced were refused before the work began.
    record::put(path, bytes, true)
}
