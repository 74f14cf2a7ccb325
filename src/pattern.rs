//! File names with a number in them, as `printf` writes it: `frame_%04d.png`.

/// A file name with one place for a number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    before: String,
    width: usize,
    zeros: bool,
    after: String,
}

impl Pattern {
    /// Reads `text`; `None` if it holds no `%d`, `%4d` or `%04d`, or several. `%%` is a percent sign.
    pub fn parse(text: &str) -> Option<Self> {
        let (mut before, mut rest) = (String::new(), text);
        let mut place = None;
        while let Some(at) = rest.find('%') {
            before.push_str(&rest[..at]);
            rest = &rest[at + 1..];
            if let Some(after) = rest.strip_prefix('%') {
                before.push('%');
                rest = after;
                continue;
            }
            let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
            // A wider number than a file name can hold means something else.
            let width: usize = if digits == 0 { 0 } else { rest[..digits].parse().ok()? };
            if !rest[digits..].starts_with('d') || width > 64 || place.is_some() {
                return None;
            }
            place = Some((std::mem::take(&mut before), width, rest.starts_with('0')));
            rest = &rest[digits + 1..];
        }
        before.push_str(rest);
        let (head, width, zeros) = place?;
        Some(Self { before: head, width, zeros, after: before })
    }

    /// Names with a four-digit number and `extension` in `folder` (which ends in a separator).
    pub fn in_folder(folder: &str, extension: &str) -> Self {
        Self { before: folder.into(), width: 4, zeros: true, after: format!(".{extension}") }
    }

    /// The name with `number` in its place.
    pub fn name(&self, number: u64) -> String {
        let Self { before, width, zeros, after } = self;
        if *zeros {
            format!("{before}{number:0width$}{after}")
        } else {
            format!("{before}{number:width$}{after}")
        }
    }

    /// The number in `name`, if this pattern writes it so.
    pub fn number(&self, name: &str) -> Option<u64> {
        let inner = name.strip_prefix(self.before.as_str())?.strip_suffix(self.after.as_str())?;
        let number = inner.trim_start_matches(' ').parse().ok()?;
        (self.name(number) == name).then_some(number)
    }
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
            assert_eq!(pattern.name(number), name);
            assert_eq!(pattern.number(name), Some(number));
        }
        assert_eq!(Pattern::in_folder("out/", "png").name(1), "out/0001.png");
    }

    #[test]
    fn what_is_no_pattern_stays_a_name() {
        for text in ["a.png", "100%.png", "%s.png", "%d_%d.png", "%%d.png", "%-3d.png", "%"] {
            assert_eq!(Pattern::parse(text), None, "{text}");
        }
        let pattern = Pattern::parse("f%02d.png").expect("a pattern");
        for name in ["f7.png", "f007.png", "fx.png", "g07.png", "f+7.png"] {
            assert_eq!(pattern.number(name), None, "{name}");
        }
    }
}
