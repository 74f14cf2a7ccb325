//! The command line: commands, and their options in groups that commands share.

mod evaluate;
mod film;
mod looks;
mod page;
mod preview;

use std::ffi::OsString;
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use polyreel::error::{Error, Result};
use polyreel::ffmpeg::{Ffmpeg, Processes};
use polyreel::frame::Rational;
use polyreel::geom::Size;
use polyreel::mesh_stream::Grid;
use polyreel::options::Colour;
use polyreel::sink::ffmpeg::VideoOptions;
use polyreel::source::SourceOptions;
use polyreel::svg::Seams;

use crate::program::amount;
use crate::program::budget::{Budget, budget};
use crate::program::look::{LookArgs, one_of};

pub(crate) use evaluate::EvaluateArgs;
pub(crate) use film::{DivisionArgs, FilmArgs, JoinArgs, PlanArgs, RefusedArgs};
pub(crate) use looks::LooksArgs;
pub(crate) use page::paged;
pub(crate) use preview::PreviewArgs;

/// Turns pictures, GIFs and video into low-poly art, frame by frame.
#[derive(Debug, Parser)]
#[command(name = "polyreel", version, max_term_width = 100)]
#[command(after_help = "Exit codes: 0 done, 1 failed, 2 usage, 130 stopped by Ctrl-C.")]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render pictures or an animation as low-poly art
    Render(Box<RenderArgs>),
    /// Show pictures, video or a camera as low-poly art in a live window
    Preview(Box<PreviewArgs>),
    /// Show every preset on a picture or clip, as a labelled contact sheet
    Looks(LooksArgs),
    /// Plan a film that is rendered in parts: find its shots
    Plan(Box<PlanArgs>),
    /// Join the parts of a planned film, and add its sound
    Join(JoinArgs),
    /// Compare methods on pictures and clips: the paper's tables
    Evaluate(Box<EvaluateArgs>),
    /// Show what each stage sees, as PNGs
    Inspect(Box<InspectArgs>),
    /// Tell size, frames, rate, duration, alpha and audio of an input
    Info(InfoArgs),
    /// List the presets, or print one as a file to begin your own with
    #[command(after_help = "Example:\n  polyreel presets sketch > mine.toml\n  \
                            polyreel render portrait.png -o sketch.png --preset mine.toml")]
    Presets {
        /// The preset to print
        #[arg(value_name = "NAME")]
        name: Option<String>,
    },
    /// Print a completion script for a shell
    #[command(
        after_help = "Example:\n  polyreel completions bash > ~/.local/share/bash-completion/completions/polyreel"
    )]
    Completions {
        /// The shell
        #[arg(value_name = "SHELL")]
        shell: clap_complete::Shell,
    },
    /// Print the manual page
    #[command(after_help = "Example:\n  polyreel man render | man -l -")]
    Man {
        /// The command whose page is wanted [default: the program as a whole]
        #[arg(value_name = "COMMAND")]
        command: Option<String>,
    },
}

const RENDER_EXAMPLES: &str = "Examples:
  polyreel render portrait.png -o lowpoly.png
  polyreel render dance.gif -o dance-lowpoly.gif --points 1500 --loop
  polyreel render frames/ -o out/
  polyreel render pictures/ -o out/ --batch --format jpg
  polyreel render 'shots/*.jpg' -o shots.gif --fps 12 --outline=white
  polyreel render clip.mp4 -o lowpoly.mp4 --start 0:05 --end 0:10
  ffmpeg -i clip.mp4 -f yuv4mpegpipe - | polyreel render - -o - | ffplay -";

#[derive(Debug, Args)]
#[command(override_usage = "polyreel render [OPTIONS] <INPUT>... -o <OUTPUT>")]
#[command(after_help = RENDER_EXAMPLES)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    // Not required as far as clap goes: whoever forgets -o gets a better answer than clap's.
    /// Where to write, by its name: a picture, a GIF, a video (.mp4, .webm, .mkv, .mov, .ts, .avi, .flv, .ogv,
    /// .y4m), numbered pictures (out_%04d.png), a folder (out/) for PNGs, a named pipe, - for y4m on standard output
    /// (--format for others), an address (rtmp://, srt://, udp://), a playlist (.m3u8), a device (/dev/video9), or
    /// null: to write nothing
    #[arg(short, long, value_name = "OUTPUT", help_heading = "Output")]
    pub(crate) output: Option<OsString>,
    /// Render each input by itself, to a folder, under its own name; what cannot be read is reported and passed over.
    /// Understood by itself where pictures of several sizes, or animations among them, go to a folder
    #[arg(long, help_heading = "Output")]
    #[arg(conflicts_with_all = ["report", "replay", "preview", "plan", "resume", "sound"])]
    pub(crate) batch: bool,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    #[command(flatten)]
    pub(crate) video: VideoArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
    #[command(flatten)]
    pub(crate) film: FilmArgs,
    // The last: it ends in the paper's parameters.
    #[command(flatten)]
    pub(crate) look: LookArgs,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Writes regions, candidates, grid, seeds, mesh and lowpoly, the last two before \
                        refinement as well (mesh-before, lowpoly-before), and the maps saliency, \
                        entropy (white is 8 bits), diffused and edges, each as a PNG of the picture's \
                        size; the maps also as exact floats (.npy). convergence.csv and .svg tell the \
                        error after every step of refinement (MSE over all channels, colours \
                        premultiplied where there is alpha); with --refine 0 that is one point, and \
                        before is the same as after.\n\nExample:\n  polyreel inspect portrait.png -o stages/"
)]
pub(crate) struct InspectArgs {
    /// The picture; of an animation or a video, its first frame
    #[arg(value_name = "IMAGE")]
    pub(crate) image: OsString,
    /// The folder to write to; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Shrink the picture until its longest side has at most PX pixels [default: its own size]
    #[arg(long, value_name = "PX")]
    pub(crate) max_size: Option<u32>,
    /// Memory that decoding may take: larger pictures are refused; 512M, 4G, or bytes [default: 1G]
    #[arg(long, value_name = "SIZE", value_parser = amount::bytes)]
    pub(crate) max_memory: Option<u64>,
    /// Replace files that are there already
    #[arg(short = 'y', long)]
    pub(crate) overwrite: bool,
    /// The ffmpeg program that reads video [default: the one on the search path]
    #[arg(long, value_name = "PATH")]
    pub(crate) ffmpeg: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) look: LookArgs,
}

#[derive(Debug, Args)]
#[command(after_help = "Of what is on standard input the beginning is read, and is gone then.\n\n\
                        Example:\n  polyreel info dance.gif --json")]
pub(crate) struct InfoArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// What is read, and how much of it.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Input")]
pub(crate) struct InputArgs {
    /// A picture, GIF or video, several pictures, a folder of them, a quoted glob ('shots/*.png'), a
    /// printf pattern (shot%03d.png), a URL, a camera (/dev/video0), a named pipe, or - for video on standard input
    #[arg(value_name = "INPUT", required = true, help_heading = None::<&str>)]
    pub(crate) inputs: Vec<OsString>,
    /// Leave out what comes before TIME: 1.5, 500ms, 1:30 [default: from the beginning]
    #[arg(long, value_name = "TIME", value_parser = amount::time)]
    pub(crate) start: Option<Rational>,
    /// Leave out what comes at TIME or later [default: to the end]
    #[arg(long, value_name = "TIME", value_parser = amount::time)]
    pub(crate) end: Option<Rational>,
    /// Read at most N frames [default: all]
    #[arg(long, value_name = "N")]
    pub(crate) frames: Option<NonZeroU64>,
    /// Frames per second of a sequence of pictures: 12, 29.97, 24000/1001 [default: 25]
    #[arg(long, value_name = "RATE", value_parser = amount::rate)]
    fps: Option<Rational>,
    /// Shrink frames until their longest side has at most PX pixels [default: their own size]
    #[arg(long, value_name = "PX")]
    pub(crate) max_size: Option<u32>,
    /// Memory that decoding may take: larger pictures are refused; 512M, 4G, or bytes [default: 1G]
    #[arg(long, value_name = "SIZE", value_parser = amount::bytes)]
    max_memory: Option<u64>,
    /// Keep what can be read of an input that breaks off or is damaged [default: fail]
    #[arg(long)]
    pub(crate) allow_truncated: bool,
    /// The ffmpeg program that reads and writes video [default: the one on the search path]
    #[arg(long, value_name = "PATH")]
    ffmpeg: Option<PathBuf>,
}

impl InputArgs {
    pub(crate) fn options(&self, processes: Processes) -> SourceOptions {
        SourceOptions {
            start: self.start,
            end: self.end,
            frames: self.frames.map(NonZeroU64::get),
            fps: self.fps,
            max_size: self.max_size,
            max_memory: self.max_memory,
            allow_truncated: self.allow_truncated,
            looped: false,
            ffmpeg: self.ffmpeg(processes),
            to_sdr: false,
            to_bt709: false,
            browser_delays: false,
        }
    }

    fn ffmpeg(&self, processes: Processes) -> Ffmpeg {
        Ffmpeg { program: self.ffmpeg.clone(), processes }
    }

    /// How video is encoded where only the program to do it is given.
    #[cfg(feature = "preview")]
    pub(crate) fn video_options(&self, processes: Processes) -> VideoOptions {
        VideoOptions { ffmpeg: self.ffmpeg(processes), ..VideoOptions::default() }
    }
}

/// How the output is written.
#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct WriteArgs {
    /// Replace an output that is there already
    #[arg(short = 'y', long)]
    pub(crate) overwrite: bool,
    /// What shows through transparent pixels in formats that have none, JPEG for one [default: white]
    #[arg(long, value_name = "COLOUR")]
    pub(crate) background: Option<Colour>,
    /// Format of the output, whatever its name: of pictures that go to a folder png, svg, jpg, webp, bmp, tiff; of a
    /// video an extension (ts, mkv) or a muxer of ffmpeg (mpegts) [default: by the name; in a folder png]
    #[arg(long, value_name = "NAME")]
    pub(crate) format: Option<String>,
    /// Quality of JPEG, and of WebP in place of lossless, 1 to 100 [default: JPEG 90, WebP lossless]
    #[arg(long, value_name = "QUALITY", value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(crate) lossy: Option<u8>,
    /// Draw from the mesh at S times the size: 2 is twice as wide, and crisp [default: 1]
    #[arg(long, value_name = "S", value_parser = scale)]
    pub(crate) scale: Option<f64>,
    /// Take the sound from FILE [default: from the input]
    #[arg(long, value_name = "FILE")]
    pub(crate) sound: Option<PathBuf>,
    /// What keeps the ground from showing between the facets of an SVG: facets that reach under each
    /// other, a thin line around each, or nothing
    #[arg(long, value_name = "NAME", default_value = "underlap", value_parser = one_of(Seams::ALL, Seams::name))]
    pub(crate) svg_seams: Seams,
    /// Vertices of .polyreel and .html stand on a grid of N lines a pixel, a power of two: 256 loses
    /// nothing, 4 takes a fifth fewer bytes
    #[arg(long, value_name = "N", default_value = "256", value_parser = grid)]
    pub(crate) vertex_grid: Grid,
    /// Colours of .polyreel and .html may be off by N of 255, 0 to 16: 2 takes a third fewer bytes of
    /// a clip
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u8).range(..=16))]
    pub(crate) colour_error: u8,
}

impl WriteArgs {
    /// The size of the output for an input of `size`.
    ///
    /// # Errors
    /// When that is too large.
    pub(crate) fn scaled(&self, size: Size) -> Result<Size> {
        scaled(size, self.scale.unwrap_or(1.0))
    }
}

/// The size of an output that is `scale` times as large as `size`.
///
/// # Errors
/// When that is too large.
pub(crate) fn scaled(size: Size, scale: f64) -> Result<Size> {
    let side = |side: u32| (f64::from(side) * scale).round().max(1.0) as u32;
    let scaled = Size::new(side(size.width), side(size.height));
    polyreel::frame::check_size(scaled)?;
    Ok(scaled)
}

/// A factor for a size.
fn scale(text: &str) -> std::result::Result<f64, String> {
    let scale = text.parse::<f64>().ok().filter(|scale| (0.05..=64.0).contains(scale));
    scale.ok_or_else(|| format!("{text} is no factor from 0.05 to 64"))
}

/// A number of lines a pixel.
fn grid(text: &str) -> std::result::Result<Grid, String> {
    let grid = text.parse().ok().and_then(Grid::of_parts);
    grid.ok_or_else(|| format!("{text} is none of 1, 2, 4, 8, 16, 32, 64, 128 and 256"))
}

/// How video is encoded.
#[derive(Debug, Args)]
#[command(next_help_heading = "Video output (.mp4, .webm, .mkv, .mov ...)")]
pub(crate) struct VideoArgs {
    /// The codec: h264, h265, vp8, vp9, av1, prores, or an encoder of ffmpeg by its name [default:
    /// h264, in .webm vp9]
    #[arg(long, value_name = "NAME")]
    codec: Option<String>,
    /// Constant quality in the codec's own measure, smaller is better [default: 18 for h264, what
    /// looks alike for others]
    #[arg(long, value_name = "N")]
    crf: Option<u32>,
    /// Effort, by x264's names: ultrafast to placebo [default: the encoder's own]
    #[arg(long, value_name = "NAME")]
    encoder_preset: Option<String>,
    /// Leave the sound out [default: copied if the container takes it, else encoded again]
    #[arg(long)]
    no_audio: bool,
    /// Leave out title, date, chapters, timecode, and languages and titles of tracks [default: kept]
    #[arg(long)]
    no_metadata: bool,
    /// Keep HDR as HDR: HEVC or AV1 of 10 bits, with its tags [default: its tones become SDR]
    #[arg(long)]
    pub(crate) hdr: bool,
    /// More options for ffmpeg's output, in one word: '-tune animation -b:a 96k' [default: none]
    #[arg(long, value_name = "ARGS", allow_hyphen_values = true)]
    ffmpeg_args: Option<String>,
}

impl VideoArgs {
    pub(crate) fn options(&self, input: &InputArgs, processes: Processes) -> Result<VideoOptions> {
        let ffmpeg_args = self.ffmpeg_args.as_deref().map(amount::words).transpose();
        Ok(VideoOptions {
            codec: self.codec.clone(),
            crf: self.crf,
            encoder_preset: self.encoder_preset.clone(),
            audio: !self.no_audio,
            metadata: !self.no_metadata,
            hdr: self.hdr,
            ffmpeg_args: ffmpeg_args.map_err(Error::Usage)?.unwrap_or_default(),
            ffmpeg: input.ffmpeg(processes),
            ..VideoOptions::default()
        })
    }
}

/// How the work is done and reported.
#[derive(Debug, Args)]
#[command(next_help_heading = "Run")]
pub(crate) struct RunArgs {
    /// Threads that work inside a frame; the bytes are the same for any number [default: one a core; at most 256]
    #[arg(long, value_name = "N", value_parser = amount::threads)]
    pub(crate) threads: Option<NonZeroUsize>,
    /// Time for each frame, 16ms, 0.5s, or auto: as long as a frame of the source is shown. Detail is
    /// chosen so that every stage keeps within it; spare time goes to refinement, up to --refine
    /// [default: none]
    #[arg(long, value_name = "TIME", value_parser = budget)]
    pub(crate) budget: Option<Budget>,
    /// Give every frame the detail that it had in the run of this report: the same bytes again, from the
    /// same input and options
    #[arg(long, value_name = "REPORT.json", conflicts_with = "budget")]
    pub(crate) replay: Option<PathBuf>,
    /// Let the end lead into the beginning, for GIFs and clips that play round and round: the input is
    /// rendered twice, and what is written is the second time, which goes on from the mesh that the
    /// first ended with. Files only
    #[arg(long = "loop")]
    pub(crate) looped: bool,
    /// Write what was done, in sum and for every frame, as JSON; replaces an older report
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    /// Show the render in a window as it goes; to close it is to stop, with an output of what was done
    #[arg(long)]
    pub(crate) preview: bool,
    /// Say nothing unless something is wrong
    #[arg(short, long, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Tell the settings, and the time of each stage
    #[arg(short, long)]
    pub(crate) verbose: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;
    use polyreel::options::{Options, Points, Target};

    fn look(args: &[&str]) -> Result<Options, String> {
        let args = ["polyreel", "render", "in.png", "-o", "out.png"].iter().chain(args);
        let cli = Cli::try_parse_from(args).map_err(|error| error.to_string())?;
        let Command::Render(args) = cli.command else { panic!("a render was asked for") };
        args.look.options().map_err(|error| error.to_string())
    }

    #[test]
    fn the_definitions_are_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn what_is_given_wins_over_the_preset() {
        assert_eq!(look(&[]), Ok(Options::default()));
        let expected = Options { points: Points::Count(90), clusters: 5, ..Options::paper() };
        let given = ["--preset", "paper", "--points", "90", "--clusters", "5"];
        assert_eq!(look(&given), Ok(expected));
        assert!(look(&["--preset", "none-such"]).expect_err("no such preset").contains("paper"));
    }

    #[test]
    fn a_target_takes_the_place_of_steps() {
        let error = Some(Target::Psnr(30.0));
        let expected = Options { points: Points::Auto, error, ..Options::default() };
        assert_eq!(look(&["--error", "30dB", "--points", "auto"]), Ok(expected));
    }

    #[test]
    fn an_outline_may_have_a_colour() {
        let colour = |args: &[&str]| look(args).expect("parses").outline.map(|colour| colour.0);
        assert_eq!(colour(&[]), None);
        assert_eq!(colour(&["--outline"]), Some([0, 0, 0, 255]));
        assert_eq!(colour(&["--outline=white"]), Some([255; 4]));
    }

    #[test]
    fn wrong_values_are_refused() {
        for args in [
            &["--points", "0"][..],
            &["--points", "many"],
            &["--points", "10", "--hex-density", "0.001"],
            &["--method", "magic"],
            &["--thresholds", "1,2"],
            &["--outline=blurple"],
            &["--fps", "0"],
            &["--frames", "0"],
            &["--threads", "0"],
            &["-q", "-v"],
            &["--error", "30"],
            &["--error", "ssim:1.5"],
            &["--error", "30dB", "--refine", "9"],
        ] {
            assert!(look(args).is_err(), "{args:?}");
        }
    }
}
