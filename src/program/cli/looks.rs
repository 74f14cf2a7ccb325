//! The options of `polyreel looks`.

use std::ffi::OsString;
use std::num::{NonZeroU32, NonZeroUsize};
use std::path::PathBuf;

use clap::Args;
use polyreel::frame::Rational;

use crate::program::amount;

#[derive(Debug, Args)]
#[command(
    after_help = "Each tile is rendered at the input's own size and shrunk for the sheet.\n\nExamples:
  polyreel looks portrait.png -o sheet.png
  polyreel looks clip.mp4 -o sheet.png --start 0:05,0:12
  polyreel looks portrait.png -o sheet.jpg --presets crystal,sketch,mine.toml"
)]
pub(crate) struct LooksArgs {
    /// A picture, GIF or video
    #[arg(value_name = "INPUT")]
    pub(crate) input: OsString,
    /// The picture to write: sheet.png, .jpg, .webp, .bmp, .tiff
    #[arg(short, long, value_name = "SHEET")]
    pub(crate) output: PathBuf,
    /// The presets and preset files to show [default: all presets, and the look without one]
    #[arg(long, value_name = "NAME|FILE.toml,...", value_delimiter = ',')]
    pub(crate) presets: Vec<String>,
    /// Show the studies of these names: earlier systems (see 'polyreel presets')
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', conflicts_with_all = ["presets", "studies"])]
    pub(crate) study: Vec<String>,
    /// Show all studies in place of the presets
    #[arg(long, conflicts_with = "presets")]
    pub(crate) studies: bool,
    /// Show the frames at these times: 1.5, 500ms, 1:30 [default: the first]
    #[arg(long, value_name = "TIME,...", value_parser = amount::time, value_delimiter = ',')]
    pub(crate) start: Vec<Rational>,
    /// Longest side of a tile in pixels, 48 to 2048
    #[arg(long, value_name = "PX", default_value_t = 420)]
    #[arg(value_parser = clap::value_parser!(u32).range(48..=2048))]
    pub(crate) tile: u32,
    /// Tiles in a row [default: what makes a sheet of three by two]
    #[arg(long, value_name = "N")]
    pub(crate) columns: Option<NonZeroU32>,
    /// Shrink the input until its longest side has at most PX pixels [default: its own size]
    #[arg(long, value_name = "PX")]
    pub(crate) max_size: Option<u32>,
    /// Memory that decoding may take: larger pictures are refused; 512M, 4G, or bytes [default: 1G]
    #[arg(long, value_name = "SIZE", value_parser = amount::bytes)]
    pub(crate) max_memory: Option<u64>,
    /// Replace a sheet that is there already
    #[arg(short = 'y', long)]
    pub(crate) overwrite: bool,
    /// The ffmpeg program that reads video [default: the one on the search path]
    #[arg(long, value_name = "PATH")]
    pub(crate) ffmpeg: Option<PathBuf>,
    /// Threads that work inside a frame [default: one a core; at most 256]
    #[arg(long, value_name = "N", value_parser = amount::threads)]
    pub(crate) threads: Option<NonZeroUsize>,
    /// Show no bar
    #[arg(short, long)]
    pub(crate) quiet: bool,
}
