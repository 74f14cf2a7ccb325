//! Parses the command line: clap does it; here are its page for `-h`, and what it should have understood.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::{CommandFactory, FromArgMatches};

use crate::program::advice::advised;
use crate::program::cli::{Cli, paged};

/// The command line `arguments`, the program's name first.
///
/// # Errors
/// clap's, with advice; the help that was asked for is one of them.
pub(crate) fn parse(
    arguments: impl IntoIterator<Item = OsString>,
) -> std::result::Result<Cli, clap::Error> {
    let arguments = with_colours_joined(arguments);
    let mut command = paged(Cli::command());
    let parsed = command.try_get_matches_from_mut(&arguments).and_then(|mut matches| {
        Cli::from_arg_matches_mut(&mut matches).map_err(|error| error.format(&mut command))
    });
    parsed.map_err(|error| advised(error, &command, &arguments))
}

/// `arguments` with `--outline white` as `--outline=white`: without a colour the option draws in black, so that the
/// parser takes the next word for an input.
fn with_colours_joined(arguments: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut joined = Vec::new();
    let mut rest = arguments.into_iter().peekable();
    while let Some(argument) = rest.next() {
        if argument == "--" {
            joined.push(argument);
            joined.extend(rest);
            break;
        }
        let colour = if argument == "--outline" { rest.next_if(|n| is_colour(n)) } else { None };
        joined.push(match colour {
            Some(colour) => [argument, OsString::from("="), colour].into_iter().collect(),
            None => argument,
        });
    }
    joined
}

/// Whether `word` is meant as a colour, be it an unknown one, rather than a file.
fn is_colour(word: &OsStr) -> bool {
    let Some(text) = word.to_str() else { return false };
    let name = text.strip_prefix('#').unwrap_or(text);
    let plain = !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric());
    plain && !Path::new(text).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_may_follow_the_outline() {
        let joined = |line: &str| {
            let words = with_colours_joined(line.split(' ').map(OsString::from));
            words.join(OsStr::new(" ")).into_string().expect("text")
        };
        assert_eq!(joined("render --outline white a.png"), "render --outline=white a.png");
        assert_eq!(joined("render --outline #123 a.png"), "render --outline=#123 a.png");
        for same in [
            "render --outline a.png -o b.png",
            "render --outline -o b.png",
            "render --outline - -o b.png",
            "render --outline src -o b.png",
            "render -- --outline white",
            "render a.png --outline",
        ] {
            assert_eq!(joined(same), same);
        }
    }
}
