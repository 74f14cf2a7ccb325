//! `polyreel info`: the properties of an input.

use std::fmt::Write as _;

use polyreel::error::Result;
use polyreel::frame::{Colorimetry, Rational};
use polyreel::pipeline::{InputReport, Stop};
use polyreel::source;
use polyreel::stream::{Loops, StreamInfo};

use crate::program::cli::InfoArgs;
use crate::program::interrupt::Interrupt;
use crate::program::{Outcome, print, terminal};

/// Prints the properties in the input's headers.
pub(crate) fn info(args: &InfoArgs) -> Result<Outcome> {
    // Programs that read for us must not outlive us.
    let interrupt = Interrupt::listen(&Stop::default());
    let input = source::open(&args.input.inputs, &args.input.options(interrupt.processes()))?;
    let info = input.info().clone();
    let text = if args.json {
        let report = InputReport::new(&args.input.inputs, info);
        let json = serde_json::to_string_pretty(&report).expect("plain data becomes JSON");
        format!("{}\n", terminal::escape_json(&json))
    } else {
        table(&info) + &found(input.notes())
    };
    print(text.as_bytes())
}

fn table(info: &StreamInfo) -> String {
    let unknown = || "unknown".to_owned();
    let rows = [
        ("format", info.format.clone()),
        ("size", info.size.to_string()),
        ("frames", info.frames.map_or_else(unknown, |n| n.to_string())),
        ("rate", info.rate.map_or_else(|| rateless(info), rate)),
        (
            "duration",
            info.duration.map_or_else(|| rateless(info), |d| format!("{:.3} s", d.to_f64())),
        ),
        ("alpha", if info.alpha { "yes" } else { "no" }.to_owned()),
        ("plays", plays(info.loops)),
        ("audio", info.audio.clone().unwrap_or_else(|| "none".to_owned())),
    ];
    let colour = info.colour.as_ref().map(|colour| ("colour", tags(colour)));
    rows.iter().chain(&colour).fold(String::new(), |mut text, (name, value)| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<9} {}", terminal::escape(value));
        text
    })
}

/// A row for each of the `notes`.
fn found(notes: &[String]) -> String {
    notes.iter().map(|note| format!("{:<9} {}\n", "found", terminal::escape(note))).collect()
}

/// Printed for an unknown rate or duration.
fn rateless(info: &StreamInfo) -> String {
    if info.still { "none" } else { "unknown" }.to_owned()
}

fn rate(rate: Rational) -> String {
    if rate.den == 1 { format!("{rate} fps") } else { format!("{rate} fps ({:.3})", rate.to_f64()) }
}

fn tags(colour: &Colorimetry) -> String {
    let Colorimetry { matrix, range, primaries, transfer } = colour;
    let fields =
        [("matrix", matrix), ("range", range), ("primaries", primaries), ("curve", transfer)];
    let known: Vec<String> =
        fields.iter().filter_map(|(name, tag)| Some(format!("{name} {}", tag.as_ref()?))).collect();
    if known.is_empty() { "unknown".to_owned() } else { known.join(", ") }
}

fn plays(loops: Loops) -> String {
    match loops {
        Loops::Once => "once".to_owned(),
        Loops::Times(n) => format!("{n} times"),
        _ => "forever".to_owned(),
    }
}
