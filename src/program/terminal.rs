//! Messages on standard error.
//!
//! Text from elsewhere (file names, headers, keys) is escaped before it reaches the terminal. A standard error that
//! is full or closed is not a failure: messages are dropped then.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::Write;

/// Prints `message` on a line, after the program's name.
pub(crate) fn say(message: impl Display) {
    // One write, so that lines of several threads do not mix.
    let line = format!("polyreel: {}\n", escape(&message.to_string()));
    let _ = std::io::stderr().write_all(line.as_bytes());
}

/// Prints a warning; the run goes on.
pub(crate) fn warn(message: impl Display) {
    say(format_args!("warning: {message}"));
}

/// Prints several lines of the program's own.
pub(crate) fn say_lines(lines: &str) {
    let _ = std::io::stderr().write_all(lines.as_bytes());
}

/// `text` with characters escaped that a terminal interprets: control characters, line breaks among them, and those
/// that change the direction of text.
pub(crate) fn escape(text: &str) -> Cow<'_, str> {
    if !text.contains(is_active) {
        return text.into();
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_active(c) {
            escaped.extend(c.escape_default());
        } else {
            escaped.push(c);
        }
    }
    escaped.into()
}

/// The JSON `text` with the same characters escaped as JSON does it. Line breaks stay: in JSON those are
/// outside of strings.
pub(crate) fn escape_json(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        if is_active(c) && c != '\n' {
            escaped.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            escaped.push(c);
        }
    }
    escaped
}

/// Whether a terminal interprets `c` instead of showing it.
fn is_active(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped() {
        assert_eq!(escape("a\u{1b}]0;x\u{7}b\0"), "a\\u{1b}]0;x\\u{7}b\\u{0}");
        assert_eq!(escape("\u{9b}31m \u{202e}gnp.exe"), "\\u{9b}31m \\u{202e}gnp.exe");
        assert_eq!(escape("two\nlines\r"), "two\\nlines\\r");
        assert_eq!(escape("Fünf Äpfel 図.png"), "Fünf Äpfel 図.png");
    }

    #[test]
    fn escaped_json_means_the_same() {
        let text = "a\u{9b}\u{202e}\u{1b}é";
        let json = serde_json::to_string_pretty(&[text]).expect("plain data");
        let escaped = escape_json(&json);
        assert!(escaped.chars().all(|c| !is_active(c) || c == '\n'), "{escaped}");
        assert_eq!(serde_json::from_str::<[String; 1]>(&escaped).expect("JSON"), [text]);
    }
}
