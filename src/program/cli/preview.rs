//! The options of `polyreel preview`.

use std::num::NonZeroUsize;

use clap::Args;

use super::InputArgs;
use crate::program::amount;
use crate::program::budget::{Budget, budget};
use crate::program::look::LookArgs;

const PREVIEW_EXAMPLES: &str =
    "A file plays at its own speed, round after round; of a camera or a stream \
the newest frame is shown. Press h in the window for its keys.\n\nExamples:
  polyreel preview clip.mp4
  polyreel preview /dev/video0 --method hslp --max-size 640
  ffmpeg -i clip.mp4 -f yuv4mpegpipe - | polyreel preview -";

#[derive(Debug, Args)]
#[command(override_usage = "polyreel preview [OPTIONS] <INPUT>...")]
#[command(after_help = PREVIEW_EXAMPLES)]
// A build without the window only says so.
#[cfg_attr(not(feature = "preview"), allow(dead_code))]
pub(crate) struct PreviewArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// Size of the window at first, by that of the picture: 1, 0.5, 2 [default: what suits the display]
    #[arg(long, value_name = "FACTOR", value_parser = amount::factor, help_heading = "Window")]
    pub(crate) scale: Option<f64>,
    /// Time for each frame: 33ms, 0.5s, or auto, as long as a frame of the source is shown. Detail is
    /// chosen so that every stage keeps within it [default: auto]
    #[arg(long, value_name = "TIME", value_parser = budget, help_heading = "Run")]
    pub(crate) budget: Option<Budget>,
    /// Files play round and round with one mesh anyway; here for whoever knows it from render
    #[arg(long = "loop", help_heading = "Run")]
    pub(crate) looped: bool,
    /// Threads that work inside a frame [default: one a core; at most 256]
    #[arg(long, value_name = "N", value_parser = amount::threads, help_heading = "Run")]
    pub(crate) threads: Option<NonZeroUsize>,
    // The last: it ends in the paper's parameters.
    #[command(flatten)]
    pub(crate) look: LookArgs,
}
