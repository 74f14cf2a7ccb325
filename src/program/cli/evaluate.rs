//! The options of `polyreel evaluate`.

use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;
use polyreel::options::Method;

use super::InputArgs;
use crate::program::amount;
use crate::program::look::{LookArgs, methods};

#[derive(Debug, Args)]
#[command(override_usage = "polyreel evaluate [OPTIONS] <INPUT>...")]
#[command(
    after_help = "Every picture is measured by itself, every GIF and video as a clip. The paper's tables \
                         are without refinement; tables of their own compare the methods with themselves \
                         refined, as --quality, --refine or --error say, unless that is --refine 0. Standard \
                         output has a short table; --markdown, --csv and --json have all figures of all pictures. A \
                         file that \
                        cannot be read is reported and passed over; the exit code is 1 then.\n\nExamples:\n  \
                        polyreel evaluate pictures/ --methods hrlp,rlp --html report.html\n  \
                        polyreel evaluate pictures/ --studies --html studies.html"
)]
pub(crate) struct EvaluateArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// The methods to compare [default: all, or that of --method]
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', value_parser = methods())]
    #[arg(help_heading = "Comparison")]
    pub(crate) methods: Vec<Method>,
    /// Compare the studies, earlier systems and the paper's own, in place of methods: the paper's Table 1, measured, all
    /// at the same number of points [default: 0.8%, the paper's]
    #[arg(long, help_heading = "Comparison", conflicts_with_all = ["methods", "method", "preset", "study"])]
    pub(crate) studies: bool,
    /// Compare all presets, each as it is, in place of methods
    #[arg(long, help_heading = "Comparison")]
    #[arg(conflicts_with_all = ["methods", "method", "preset", "study", "studies", "points"])]
    pub(crate) presets: bool,
    /// Leave out the disturbed pictures, which take most of the time
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
    /// Threads that work inside a frame [default: one a core; at most 256]
    #[arg(long, value_name = "N", value_parser = amount::threads, help_heading = "Run")]
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
            let names = |input: &OsString| {
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
            return self.look.method.map_or_else(|| Method::PAPER.to_vec(), |method| vec![method]);
        }
        let wanted = |method: &Method| self.methods.contains(method);
        Method::ALL.into_iter().filter(wanted).collect()
    }
}
