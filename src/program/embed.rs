//! The program's options, and its `render`, for a program of which polyreel is a part: the Python package takes its
//! options from here, so that there is one list of them.

use std::any::TypeId;
use std::ffi::OsString;
use std::num::NonZeroU64;
use std::ops::ControlFlow;

use clap::{ArgAction, CommandFactory, Parser};
use polyreel::error::{Error, Result};
use polyreel::ffmpeg::Processes;
use polyreel::options::Options;
use polyreel::pipeline::{FrameReport, OutputReport, Stop, Summary};
use polyreel::sink::{Sink, Unfinished};
use polyreel::stream::StreamInfo;

use crate::program::cli::RenderArgs;
use crate::program::interrupt::Interrupt;
use crate::program::look::LookArgs;
use crate::program::render::render_for;

/// The options of the look alone.
#[derive(Debug, Parser)]
#[command(name = "polyreel", no_binary_name = true, disable_help_flag = true)]
struct Look {
    #[command(flatten)]
    look: LookArgs,
}

/// All of `render`.
#[derive(Debug, Parser)]
#[command(name = "polyreel", no_binary_name = true, disable_help_flag = true)]
struct Whole {
    #[command(flatten)]
    render: RenderArgs,
}

/// What the value of an option is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Value {
    /// None: the option is a flag.
    None,
    /// It may be left out.
    Optional,
    /// A whole number.
    Whole,
    /// A number.
    Real,
    /// A word, or what is written as one.
    Text,
}

/// An option of the command line.
#[derive(Clone, Debug)]
pub struct Described {
    /// Its long name, without dashes before it.
    pub name: String,
    /// What it does, in a sentence.
    pub help: String,
    /// What its value is.
    pub value: Value,
    /// What the value is called in the help: `N`, `TIME`, `COLOUR` ...
    pub unit: String,
    /// The values that it can have, where these are a list of words.
    pub choices: Vec<String>,
    /// Whether it concerns the look, not the file.
    pub is_look: bool,
}

/// What concerns the terminal, is an argument of its own, or is done by several processes.
const NOT_OPTIONS: [&str; 12] = [
    "output",
    "batch",
    "preview",
    "quiet",
    "verbose",
    "plan",
    "chunk",
    "all",
    "jobs",
    "film",
    "resume",
    "until-input-ends",
];

/// The options of `render`, those of the look among them.
pub fn described() -> Vec<Described> {
    let look = Look::command();
    let is_look = |name: &str| look.get_arguments().any(|other| other.get_long() == Some(name));
    let whole = Whole::command();
    let options = whole.get_arguments().filter_map(|argument| {
        let name = argument.get_long().filter(|name| !NOT_OPTIONS.contains(name))?;
        let may_lack = argument.get_num_args().is_some_and(|number| number.min_values() == 0);
        let parsed = argument.get_value_parser().type_id();
        let is_whole = [TypeId::of::<u32>(), TypeId::of::<u64>(), TypeId::of::<NonZeroU64>()];
        let value = match argument.get_action() {
            ArgAction::SetTrue => Value::None,
            _ if may_lack => Value::Optional,
            _ if is_whole.iter().any(|whole| parsed == *whole) => Value::Whole,
            _ if parsed == TypeId::of::<f64>() => Value::Real,
            _ => Value::Text,
        };
        let choices =
            if value == Value::None { Vec::new() } else { argument.get_possible_values() };
        Some(Described {
            name: name.to_owned(),
            help: argument.get_help().map(ToString::to_string).unwrap_or_default(),
            value,
            unit: argument.get_value_names().map(|names| names.concat()).unwrap_or_default(),
            choices: choices.iter().map(|choice| choice.get_name().to_owned()).collect(),
            is_look: is_look(name),
        })
    });
    options.collect()
}

/// The look that `arguments` ask for: options as on the command line.
///
/// # Errors
/// [`Error::Usage`] for what cannot be meant.
pub fn look(arguments: &[OsString]) -> Result<Options> {
    let look = Look::try_parse_from(arguments).map_err(|error| refused(&error))?;
    look.look.options()
}

/// What clap says of arguments, without the hints for a command line.
fn refused(error: &clap::Error) -> Error {
    let text = error.to_string();
    let lines = text.lines().map(str::trim).filter(|line| {
        !(line.is_empty() || line.starts_with("Usage:") || line.starts_with("For more information"))
    });
    let said = lines.collect::<Vec<_>>().join(" ");
    Error::usage(said.strip_prefix("error: ").unwrap_or(&said))
}

/// Watches a render.
pub trait Watcher: Send {
    /// What will be rendered is known.
    fn begins(&mut self, info: &StreamInfo);
    /// A frame has been written. `Break` asks for a stop.
    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()>;
    /// `sink`, or one that looks at what goes into it.
    fn taps(&mut self, sink: Box<dyn Sink>) -> Box<dyn Sink> {
        sink
    }
    /// No more frames follow, whether or not all went well.
    fn frames_end(&mut self) {}
    /// There is something that the user should know.
    fn warns(&mut self, text: &str);
    /// The output is complete.
    fn ended(&mut self, info: &StreamInfo, written: &OutputReport, summary: &Summary);
}

/// A way to end a render, and what it has begun.
#[derive(Clone, Debug, Default)]
pub struct Control {
    /// Asks for a shorter output.
    pub stop: Stop,
    /// The processes that read and write for it.
    pub processes: Processes,
    /// Its temporary files.
    pub unfinished: Unfinished,
}

/// Does what `polyreel render` does with `arguments`, its options, inputs and output as on the command line. Nothing
/// is said on standard error, and signals are left alone.
///
/// # Errors
/// As the program.
pub fn render(arguments: &[OsString], control: &Control, watcher: &mut dyn Watcher) -> Result<()> {
    let whole = Whole::try_parse_from(arguments).map_err(|error| refused(&error))?;
    let interrupt = Interrupt::with(control.processes.clone(), control.unfinished.clone());
    render_for(&whole.render, &control.stop, &interrupt, watcher)
}
