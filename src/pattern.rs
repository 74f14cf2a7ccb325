//! File names with a number, in the format of `printf`: `frame_%04d.png`.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// A file name with one place for a number. Names need not be UTF-8.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    before: Vec<u8>,
    width: usize,
    zeros: bool,
    after: Vec<u8>,
}

impl Pattern {
    /// Reads `text`; `None` if it holds no `%d`, `%4d` or `%04d`, or several. `%%` is a percent sign,
    /// and a `%d` that begins a word (`100%done`) is part of the name.
    pub fn parse(text: impl AsRef<OsStr>) -> Option<Self> {
        let mut rest = text.as_ref().as_encoded_bytes();
        let mut before = Vec::new();
        let mut number = None;
        while let Some(at) = rest.iter().position(|&b| b == b'%') {
            before.extend_from_slice(&rest[..at]);
            rest = &rest[at + 1..];
            if let Some(after) = rest.strip_prefix(b"%") {
                before.push(b'%');
                rest = after;
                continue;
            }
            let (width, zeros, after) = conversion(rest)?;
            if number.is_some() {
                return None;
            }
            number = Some((std::mem::take(&mut before), width, zeros));
            rest = after;
        }
        before.extend_from_slice(rest);
        let (head, width, zeros) = number?;
        Some(Self { before: head, width, zeros, after: before })
    }

    /// Names with a four-digit number and `extension` in `folder`.
    pub fn in_folder(folder: &Path, extension: &str) -> Self {
        // Joined with an empty name, a path ends in a separator.
        let before = folder.join("").into_os_string().as_encoded_bytes().to_vec();
        Self { before, width: 4, zeros: true, after: format!(".{extension}").into_bytes() }
    }

    /// The name with `number` in its place.
    pub fn name(&self, number: u64) -> PathBuf {
        let Self { before, width, zeros, after } = self;
        let number = if *zeros { format!("{number:0width$}") } else { format!("{number:width$}") };
        PathBuf::from(os_string([before, number.as_bytes(), after].concat()))
    }

    /// The number in `name`, if `name` is in the format of this pattern.
    pub fn number(&self, name: &Path) -> Option<u64> {
        let bytes = name.as_os_str().as_encoded_bytes();
        let inner = bytes.strip_prefix(&self.before[..])?.strip_suffix(&self.after[..])?;
        let number = std::str::from_utf8(inner).ok()?.trim_start_matches(' ').parse().ok()?;
        (self.name(number).as_os_str() == name.as_os_str()).then_some(number)
    }
}

/// The part after a percent sign: the width of the number, whether it is padded with zeros, and the text behind it.
fn conversion(text: &[u8]) -> Option<(usize, bool, &[u8])> {
    let digits = text.iter().take_while(|b| b.is_ascii_digit()).count();
    let (width, after) = text.split_at(digits);
    let zeros = width.starts_with(b"0");
    let width = if digits == 0 { 0 } else { std::str::from_utf8(width).ok()?.parse().ok()? };
    let after = after.strip_prefix(b"d")?;
    // `100%done.png` is a name. A number wider than a file name is not a number.
    let word = digits == 0 && after.first().is_some_and(u8::is_ascii_alphabetic);
    (!word && width <= 64).then_some((width, zeros, after))
}

/// A part of a name, from its bytes, which were split at ASCII characters.
#[cfg(unix)]
fn os_string(bytes: Vec<u8>) -> OsString {
    std::os::unix::ffi::OsStringExt::from_vec(bytes)
}

#[cfg(not(unix))]
fn os_string(bytes: Vec<u8>) -> OsString {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_write_numbers_as_printf_does() {
        for (text, number, name) in [
            ("f_%04d.png", 7, "f_0007.png"),
            ("f_%04d.png", 12345, "f_12345.png"),
            ("%d.jpg", 7, "7.jpg"),
            ("%3d.jpg", 7, "  7.jpg"),
            ("100%%/%02d%%.png", 3, "100%/03%.png"),
        ] {
            let pattern = Pattern::parse(text).expect(text);
            assert_eq!(pattern.name(number), Path::new(name));
            assert_eq!(pattern.number(Path::new(name)), Some(number));
        }
        assert_eq!(Pattern::in_folder(Path::new("out/"), "png").name(1), Path::new("out/0001.png"));
        assert_eq!(Pattern::in_folder(Path::new("out"), "png").name(1), Path::new("out/0001.png"));
    }

    #[test]
    fn what_is_not_a_pattern_stays_a_name() {
        for text in
            ["a.png", "100%.png", "100%done.png", "%s.png", "%d_%d.png", "%%d.png", "%-3d.png", "%"]
        {
            assert_eq!(Pattern::parse(text), None, "{text}");
        }
        let pattern = Pattern::parse("f%02d.png").expect("a pattern");
        for name in ["f7.png", "f007.png", "fx.png", "g07.png", "f+7.png"] {
            assert_eq!(pattern.number(Path::new(name)), None, "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn names_need_not_be_utf8() {
        use std::os::unix::ffi::OsStrExt;
        let pattern = Pattern::parse(OsStr::from_bytes(b"caf\xe9_%02d.png")).expect("a pattern");
        let name = PathBuf::from(OsStr::from_bytes(b"caf\xe9_07.png"));
        assert_eq!(pattern.name(7), name);
        assert_eq!(pattern.number(&name), Some(7));
    }
}
