//! Puts the sound of the source beside the finished picture.
//!
//! A second, quick run of ffmpeg: the picture is copied, the sound is copied if the container takes
//! it and else encoded. Doing it afterwards means that the length of the picture is known, however
//! the run came to its end, and that a slow picture never waits for sound or sound for it.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::frame::Rational;
use crate::sink::codec::Container;
use crate::source::child::{self, Child, arguments};
use crate::source::probe::probe_sound;

/// Where sound comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Sound {
    /// The video (or any file with sound).
    pub path: PathBuf,
    /// The moment of it, in seconds from its start, at which the picture begins.
    pub start: Rational,
    /// Whether the picture was asked to end before the source does: then the sound ends with the
    /// picture. Else it is kept whole, unless the picture turns out shorter than expected.
    pub cut: bool,
}

/// The sound streams that are to be put in.
pub(crate) struct Streams {
    source: Sound,
    codecs: Vec<String>,
    /// What the times of the source are ahead of ffmpeg's.
    shift: Rational,
}

impl Streams {
    /// Looks at the source; `None` when there is nothing to hear.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(crate) fn of(source: &Sound, ffmpeg: Option<&Path>) -> Result<Option<Self>> {
        let (sounds, shift) = probe_sound(&source.path, ffmpeg)?;
        let codecs: Vec<String> = sounds.into_iter().map(|sound| sound.codec).collect();
        Ok((!codecs.is_empty()).then(|| Self { source: source.clone(), codecs, shift }))
    }

    pub(crate) fn source(&self) -> &Sound {
        &self.source
    }

    /// Options that make the moment at which the picture begins the time 0.
    fn begin(&self) -> Vec<OsString> {
        let seek = self.source.start - self.shift;
        if self.source.start > Rational::ZERO && seek > Rational::ZERO {
            arguments([&"-ss", &seconds(seek)])
        } else {
            // Never 0: of an offset that is not ours ffmpeg takes the liberty to change it, where
            // (MPEG-TS) streams that we do not want begin before those that we do.
            let offset = seconds(-seek);
            arguments([&"-itsoffset", &if offset == "0us" { "1us" } else { &offset }])
        }
    }
}

/// The finished picture.
pub(crate) struct Picture<'a> {
    /// Where it is.
    pub(crate) path: &'a Path,
    /// When its first frame is shown, in seconds.
    pub(crate) first: Rational,
    /// The units of its times.
    pub(crate) time_base: Rational,
}

/// Writes picture and sound to `to`; the sound ends at `end` if that is given.
///
/// # Errors
/// What ffmpeg said when it failed.
pub(crate) fn join(
    picture: &Picture<'_>,
    streams: &Streams,
    end: Option<Rational>,
    to: &Path,
    container: Container,
    extra: &[OsString],
    ffmpeg: Option<&Path>,
) -> Result<(), String> {
    let mut args = arguments([&"-nostdin", &"-hide_banner", &"-loglevel", &"level+warning", &"-y"]);
    // ffmpeg moves every input to 0; this moves the picture back.
    args.extend(arguments([&"-itsoffset", &seconds(picture.first), &"-i"]));
    args.push(child::address(picture.path));
    args.extend(streams.begin());
    if let Some(end) = end {
        args.extend(arguments([&"-t", &seconds(end)]));
    }
    args.extend([OsString::from("-i"), child::address(&streams.source.path)]);
    args.extend(arguments([&"-map", &"0:v:0", &"-map", &"1:a", &"-c:v", &"copy"]));
    args.extend(arguments([&"-map_metadata", &"-1", &"-map_chapters", &"-1"]));
    for (i, codec) in streams.codecs.iter().enumerate() {
        if container.takes_sound(codec) {
            // Not what lies between the seek point and the moment that was sought.
            let prior = format!("-copypriorss:a:{i}");
            args.extend(arguments([&format!("-c:a:{i}"), &"copy"]));
            if streams.source.start > Rational::ZERO {
                args.extend(arguments([&prior, &"0"]));
            }
        } else {
            args.extend(container.sound_encoder(i));
        }
    }
    if !container.is_quicktime() {
        // An encoder's run-in before 0 must not push the picture to a later time: Matroska keeps it
        // as the codec's delay.
        args.extend(arguments([&"-avoid_negative_ts", &"disabled"]));
    }
    args.extend(extra.iter().cloned());
    args.extend(placing(container, picture.time_base, true));
    args.push(child::address(to));
    let mut ffmpeg = Child::spawn(&child::ffmpeg_program(ffmpeg), &args)?;
    let status = ffmpeg.wait().map_err(|error| error.to_string())?;
    // Complaints may come from damaged sound, which is no reason to lose the picture; a full disk is.
    let words = ffmpeg.last_words();
    if status.success() && !words.contains("No space left") { Ok(()) } else { Err(words) }
}

/// Options of the container, the last before the file: units of time, tables in front in the `last`
/// run.
pub(crate) fn placing(container: Container, time_base: Rational, last: bool) -> Vec<OsString> {
    let mut args = Vec::new();
    if container.is_quicktime() {
        args.extend(arguments([&"-video_track_timescale", &time_base.den.to_string()]));
        if last {
            args.extend(arguments([&"-movflags", &"+faststart"]));
        }
    }
    args.extend(arguments([&"-f", &container.muxer()]));
    args
}

/// ffmpeg's own way to write a time: whole microseconds.
fn seconds(time: Rational) -> String {
    let micros = (i128::from(time.num) * 2_000_000 / i128::from(time.den) + 1).div_euclid(2);
    format!("{micros}us")
}

/// Parts the user's own options into those of the picture and those of the sound.
pub(crate) fn part(args: &[String]) -> (Vec<OsString>, Vec<OsString>) {
    let (mut picture, mut sound) = (Vec::new(), Vec::new());
    let mut of_sound = false;
    for arg in args {
        if arg.starts_with('-') && !arg[1..].starts_with(|c: char| c.is_ascii_digit()) {
            let mut parts = arg[1..].split(':');
            let name = parts.next().unwrap_or("");
            of_sound = ["acodec", "ac", "ar", "af", "aq", "ab"].contains(&name)
                || parts.next() == Some("a");
        }
        if of_sound { &mut sound } else { &mut picture }.push(OsStr::new(arg).to_os_string());
    }
    (picture, sound)
}

/// Error about the output `path`.
pub(crate) fn failed(path: &Path, words: &str) -> Error {
    Error::output(path, format!("the sound could not be added: {words}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_sound_go_to_sound() {
        let args = ["-b:v", "5M", "-b:a", "96k", "-ac", "1", "-bf", "-1", "-g", "24"];
        let (picture, sound) = part(&args.map(String::from));
        assert_eq!(picture, ["-b:v", "5M", "-bf", "-1", "-g", "24"]);
        assert_eq!(sound, ["-b:a", "96k", "-ac", "1"]);
    }

    #[test]
    fn seconds_are_whole_microseconds() {
        assert_eq!(seconds(Rational::new(1001, 30000)), "33367us");
        assert_eq!(seconds(Rational::ZERO), "0us");
        assert_eq!(seconds(Rational::new(1, 3)), "333333us");
        assert_eq!(seconds(Rational::new(-7, 1000)), "-7000us");
    }
}
