//! The command line of a look.

use std::fmt::Write;

use polyreel_core::Options;
use serde_json::Value;

use crate::look::{Look, difference};

/// The command line that makes `output` of `input` with `look`.
pub(crate) fn line(look: &Look, input: &str, output: &str, more: &str) -> String {
    let preset = look.preset.as_deref();
    let base = preset.and_then(|name| Options::preset(name).ok());
    let with_preset = preset.zip(base).and_then(|(name, base)| {
        let options = arguments(look, &base)?;
        Some(format!(" --preset {}{options}", quoted(name)))
    });
    // Options of the preset that are to be off cannot be written: all are written without it.
    let options = with_preset.or_else(|| arguments(look, &Options::default())).unwrap_or_default();
    let mut line = format!("polyreel render {} -o {}{options}", quoted(input), quoted(output));
    if !more.is_empty() {
        // Writing to a string cannot fail.
        let _ = write!(line, " {more}");
    }
    line
}

/// The options in which `look` differs from `base`, each after a space; `None` where one of them has no value.
fn arguments(look: &Look, base: &Options) -> Option<String> {
    let Value::Object(differing) = difference(&look.options, base) else { return None };
    let mut line = String::new();
    for (name, value) in &differing {
        let value = word(value)?;
        let separator = if name == "outline" { '=' } else { ' ' };
        let _ = write!(line, " --{name}{separator}{}", quoted(&value));
    }
    Some(line)
}

/// A value as the command line has it: several numbers with commas.
fn word(value: &Value) -> Option<String> {
    match value {
        Value::Null => None,
        Value::String(text) => Some(text.clone()),
        Value::Object(parts) => {
            let order = ["dark", "light", "high", "medium", "low"];
            let parts: Option<Vec<_>> =
                order.iter().filter_map(|name| parts.get(*name)).map(word).collect();
            Some(parts?.join(","))
        }
        other => Some(other.to_string()),
    }
}

/// A word for a shell.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./%,:=+".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_line_names_what_differs() {
        let said = |settings: &str| {
            let look = Look::of(settings).expect(settings);
            line(&look, "my cat.png", "out.png", "")
        };
        let begin = "polyreel render 'my cat.png' -o out.png";
        assert_eq!(said("{}"), begin);
        assert_eq!(said(r#"{"preset": "bold"}"#), format!("{begin} --preset bold"));
        let line = said(r##"{"preset": "bold", "points": "700", "outline": "#fff"}"##);
        assert_eq!(line, format!("{begin} --preset bold --outline='#ffffff' --points 700"));
        // What a preset has cannot be taken away.
        let line = said(r#"{"preset": "sketch", "outline": null}"#);
        assert!(!line.contains("preset") && !line.contains("outline=") && line.contains("--wash"));
        let line = said(r#"{"thresholds": {"high": 0.5, "medium": 0.2, "low": 0.1}}"#);
        assert_eq!(line, format!("{begin} --thresholds 0.5,0.2,0.1"));
    }
}
