//! The sound that goes beside a picture: where it comes from, and the words for it.

use std::ffi::{OsStr, OsString};

use crate::error::Result;
use crate::ffmpeg::Ffmpeg;
use crate::ffmpeg::command::{address, arguments, is_url, seconds};
use crate::ffmpeg::probe::{SoundTracks, probe_sound};
use crate::frame::Rational;
use crate::sink::codec::Container;

use crate::source::Sound;

/// The sound streams that are to be put in.
pub(crate) struct Streams {
    source: Sound,
    tracks: SoundTracks,
}

impl Streams {
    /// Those of the source; `None` when there is nothing to hear.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(crate) fn of(source: &Sound, ffmpeg: &Ffmpeg) -> Result<Option<Self>> {
        let tracks = match &source.tracks {
            Some(tracks) => tracks.clone(),
            None => probe_sound(&source.path, ffmpeg)?,
        };
        Ok((!tracks.codecs.is_empty()).then(|| Self { source: source.clone(), tracks }))
    }

    pub(crate) fn source(&self) -> &Sound {
        &self.source
    }

    /// Whether they can be put in while the picture is encoded: it begins at 0, to where ffmpeg moves
    /// it, they are not to end before their own end, as far as is known, and no network can keep the
    /// picture waiting.
    pub(crate) fn go_along(&self) -> bool {
        let Sound { path, start, cut, .. } = &self.source;
        let at_once = self.tracks.picture == Some(Rational::ZERO) && *start == Rational::ZERO;
        at_once && !cut && !is_url(path)
    }

    /// Options that read it, up to the time `end` of the picture if that is given.
    pub(crate) fn input(&self, end: Option<Rational>) -> Vec<OsString> {
        let mut args = self.begin();
        if let Some(end) = end {
            args.extend(arguments([&"-t", &seconds(end)]));
        }
        args.extend([OsString::from("-i"), address(&self.source.path)]);
        args
    }

    /// Options that write it, copied where `container` takes it.
    pub(crate) fn output(&self, container: Container) -> Vec<OsString> {
        let mut args = arguments([&"-map", &"1:a"]);
        for (i, codec) in self.tracks.codecs.iter().enumerate() {
            if !container.takes_sound(codec) {
                args.extend(container.sound_encoder(i));
                continue;
            }
            args.extend(arguments([&format!("-c:a:{i}"), &"copy"]));
            if self.source.start > Rational::ZERO {
                // Not what lies between the seek point and the moment that was sought.
                args.extend(arguments([&format!("-copypriorss:a:{i}"), &"0"]));
            }
        }
        args
    }

    /// Options that make the moment at which the picture begins the time 0.
    fn begin(&self) -> Vec<OsString> {
        let seek = self.source.start - self.tracks.shift;
        if self.source.start > Rational::ZERO && seek > Rational::ZERO {
            arguments([&"-ss", &seconds(seek)])
        } else {
            // Never 0: of an offset that is not ours ffmpeg takes the liberty to change it, where
            // (MPEG-TS) streams that we do not want begin before those that we do.
            let offset = seconds(-seek);
            arguments([&"-itsoffset", &if offset == "0us" { "1us" } else { offset.as_str() }])
        }
    }
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
}
