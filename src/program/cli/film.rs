//! The options of films in parts: `polyreel plan`, `polyreel join`, and those of `polyreel render`.

use std::ffi::OsString;
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::PathBuf;

use clap::Args;

use super::{InputArgs, VideoArgs, WriteArgs};
use crate::program::look::LookArgs;

const PLAN_EXAMPLES: &str = "Examples:
  polyreel plan film.mp4 -o film.plan.json --crf 20
  polyreel render --plan film.plan.json --all --jobs 8
  polyreel join film.plan.json -o lowpoly.mp4

On many machines, each renders some of the chunks: polyreel render --plan film.plan.json --chunk 7 -o parts/";

#[derive(Debug, Args)]
#[command(override_usage = "polyreel plan [OPTIONS] <FILM> -o <PLAN.json>")]
#[command(after_help = PLAN_EXAMPLES)]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// Where to write the plan
    #[arg(short, long, value_name = "PLAN.json", help_heading = "Plan")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) division: DivisionArgs,
    /// What join will write, by its ending: HDR, the delays of GIFs and hard edges depend on it [default:
    /// gif for a GIF, else mp4]
    #[arg(long = "for", value_name = "ENDING", help_heading = "Plan")]
    pub(crate) kind: Option<String>,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    #[command(flatten)]
    pub(crate) video: VideoArgs,
    #[command(flatten)]
    pub(crate) look: LookArgs,
    /// Say nothing unless something is wrong
    #[arg(short, long, help_heading = "Run")]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) refused: RefusedArgs,
}

/// Where a film is divided.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Plan")]
pub(crate) struct DivisionArgs {
    /// Frames of a chunk at most; a shot that has more is a chunk by itself
    #[arg(long, value_name = "N", default_value = "240")]
    pub(crate) max_frames: NonZeroU64,
    /// Split such shots: the pieces are close to a render of the whole film, not the same
    #[arg(long)]
    pub(crate) split_long_shots: bool,
    /// Frames that are rendered before a piece of such a shot, to come close
    #[arg(long, value_name = "N", default_value = "8", requires = "split_long_shots")]
    pub(crate) warm_up: u64,
}

/// What cannot be done in parts, so that it is refused in words.
#[derive(Debug, Args)]
pub(crate) struct RefusedArgs {
    #[arg(long, hide = true, num_args = 0..=1)]
    pub(crate) budget: Option<Option<OsString>>,
    #[arg(long = "loop", hide = true)]
    pub(crate) looped: bool,
    #[arg(long, hide = true, num_args = 0..=1)]
    pub(crate) replay: Option<Option<OsString>>,
}

/// What `polyreel render` does with a film in parts.
#[derive(Debug, Args)]
#[command(next_help_heading = "Films in parts")]
pub(crate) struct FilmArgs {
    /// Render parts of the film that 'polyreel plan' planned, as it says; -o names the folder for them
    /// [default: parts/ beside the plan]
    #[arg(long, value_name = "PLAN.json")]
    #[arg(conflicts_with_all = ["inputs", "start", "end", "frames", "fps", "max_size", "allow_truncated"])]
    #[arg(conflicts_with_all = ["WriteArgs", "VideoArgs", "LookArgs"])]
    #[arg(conflicts_with_all = ["budget", "replay", "looped", "report", "preview", "resume", "batch"])]
    pub(crate) plan: Option<PathBuf>,
    /// The chunk to render, from 0, or env:NAME for the number in a variable of the environment:
    /// env:SLURM_ARRAY_TASK_ID
    #[arg(long, value_name = "K", requires = "plan")]
    pub(crate) chunk: Option<String>,
    /// Render all chunks that are not there yet
    #[arg(long, requires = "plan", conflicts_with = "chunk")]
    pub(crate) all: bool,
    /// Processes that render chunks at the same time [default: one a core; with --resume one]
    #[arg(long, value_name = "N")]
    pub(crate) jobs: Option<NonZeroUsize>,
    /// Where the film is, if it is not where it was planned
    #[arg(long, value_name = "FILE", requires = "plan")]
    pub(crate) film: Option<PathBuf>,
    /// Render in parts that are kept in a folder beside the output until it is complete: run the same
    /// command again after a crash, and it goes on
    #[arg(long, conflicts_with_all = ["replay", "report", "preview", "batch"])]
    pub(crate) resume: bool,
    /// End when standard input does: set by --all for the processes that it starts
    #[arg(long, hide = true)]
    pub(crate) until_input_ends: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  polyreel join film.plan.json -o lowpoly.mp4")]
pub(crate) struct JoinArgs {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    pub(crate) plan: PathBuf,
    /// Where to write the film: any output of 'polyreel render'
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: OsString,
    /// Where the parts are [default: parts/ beside the plan]
    #[arg(long, value_name = "DIR")]
    pub(crate) parts: Option<PathBuf>,
    /// Where the film is, if it is not where it was planned
    #[arg(long, value_name = "FILE")]
    pub(crate) film: Option<PathBuf>,
    /// Replace an output that is there already
    #[arg(short = 'y', long)]
    pub(crate) overwrite: bool,
    /// The ffmpeg program that reads and writes video [default: the one on the search path]
    #[arg(long, value_name = "PATH")]
    pub(crate) ffmpeg: Option<PathBuf>,
    /// Say nothing unless something is wrong
    #[arg(short, long)]
    pub(crate) quiet: bool,
}
