//! Advice for command lines that cannot be parsed, in clap's errors.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, Error};

use crate::program::suggest::nearest;

/// Words that mean one of a list of values, if it is in the list.
const SYNONYMS: [(&str, &str); 12] = [
    ("high", "best"),
    ("highest", "best"),
    ("max", "best"),
    ("full", "best"),
    ("medium", "normal"),
    ("default", "normal"),
    ("good", "normal"),
    ("low", "draft"),
    ("fast", "draft"),
    ("antialiased", "smooth"),
    ("soft", "smooth"),
    ("sharp", "hard"),
];

/// `error`, which `command` has with `arguments`, with better advice than clap gives.
pub(crate) fn advised(mut error: Error, command: &Command, arguments: &[OsString]) -> Error {
    match error.kind() {
        ErrorKind::InvalidSubcommand => suggest_render(&mut error, arguments),
        ErrorKind::UnknownArgument => suggest_option(&mut error, command, arguments),
        ErrorKind::InvalidValue => suggest_value(&mut error),
        ErrorKind::ValueValidation => refuse_negative(&mut error),
        _ => {}
    }
    error
}

/// For a file in the place of a command.
fn suggest_render(error: &mut Error, arguments: &[OsString]) {
    let Some(word) = text_of(error, ContextKind::InvalidSubcommand) else { return };
    suggest_render_of(error, OsStr::new(&word), arguments);
}

fn suggest_render_of(error: &mut Error, word: &OsStr, arguments: &[OsString]) {
    let path = Path::new(word);
    let text = word.to_string_lossy();
    let is_input = path.exists() || path.extension().is_some() || text.contains(['*', '/', '%']);
    if !is_input {
        return;
    }
    let words = arguments.iter().skip(1).map(|word| quoted(word));
    let mut line: Vec<String> = words.collect();
    let named = |word: &String| word.starts_with("-o") || word.starts_with("--output");
    if !line.iter().any(named) {
        line.extend(["-o".to_owned(), quoted(OsStr::new(&output_for(path)))]);
    }
    error.remove(ContextKind::SuggestedSubcommand);
    tip(error, format!("to render it: polyreel render {}", line.join(" ")));
}

/// A name for what becomes of `input`.
fn output_for(input: &Path) -> String {
    let stem = input.file_stem().unwrap_or_default().to_string_lossy();
    let extension = input.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match extension.as_str() {
        _ if stem.contains(['*', '%']) || input.is_dir() => "out/".to_owned(),
        "gif" | "apng" => format!("{stem}-lowpoly.gif"),
        "mp4" | "mov" | "mkv" | "webm" | "avi" | "y4m" => format!("{stem}-lowpoly.mp4"),
        _ => format!("{stem}-lowpoly.png"),
    }
}

/// `word` as a shell takes it for one word.
fn quoted(word: &OsStr) -> String {
    let word = word.to_string_lossy();
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,#%+@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.into_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// For an option that is not there. clap's own guesses are often far away.
fn suggest_option(error: &mut Error, command: &Command, arguments: &[OsString]) {
    let Some(given) = text_of(error, ContextKind::InvalidArg) else { return };
    error.remove(ContextKind::Suggested);
    error.remove(ContextKind::SuggestedArg);
    let called = arguments.iter().skip(1).find_map(|word| command.find_subcommand(word));
    let options_first = called.is_none() && arguments.len() > 2;
    if let Some(input) = arguments.last().filter(|_| options_first) {
        // Such as `polyreel -o out.png picture.png`.
        return suggest_render_of(error, input, arguments);
    }
    let options = called.unwrap_or(command).get_arguments();
    let names: Vec<&str> = options.filter_map(|option| option.get_long()).collect();
    if given[1..].starts_with(|c: char| c.is_ascii_digit()) {
        return tip(error, "options take no negative numbers");
    }
    let name = match given.strip_prefix("--") {
        Some(long) => nearest(long.split('=').next().unwrap_or(long), &names),
        // One dash before a long name: its first letter was taken for an option.
        None => arguments.iter().find_map(|word| {
            let word = word.to_str()?.strip_prefix('-')?;
            let is_it = word.len() > 2 && word.starts_with(&given[1..]);
            names.iter().find(|name| is_it && **name == word).copied()
        }),
    };
    if let Some(name) = name {
        let suggested = ContextValue::String(format!("--{name}"));
        error.insert(ContextKind::SuggestedArg, suggested);
    }
}

/// For a value that is not in a list.
fn suggest_value(error: &mut Error) {
    let Some(given) = text_of(error, ContextKind::InvalidValue) else { return };
    let Some(ContextValue::Strings(valid)) = error.get(ContextKind::ValidValue) else { return };
    let lower = given.to_lowercase();
    let synonym = SYNONYMS.iter().find(|(word, _)| *word == lower).map(|(_, value)| *value);
    let names: Vec<&str> = valid.iter().map(String::as_str).collect();
    let meant = synonym.filter(|value| names.contains(value)).or_else(|| nearest(&given, &names));
    if let Some(meant) = meant.map(str::to_owned) {
        error.insert(ContextKind::SuggestedValue, ContextValue::String(meant));
    }
}

/// For a negative number. None of the options has those.
fn refuse_negative(error: &mut Error) {
    let is_negative = text_of(error, ContextKind::InvalidValue)
        .is_some_and(|value| value.strip_prefix('-').is_some_and(|v| v.parse::<f64>().is_ok()));
    if is_negative && let Some(option) = text_of(error, ContextKind::InvalidArg) {
        let name = option.split([' ', '[']).next().unwrap_or(&option);
        tip(error, format!("{name} takes no negative number"));
    }
}

fn text_of(error: &Error, kind: ContextKind) -> Option<String> {
    match error.get(kind)? {
        ContextValue::String(text) => Some(text.clone()),
        _ => None,
    }
}

/// Adds a line of advice.
fn tip(error: &mut Error, text: impl Into<String>) {
    let text = clap::builder::StyledStr::from(text.into());
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![text]));
}
