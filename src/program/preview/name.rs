//! Names of the files that keys write: derived from the input, never those of existing files.

use std::ffi::OsString;
use std::path::Path;

/// The base name of files for `inputs`.
pub(super) fn stem(inputs: &[OsString]) -> String {
    let first = inputs.first().map(|input| input.to_string_lossy()).unwrap_or_default();
    if first == "-" {
        return "stdin".to_owned();
    }
    // Of an address only the path names anything.
    let path = first.split(['?', '#']).next().unwrap_or(&first);
    let stem = Path::new(path).file_stem().unwrap_or_default().to_string_lossy();
    let plain: String = stem
        .chars()
        .map(|c| if c.is_alphanumeric() || "-_. ".contains(c) { c } else { '_' })
        .collect();
    let plain = plain.trim_matches(['_', ' ', '.']);
    if plain.is_empty() { "preview".to_owned() } else { plain.to_owned() }
}

/// The name `base.extension`, with a number in it if there is a file of that name.
pub(super) fn free(base: &str, extension: &str) -> String {
    first_free(base, extension, |name| Path::new(name).exists())
}

fn first_free(base: &str, extension: &str, taken: impl Fn(&str) -> bool) -> String {
    let numbered = (2u64..).map(|n| format!("{base}-{n}.{extension}"));
    let mut names = std::iter::once(format!("{base}.{extension}")).chain(numbered);
    names.find(|name| !taken(name)).expect("there are more numbers than files")
}

/// A time in a file's name: `0m03.250s`.
pub(super) fn moment(seconds: f64) -> String {
    let ms = (seconds.max(0.0) * 1000.0).round() as u64;
    format!("{}m{:02}.{:03}s", ms / 60_000, ms / 1000 % 60, ms % 1000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_called_after_the_input() {
        let of = |input: &str| stem(&[input.into()]);
        assert_eq!(of("clips/dance.mp4"), "dance");
        assert_eq!(of("frames/"), "frames");
        assert_eq!(of("/dev/video0"), "video0");
        assert_eq!(of("http://host/live.m3u8?key=1"), "live");
        assert_eq!(of("shots/*.png"), "preview");
        assert_eq!(of("shot%03d.png"), "shot_03d");
        assert_eq!(of("-"), "stdin");
    }

    #[test]
    fn no_file_is_replaced() {
        let there = ["a.png", "a-2.png"];
        assert_eq!(first_free("a", "png", |name| there.contains(&name)), "a-3.png");
        assert_eq!(first_free("b", "png", |name| there.contains(&name)), "b.png");
        assert_eq!(moment(63.25), "1m03.250s");
    }
}
