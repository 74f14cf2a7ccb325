//! Preset files: options written as TOML.

use toml::Table;

use crate::error::{Error, Result};
use crate::options::Options;

/// The options as a preset file: those that differ from the defaults, below a comment.
///
/// # Errors
/// When the seed is above 2^63 - 1, the largest number that TOML has.
pub fn to_toml(options: &Options) -> Result<String> {
    let table = |options: &Options| {
        Table::try_from(options).map_err(|_| {
            Error::usage(format!("seed {} cannot be written: TOML ends at 2^63 - 1", options.seed))
        })
    };
    let (mut mine, usual) = (table(options)?, table(&Options::default())?);
    mine.retain(|key, value| usual.get(key) != Some(value));
    Ok(format!(
        "# A preset of polyreel: use it with --preset FILE.toml. What is not named here is as by\n\
         # default; keys are the options' names.\n{mine}"
    ))
}

/// The options in a preset file; the defaults where it does not name them.
///
/// # Errors
/// When it is not valid TOML, or has an unknown key or value: the error names line and key.
pub fn from_toml(text: &str) -> Result<Options> {
    let options: Options = toml::from_str(text).map_err(|error| {
        let line = error.span().map(|span| line_of(text, span.start));
        Error::usage(at_line(text, line, error.message()))
    })?;
    options.validate().map_err(|error| {
        // It begins with the key.
        let said = error.to_string();
        let key = said.split_whitespace().next().unwrap_or_default();
        let line = text.lines().position(|line| key_of(line) == Some(key));
        Error::usage(at_line(text, line, &said))
    })?;
    Ok(options)
}

/// The line, from 0, that holds byte `at`.
fn line_of(text: &str, at: usize) -> usize {
    text.bytes().take(at).filter(|&byte| byte == b'\n').count()
}

/// The key that a line of TOML sets.
fn key_of(line: &str) -> Option<&str> {
    let key = line.split_once('=')?.0.trim();
    Some(key).filter(|key| !key.is_empty() && !key.starts_with('#'))
}

fn at_line(text: &str, line: Option<usize>, what: &str) -> String {
    let what = what.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    let Some(line) = line else { return what };
    let key = text.lines().nth(line).and_then(key_of).filter(|key| {
        // If the message already has the line, it is not added.
        !what.starts_with(*key) && !what.contains(&format!("`{key}`"))
    });
    let key = key.map_or_else(String::new, |key| format!(", {key}"));
    format!("line {}{key}: {what}", line + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::{PRESETS, Points, Target, Thresholds};

    #[test]
    fn presets_come_back_from_their_files() {
        for preset in &PRESETS {
            let options = Options::preset(preset.name).expect(preset.name);
            let text = to_toml(&options).expect(preset.name);
            assert_eq!(from_toml(&text).expect(preset.name), options);
            assert!(text.starts_with("# "), "{text}");
        }
    }

    #[test]
    fn only_what_differs_is_written() {
        let text = to_toml(&Options::default()).expect("defaults");
        assert!(text.lines().all(|line| line.starts_with('#')), "{text}");
        let options = Options {
            points: Points::Auto,
            error: Some(Target::Psnr(30.0)),
            thresholds: Thresholds { high: 0.3, ..Default::default() },
            ..Options::default()
        };
        let text = to_toml(&options).expect("plain data");
        assert_eq!(from_toml(&text).expect("what was written"), options);
        assert!(!text.contains("clusters"), "{text}");
        let huge = Options { seed: u64::MAX, ..Options::default() };
        assert!(to_toml(&huge).expect_err("no such number").to_string().contains("seed"));
    }

    #[test]
    fn a_count_of_points_needs_no_quotes() {
        let points = |text: &str| from_toml(text).map(|options| options.points);
        assert_eq!(points("points = 1500").expect("a count"), Points::Count(1500));
        assert_eq!(points("points = \"1500\"").expect("a count"), Points::Count(1500));
        assert_eq!(points("points = \"2%\"").expect("a share"), Points::Share(0.02));
        for wrong in ["points = 1.5", "points = -3", "points = [1]"] {
            let said = points(wrong).expect_err("no count").to_string();
            assert!(said.starts_with("line 1, points: ") && said.contains("0.8%"), "{said}");
        }
    }

    #[test]
    fn errors_name_line_and_key() {
        let said = |text: &str| from_toml(text).expect_err("wrong").to_string();
        let unknown = said("# mine\npionts = \"3\"\n");
        assert!(unknown.starts_with("line 2: unknown field `pionts`"), "{unknown}");
        let kind = said("seed = 4\nclusters = \"many\"");
        assert!(kind.starts_with("line 2, clusters: invalid type"), "{kind}");
        let value = said("\n\noutline = \"blurple\"");
        assert!(value.starts_with("line 3, outline: 'blurple' is not a colour"), "{value}");
        assert_eq!(said("a"), said("a"));
        assert!(
            said("clusters = 4\nseed 4").starts_with("line 2"),
            "{}",
            said("clusters = 4\nseed 4")
        );
        let range = said("seed = 1\nclusters = 1");
        assert_eq!(range, "line 2: clusters is 1; it can be 2 to 64");
    }
}
