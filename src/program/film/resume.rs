//! `polyreel render --resume`: plan, parts and join in one command.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use polyreel::error::{Error, Result};
use polyreel::ffmpeg::Ffmpeg;
use polyreel::film::hash;
use polyreel::film::plan::{Kind, Plan};
use polyreel::film::survey::Division;
use polyreel::pipeline::Stop;
use polyreel::source;

use super::join::{self, Film};
use super::plan::{Request, asked_now, make, writing};
use super::{Work, all, chunk, source_options};
use crate::program::Outcome;
use crate::program::cli::RenderArgs;
use crate::program::interrupt::Interrupt;
use crate::program::look::of_a_stream;
use crate::program::{record, terminal};

/// Frames of a part at most: what is lost when a run is killed.
const MAX_FRAMES: u64 = 240;

/// Renders a film in parts, going on where a run before ended.
pub(crate) fn resume(args: &RenderArgs, output: &OsStr) -> Result<Outcome> {
    refuse(args, output)?;
    let interrupt = Interrupt::listen(&Stop::default());
    let processes = interrupt.processes();
    let folder = folder_of(output);
    let request = Request {
        input: &args.input,
        options: of_a_stream(args.look.options()?),
        write: writing(&args.write, &args.video, &args.input, processes.clone())?,
        kind: Some(Kind::of(output)),
        division: Division { max_frames: MAX_FRAMES, warm_up: None },
        hdr: args.video.hdr,
    };
    let ffmpeg = args.input.options(processes.clone()).ffmpeg;
    let known = known(&folder, &request, &ffmpeg);
    // A folder for this output says that a run for it was begun, which perhaps ended only just after the output was
    // complete.
    let overwrite = args.write.overwrite || known.is_some();
    if !overwrite && Path::new(output).is_file() {
        return Err(Error::output(
            output,
            "exists already; give another name, or replace it with -y",
        ));
    }
    let (path, quiet) = (folder.join("plan.json"), args.run.quiet);
    match known {
        Some(_) if !quiet => {
            terminal::say(format_args!("{}: goes on with what is there", folder.display()));
        }
        Some(_) => {}
        None => {
            fs::create_dir_all(&folder).map_err(|error| {
                Error::output(&folder, format!("cannot be made: {error}")).caused_by(error)
            })?;
            let plan = make(&request, processes.clone(), quiet)?;
            record::put_durably(&path, plan.to_text().as_bytes())?;
        }
    }
    let work = Work::open(&path, Some(folder.clone()), ffmpeg, &interrupt)?;
    let work = Work { quiet, ..work };
    chunk::make_folder(&work)?;
    let jobs = args.film.jobs.unwrap_or(NonZeroUsize::MIN);
    all::render_all(&work, jobs, args.run.threads)?;
    // A run that is killed while it joins leaves nothing outside the folder of parts. A link may lead to another disk.
    let temporaries = (!Path::new(output).is_symlink()).then_some(folder.as_path());
    let film = Film { output, overwrite, temporaries };
    join::join_to(&work, &film, processes)?;
    remove(&work);
    Ok(Outcome::Done)
}

/// Refuses what cannot be done in parts.
fn refuse(args: &RenderArgs, output: &OsStr) -> Result<()> {
    let why = if args.run.budget.is_some() {
        "--budget: a clock decides what a frame gets, and that is lost with the run"
    } else if args.run.looped {
        "--loop: the first frame goes on from the last"
    } else if output == "-" || output == "null:" {
        "an output that is no file"
    } else {
        return Ok(());
    };
    Err(Error::usage(format!("--resume renders in parts, and does not go with {why}")))
}

/// Where the parts of a film for `output` are kept.
fn folder_of(output: &OsStr) -> PathBuf {
    let text = output.to_string_lossy();
    let name = text.trim_end_matches(std::path::is_separator);
    let mut folder =
        if name.len() == text.len() { output.to_owned() } else { OsString::from(name) };
    folder.push(".parts");
    PathBuf::from(folder)
}

/// The plan that is in `folder`, if it is of what is asked for now, and of the film as it is now.
fn known(folder: &Path, request: &Request<'_>, ffmpeg: &Ffmpeg) -> Option<Plan> {
    let path = folder.join("plan.json");
    if !path.exists() {
        return None;
    }
    let found = Plan::read(&path).ok().filter(|plan| {
        asked_now(request, plan.read.kind).is_ok_and(|asked| asked == plan.asked)
            && source::open(&request.input.inputs, &source_options(&plan.read, ffmpeg.clone()))
                .and_then(|input| hash::of_files(input.paths()))
                .is_ok_and(|(hash, _)| hash == plan.film.hash)
    });
    if found.is_none() {
        let folder = folder.display();
        terminal::say(format_args!(
            "{folder}: is of another film, other options or another version; the film is planned anew"
        ));
    }
    found
}

/// Removes the parts, which are no longer needed, and what killed runs have left.
fn remove(work: &Work) {
    // What cannot be removed does no harm. Files of others stay.
    for entry in fs::read_dir(&work.folder).into_iter().flatten().flatten() {
        if is_ours(&entry.file_name().to_string_lossy()) {
            let _ = fs::remove_file(entry.path());
        }
    }
    let _ = fs::remove_dir(&work.folder);
}

/// Whether a file of that `name` is a plan, a part or a temporary file.
fn is_ours(name: &str) -> bool {
    let number = name.strip_suffix(".polyreel").or_else(|| name.strip_suffix(".json"));
    let is_part = number.is_some_and(|number| number.bytes().all(|byte| byte.is_ascii_digit()));
    name == "plan.json" || name.starts_with(".polyreel-") || is_part
}
