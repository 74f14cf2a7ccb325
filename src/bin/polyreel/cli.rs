//! The command line: commands, and their options in groups that commands share.

use std::fmt::Display;
use std::num::{NonZeroU64, NonZeroUsize};
use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use polyreel::error::{Error, Result};
use polyreel::frame::Rational;
use polyreel::options::{
    CellPercentiles, Colour, FrontEnd, Method, Options, Points, Quality, Target, Thresholds,
};
use polyreel::sink::ffmpeg::VideoOptions;
use polyreel::source::SourceOptions;

use crate::amount;

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
    /// Compare methods on pictures and clips: the paper's tables
    Evaluate(Box<EvaluateArgs>),
    /// Show what each stage sees, as PNGs
    Inspect(Box<InspectArgs>),
    /// Tell size, frames, rate, duration, alpha and audio of an input
    Info(InfoArgs),
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
  polyreel render dance.gif -o dance-lowpoly.gif --points 1500
  polyreel render frames/ -o out/
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
    /// Where to write, by its name: a picture, a GIF, a video (.mp4, .webm, .mkv, .mov, .y4m), numbered
    /// pictures (out_%04d.png), a folder (out/) for PNGs, - for y4m on standard output, or null: to
    /// write nothing
    #[arg(short, long, value_name = "OUTPUT", help_heading = "Output")]
    pub(crate) output: Option<String>,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    #[command(flatten)]
    pub(crate) video: VideoArgs,
    #[command(flatten)]
    pub(crate) look: LookArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Writes regions, candidates, grid, seeds, mesh and lowpoly, and the maps saliency, \
                        entropy (white is 8 bits), diffused and edges, each as a PNG of the picture's \
                        size; the maps also as exact floats (.npy).\n\nExample:\n  polyreel inspect portrait.png -o stages/"
)]
pub(crate) struct InspectArgs {
    /// The picture; of an animation or a video, its first frame
    #[arg(value_name = "IMAGE")]
    pub(crate) image: String,
    /// The folder to write to; made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Shrink the picture until its longest side has at most PX pixels [default: its own size]
    #[arg(long, value_name = "PX")]
    pub(crate) max_size: Option<u32>,
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
#[command(override_usage = "polyreel evaluate [OPTIONS] <INPUT>...")]
#[command(
    after_help = "Every picture is measured by itself, every GIF and video as a clip; without refinement, \
                         unless --quality or --refine asks for it. A file that \
                        cannot be read is reported and passed over; the exit code is 1 then.\n\nExample:\n  \
                        polyreel evaluate pictures/ --methods hrlp,rlp --html report.html"
)]
pub(crate) struct EvaluateArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// The methods to compare [default: all, or that of --method]
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', value_parser = methods())]
    #[arg(help_heading = "Comparison")]
    pub(crate) methods: Vec<Method>,
    /// Leave out the disturbed pictures, which take three quarters of the time
    #[arg(long, help_heading = "Comparison")]
    pub(crate) no_robustness: bool,
    /// Write all figures as JSON, to standard output or FILE
    #[arg(long, value_name = "FILE", help_heading = "Output", num_args = 0..=1)]
    #[arg(default_missing_value = "-", require_equals = true)]
    pub(crate) json: Option<PathBuf>,
    /// Write the figures of every picture and method as CSV, to standard output or FILE
    #[arg(long, value_name = "FILE", help_heading = "Output", num_args = 0..=1)]
    #[arg(default_missing_value = "-", require_equals = true)]
    pub(crate) csv: Option<PathBuf>,
    /// Write the tables as Markdown, to standard output or FILE
    #[arg(long, value_name = "FILE", help_heading = "Output", num_args = 0..=1)]
    #[arg(default_missing_value = "-", require_equals = true)]
    pub(crate) markdown: Option<PathBuf>,
    /// Write one page with pictures, plots and tables, readable without a network
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) html: Option<PathBuf>,
    /// Replace files that are there already
    #[arg(short = 'y', long, help_heading = "Output")]
    pub(crate) overwrite: bool,
    /// Threads that work inside a frame [default: one a core]
    #[arg(long, value_name = "N", help_heading = "Run")]
    pub(crate) threads: Option<NonZeroUsize>,
    /// Print no tables and no bar
    #[arg(short, long, help_heading = "Run")]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) look: LookArgs,
}

impl EvaluateArgs {
    /// The inputs and the files to write. `--json out.json`, without its equals sign, looks like one
    /// more input to the parser; no picture is called that, so it is what it looks like to its writer.
    pub(crate) fn settled(mut self) -> Self {
        let outputs =
            [(&mut self.json, "json"), (&mut self.csv, "csv"), (&mut self.markdown, "md")];
        for (output, extension) in outputs {
            let names = |input: &String| {
                PathBuf::from(input).extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
            };
            if output.as_ref().is_some_and(|path| path.as_os_str() == "-")
                && let Some(place) = self.input.inputs.iter().position(names)
            {
                *output = Some(PathBuf::from(self.input.inputs.remove(place)));
            }
        }
        self
    }

    /// The methods to compare, each once.
    pub(crate) fn chosen(&self) -> Vec<Method> {
        if self.methods.is_empty() {
            return self.look.method.map_or_else(|| Method::ALL.to_vec(), |method| vec![method]);
        }
        let wanted = |method: &Method| self.methods.contains(method);
        Method::ALL.into_iter().filter(wanted).collect()
    }
}

#[derive(Debug, Args)]
#[command(after_help = "Of y4m on standard input only the header is read, and is gone then.\n\n\
                        Example:\n  polyreel info dance.gif --json")]
pub(crate) struct InfoArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// What is read, and how much of it.
#[derive(Debug, Args)]
#[command(next_help_heading = "Input")]
pub(crate) struct InputArgs {
    /// A picture, GIF or video, several pictures, a folder of them, a quoted glob ('shots/*.png'), a
    /// printf pattern (shot%03d.png), a URL, a camera (/dev/video0), or - for y4m on standard input
    #[arg(value_name = "INPUT", required = true, help_heading = None::<&str>)]
    pub(crate) inputs: Vec<String>,
    /// Leave out what comes before TIME: 1.5, 500ms, 1:30 [default: from the beginning]
    #[arg(long, value_name = "TIME", value_parser = amount::time)]
    start: Option<Rational>,
    /// Leave out what comes at TIME or later [default: to the end]
    #[arg(long, value_name = "TIME", value_parser = amount::time)]
    end: Option<Rational>,
    /// Read at most N frames [default: all]
    #[arg(long, value_name = "N")]
    frames: Option<NonZeroU64>,
    /// Frames per second of a sequence of pictures: 12, 29.97, 24000/1001 [default: 25]
    #[arg(long, value_name = "RATE", value_parser = amount::rate)]
    fps: Option<Rational>,
    /// Shrink frames until their longest side has at most PX pixels [default: their own size]
    #[arg(long, value_name = "PX")]
    max_size: Option<u32>,
    /// Keep what can be read of an input that breaks off [default: fail]
    #[arg(long)]
    pub(crate) allow_truncated: bool,
    /// The ffmpeg program that reads and writes video [default: the one on the search path]
    #[arg(long, value_name = "PATH")]
    ffmpeg: Option<PathBuf>,
}

impl InputArgs {
    pub(crate) fn options(&self) -> SourceOptions {
        SourceOptions {
            start: self.start,
            end: self.end,
            frames: self.frames.map(NonZeroU64::get),
            fps: self.fps,
            max_size: self.max_size,
            allow_truncated: self.allow_truncated,
            ffmpeg: self.ffmpeg.clone(),
        }
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
}

/// How video is encoded.
#[derive(Debug, Args)]
#[command(next_help_heading = "Video output (.mp4, .webm, .mkv, .mov)")]
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
    /// More options for ffmpeg's output, in one word: '-tune animation -b:a 96k' [default: none]
    #[arg(long, value_name = "ARGS", allow_hyphen_values = true)]
    ffmpeg_args: Option<String>,
}

impl VideoArgs {
    pub(crate) fn options(&self, input: &InputArgs) -> Result<VideoOptions> {
        let ffmpeg_args = self.ffmpeg_args.as_deref().map(amount::words).transpose();
        Ok(VideoOptions {
            codec: self.codec.clone(),
            crf: self.crf,
            encoder_preset: self.encoder_preset.clone(),
            audio: !self.no_audio,
            ffmpeg_args: ffmpeg_args.map_err(Error::Usage)?.unwrap_or_default(),
            ffmpeg: input.ffmpeg.clone(),
        })
    }
}

/// How the result looks. Every field that is given replaces the preset's.
#[derive(Debug, Args)]
#[command(next_help_heading = "Look")]
pub(crate) struct LookArgs {
    /// Begin with a preset's settings; options beside it win: paper [default: none]
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// How feature points and seeds are found
    #[arg(long, value_name = "NAME", value_parser = methods(), help = told(
        "How feature points and seeds are found", Options::default().method.name()))]
    method: Option<Method>,
    #[arg(long, value_name = "N|N%|auto", help = told(
        "Seeds of a frame: a count (2000), a share of its pixels (1.5%), or auto: the fewest, to 2 %, \
         that reach --error on the first frame; they stay for the frames after it",
        Options::default().points))]
    points: Option<Points>,
    #[arg(long, value_name = "S", help = told(
        "Decides all chance: the same seed gives the same bytes", Options::default().seed))]
    seed: Option<u64>,
    #[arg(long, value_name = "C", help = told(
        "How much of the mesh lives on from frame to frame, 0 (each frame alone) to 1 (locked)",
        Options::default().coherence))]
    coherence: Option<f64>,
    #[arg(long, value_name = "NAME", value_parser = qualities(), help = told(
        "How much work goes into refinement: none, most of the gain, all of it",
        Options::default().quality.name()))]
    quality: Option<Quality>,
    /// Steps of refinement in place of --quality: of a still, and of each frame of an animation, the
    /// first of a shot getting a few more [default: as --quality]
    #[arg(long, value_name = "STEPS", conflicts_with = "quality")]
    refine: Option<u32>,
    /// Refine a still, and the first frame of a shot, until it is as like its source as this, in place
    /// of a number of steps: psnr:30 or 30dB (over RGB), ssim:0.8 (of the luma, window of 7x7); where
    /// that is out of reach, a warning is given [default: none]
    #[arg(long, value_name = "E", conflicts_with = "refine")]
    error: Option<Target>,
    #[arg(long, value_name = "R", help = told(
        "How much well-shaped triangles count against the error, 0 (not at all) to 1 (only they do)",
        Options::default().regularity))]
    regularity: Option<f64>,
    /// Draw the edges of the mesh, in black or in COLOUR (white, #802040) [default: none]
    #[arg(long, value_name = "COLOUR", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "black")]
    outline: Option<Colour>,
    #[arg(long, value_name = "N", help = told(
        "How often a frame is smoothed before its colours are clustered, 0 to 8 (in the paper 0)",
        Options::default().smoothing))]
    smoothing: Option<u32>,
    #[arg(long, value_name = "K", help_heading = PAPER, help = told(
        "Colour clusters of the regions, 2 to 64", Options::default().clusters))]
    clusters: Option<u32>,
    #[arg(long, value_name = "N", help_heading = PAPER, help = told(
        "Every how many pixels of a region's boundary one is a feature point, 1 to 64",
        Options::default().interval))]
    interval: Option<u32>,
    #[arg(long, value_name = "SHARE", help_heading = PAPER, help = told(
        "Share of the pixels inside regions that are feature points, 0 to 1",
        Options::default().interior))]
    interior: Option<f64>,
    /// Area of a grid cell as a share of the frame's, in place of --points [default: solved from
    /// --points]
    #[arg(long, value_name = "SHARE", conflicts_with = "points", help_heading = PAPER)]
    hex_density: Option<f64>,
    #[arg(long, value_name = "N", help_heading = PAPER, help = told(
        "Points that the densest cells keep, 1 to 64", Options::default().max_points))]
    max_points: Option<u32>,
    #[arg(long, value_name = "N", help_heading = PAPER, help = told(
        "Points that the sparsest cells keep, 0 to --max-points", Options::default().default_points))]
    default_points: Option<u32>,
    #[arg(long, value_name = "H,M,L", help_heading = PAPER, help = told(
        "Feature points per pixel above which a cell counts as of high, medium, low density",
        thresholds()))]
    thresholds: Option<Thresholds>,
    #[arg(long, value_name = "NAME", help_heading = SCORES, value_parser = front_ends())]
    /// Where feature points come from, for any method [default: the method's own]
    features: Option<FrontEnd>,
    #[arg(long, value_name = "SHARE", help_heading = SCORES, help = told(
        "Share of the pixels that a map (entropy, saliency, sobel, laplacian) or slic makes feature \
         points, up to 1",
        Options::default().candidates))]
    candidates: Option<f64>,
    #[arg(long, value_name = "N", help_heading = SCORES, help = told(
        "Points that every cell gets before the rest is shared out by value (help, hslp), 0 to 64",
        Options::default().min_points))]
    min_points: Option<u32>,
    #[arg(long, value_name = "H,M", help_heading = SCORES, help = told(
        "Percentiles of the cells' mean value that tell high, medium and low cells (help, hslp)",
        percentiles()))]
    percentiles: Option<CellPercentiles>,
    #[arg(long, value_name = "PX", help_heading = SCORES, help = told(
        "Radius of the disk of the entropy, 1 to 32", Options::default().entropy_radius))]
    entropy_radius: Option<u32>,
    #[arg(long, value_name = "N", help_heading = SCORES, help = told(
        "Steps of the anisotropic diffusion before the entropy, 0 to 1000",
        Options::default().diffusion_iterations))]
    diffusion_iterations: Option<u32>,
    #[arg(long, value_name = "K", help_heading = SCORES, help = told(
        "Differences of luma above which the diffusion takes them for edges, up to 1000",
        Options::default().diffusion_kappa))]
    diffusion_kappa: Option<f64>,
    #[arg(long, value_name = "G", help_heading = SCORES, help = told(
        "Length of a step of the diffusion, up to 0.25", Options::default().diffusion_gamma))]
    diffusion_gamma: Option<f64>,
}

const PAPER: &str = "The paper's parameters";
const SCORES: &str = "Feature maps, and the methods that score every pixel";

impl LookArgs {
    /// As [`LookArgs::options`], but without refinement where none is asked for: methods are compared
    /// by what they do themselves.
    pub(crate) fn plain_options(&self) -> Result<Options> {
        let mut options = self.options()?;
        let none = self.quality.is_none() && self.refine.is_none() && self.error.is_none();
        if none && self.preset.is_none() {
            options.quality = Quality::Draft;
        }
        Ok(options)
    }

    /// The preset's options (the defaults without one) with what was given on the command line.
    pub(crate) fn options(&self) -> Result<Options> {
        fn put<T: Clone>(field: &mut T, given: &Option<T>) {
            if let Some(value) = given {
                field.clone_from(value);
            }
        }
        let mut options = match &self.preset {
            Some(name) => Options::preset(name)?,
            None => Options::default(),
        };
        put(&mut options.method, &self.method);
        put(&mut options.points, &self.points);
        put(&mut options.seed, &self.seed);
        put(&mut options.coherence, &self.coherence);
        put(&mut options.quality, &self.quality);
        put(&mut options.regularity, &self.regularity);
        put(&mut options.smoothing, &self.smoothing);
        put(&mut options.clusters, &self.clusters);
        put(&mut options.interval, &self.interval);
        put(&mut options.interior, &self.interior);
        put(&mut options.max_points, &self.max_points);
        put(&mut options.default_points, &self.default_points);
        put(&mut options.thresholds, &self.thresholds);
        if self.refine.is_some() || self.quality.is_some() {
            options.refine = self.refine;
        }
        options.error = self.error.or(options.error);
        put(&mut options.candidates, &self.candidates);
        put(&mut options.min_points, &self.min_points);
        put(&mut options.percentiles, &self.percentiles);
        put(&mut options.entropy_radius, &self.entropy_radius);
        put(&mut options.diffusion_iterations, &self.diffusion_iterations);
        put(&mut options.diffusion_kappa, &self.diffusion_kappa);
        put(&mut options.diffusion_gamma, &self.diffusion_gamma);
        options.features = self.features.or(options.features);
        options.outline = self.outline.or(options.outline);
        options.hex_density = self.hex_density.or(options.hex_density);
        if self.points.is_some() {
            // A number of points asked for here is meant, whatever grid the preset has.
            options.hex_density = None;
        }
        options.validate()?;
        Ok(options)
    }
}

/// How the work is done and told of.
#[derive(Debug, Args)]
#[command(next_help_heading = "Run")]
pub(crate) struct RunArgs {
    /// Threads that work inside a frame; the bytes are the same for any number [default: one a core]
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<NonZeroUsize>,
    /// Write what was done, in sum and for every frame, as JSON; replaces an older report
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    /// Say nothing unless something is wrong
    #[arg(short, long, conflicts_with = "verbose")]
    pub(crate) quiet: bool,
    /// Tell the settings, and the time of each stage
    #[arg(short, long)]
    pub(crate) verbose: bool,
}

fn told(text: &str, default: impl Display) -> String {
    format!("{text} [default: {default}]")
}

fn thresholds() -> String {
    let Thresholds { high, medium, low } = Options::default().thresholds;
    format!("{high},{medium},{low}")
}

fn percentiles() -> String {
    let CellPercentiles { high, medium } = Options::default().percentiles;
    format!("{high},{medium}")
}

fn methods() -> impl TypedValueParser<Value = Method> {
    PossibleValuesParser::new(Method::ALL.map(Method::name)).try_map(|name| {
        let found = Method::ALL.into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| Error::usage("no such method"))
    })
}

fn qualities() -> impl TypedValueParser<Value = Quality> {
    PossibleValuesParser::new(Quality::ALL.map(Quality::name)).try_map(|name| {
        let found = Quality::ALL.into_iter().find(|quality| quality.name() == name);
        found.ok_or_else(|| Error::usage("no such quality"))
    })
}

fn front_ends() -> impl TypedValueParser<Value = FrontEnd> {
    PossibleValuesParser::new(FrontEnd::ALL.map(FrontEnd::name)).try_map(|name| {
        let found = FrontEnd::ALL.into_iter().find(|front| front.name() == name);
        found.ok_or_else(|| Error::usage("no such front end"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

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
            &["--points", "auto"],
            &["--error", "30"],
            &["--error", "ssim:1.5"],
            &["--error", "30dB", "--refine", "9"],
        ] {
            assert!(look(args).is_err(), "{args:?}");
        }
    }
}
