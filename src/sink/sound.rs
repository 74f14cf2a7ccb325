//! The streams of a video besides the picture: sound, subtitles, chapters and titles; their sources, and ffmpeg's
//! options for them.

use std::ffi::{OsStr, OsString};
use std::fmt::Write as _;
use std::path::PathBuf;

use crate::error::Result;
use crate::ffmpeg::command::{address, arguments, is_url, moved, seconds};
use crate::ffmpeg::formats::input_format;
use crate::ffmpeg::probe::{SoundTracks, probe_sound};
use crate::ffmpeg::side::SoundPipe;
use crate::ffmpeg::tracks::{Chapter, MediaTrack, Metadata, TIMECODE};
use crate::frame::Rational;
use crate::sink::container::Container;
use crate::sink::spec::VideoOptions;
use crate::source::{Sound, decode::read_along};

/// The streams that are added, and their metadata.
pub(crate) struct Streams {
    source: Sound,
    tracks: SoundTracks,
    /// The subtitles that the container takes, and the encoder for each.
    subtitles: Vec<(MediaTrack, &'static str)>,
}

/// The longest list of chapters: it is one argument of a command line, and Linux allows 128 KiB for that.
const CHAPTERS: usize = 100_000;

impl Streams {
    /// The streams of the source that `container` takes and `video` wants; `None` if there is none. Adds
    /// warnings about streams that are left out.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(crate) fn of(
        source: &Sound,
        container: &Container,
        video: &VideoOptions,
        warnings: &mut Vec<String>,
    ) -> Result<Option<Self>> {
        let mut tracks = match &source.tracks {
            Some(tracks) => tracks.clone(),
            None => probe_sound(&source.path, &video.ffmpeg)?,
        };
        if !container.has_sound() {
            return Ok(None);
        }
        if !video.metadata {
            tracks.extras.forget();
        }
        if source.start > Rational::ZERO {
            // That of another frame.
            tracks.extras.metadata.retain(|(key, _)| key != TIMECODE);
        }
        let audio = video.audio;
        let mut pipe = source.pipe.as_ref().filter(|_| audio && !tracks.extras.sound.is_empty());
        if let Some(error) = pipe.and_then(|pipe| pipe.open().err()) {
            warnings.push(format!("{}: without its sound: {error}", source.path.display()));
            (pipe, tracks.extras.sound) = (None, Vec::new());
        }
        if pipe.is_some() {
            // Decoded, and by numbers of their own.
            for (index, track) in (0..).zip(&mut tracks.extras.sound) {
                (track.index, track.codec) = (index, "decoded".into());
            }
            tracks.repair = None;
        }
        if source.pipe.is_some() {
            tracks.extras.subtitles.clear();
        }
        if !audio {
            tracks.extras.sound.clear();
            tracks.extras.unreadable.clear();
        }
        for index in &tracks.extras.unreadable {
            warnings.push(format!(
                "{}: stream {index} is left out: this ffmpeg cannot decode its sound",
                source.path.display()
            ));
        }
        let mut subtitles = Vec::new();
        for track in &tracks.extras.subtitles {
            match container.subtitle_encoder(&track.codec) {
                Some(encoder) => subtitles.push((track.clone(), encoder)),
                None => warnings.push(format!(
                    "{}: stream {} is left out: {} takes no subtitles of the kind {}",
                    source.path.display(),
                    track.index,
                    container.muxer(),
                    track.codec
                )),
            }
        }
        let streams = Self { source: source.clone(), tracks, subtitles };
        let extras = &streams.tracks.extras;
        let any = streams.has_media() || !extras.chapters.is_empty() || !extras.metadata.is_empty();
        Ok(any.then_some(streams))
    }

    pub(crate) fn source(&self) -> &Sound {
        &self.source
    }

    /// Whether there is sound or a subtitle; otherwise only chapters and titles.
    fn has_media(&self) -> bool {
        !self.tracks.extras.sound.is_empty() || !self.subtitles.is_empty()
    }

    /// Whether they can be added while the picture is encoded: the picture begins at 0, to where ffmpeg moves it, the
    /// streams need not be cut as far as is known, and the picture does not have to wait for a network.
    pub(crate) fn go_along(&self) -> bool {
        if self.is_piped() {
            return true;
        }
        let Sound { path, start, cut, .. } = &self.source;
        let at_once = self.tracks.picture == Some(Rational::ZERO) && *start == Rational::ZERO;
        !self.has_media() && !cut || at_once && !cut && !is_url(path)
    }

    /// Whether they can be read only once, along with the picture.
    pub(crate) fn is_piped(&self) -> bool {
        self.source.pipe.is_some()
    }

    /// Lets what is piped end.
    pub(crate) fn end_pipe(&self) {
        if let Some(pipe) = &self.source.pipe {
            pipe.close();
        }
    }

    /// The folder of the pipe that they come through.
    pub(crate) fn folder(&self) -> Option<PathBuf> {
        self.source.pipe.as_ref().and_then(SoundPipe::folder)
    }

    /// Options that read what the decoder sends. Times are those of the picture, and stay.
    fn piped(&self) -> Vec<OsString> {
        let Some(path) = self.source.pipe.as_ref().and_then(SoundPipe::path) else {
            return Vec::new();
        };
        let mut args = arguments([&"-copyts", &"-thread_queue_size", &"4096"]);
        args.extend(arguments([&"-probesize", &"32", &"-analyzeduration", &"0", &"-f", &"nut"]));
        args.extend([OsString::from("-i"), address(&path)]);
        args
    }

    /// Options that read the source, up to the time `end` of the picture if given. Its inputs come after the
    /// picture's.
    pub(crate) fn input(&self, end: Option<Rational>) -> Vec<OsString> {
        let mut args = Vec::new();
        if self.is_piped() {
            args.extend(self.piped());
        } else if self.has_media() {
            args.extend(self.begin());
            if let Some(end) = end {
                args.extend(arguments([&"-t", &seconds(end)]));
            }
            args.extend(self.tracks.repair.iter().flat_map(|repair| repair.reader.iter().cloned()));
            args.extend(input_format(&self.source.path));
            args.extend([OsString::from("-i"), address(&self.source.path)]);
        }
        let chapters = chapters(&self.tracks.extras.chapters, self.source.start, end);
        if !chapters.is_empty() {
            let list = format!("data:text/plain,{chapters}");
            args.extend(arguments([&"-f", &"ffmetadata", &"-i", &list]));
        }
        args
    }

    /// As [`Streams::input`], for an output that cannot be completed later: the streams end by `end`, where the picture
    /// is expected to end, if that is cut; and they are moved to a picture that ffmpeg moves to 0.
    pub(crate) fn input_now(&self, end: Option<Rational>) -> Vec<OsString> {
        let picture = self.tracks.picture.filter(|_| self.source.start == Rational::ZERO);
        let late =
            picture.filter(|_| !self.is_piped()).unwrap_or(Rational::ZERO).max(Rational::ZERO);
        let mut source = self.source.clone();
        source.start = source.start + late;
        let (tracks, subtitles) = (self.tracks.clone(), self.subtitles.clone());
        Self { source, tracks, subtitles }.input(end.filter(|_| self.source.cut))
    }

    /// Options that write the streams, copied if `container` takes them.
    pub(crate) fn output(&self, container: &Container, end: Option<Rational>) -> Vec<OsString> {
        // Not `-map_metadata -1`: that would remove the titles of chapters, too.
        let mut args = arguments([&"-map_metadata:g", &"-1", &"-map_metadata:s", &"-1"]);
        let extras = &self.tracks.extras;
        for (i, track) in extras.sound.iter().enumerate() {
            args.extend(arguments([&"-map", &format!("1:{}", track.index)]));
            args.extend(metadata(&format!("-metadata:s:a:{i}"), &titled(track, container)));
            args.extend(disposition(&format!("-disposition:a:{i}"), track));
            if self.is_piped() || !container.takes_sound(&track.codec) {
                args.extend(container.sound_encoder(i));
                continue;
            }
            args.extend(arguments([&format!("-c:a:{i}"), &"copy"]));
            if self.source.start > Rational::ZERO {
                // Without the packets between the seek point and the requested time.
                args.extend(arguments([&format!("-copypriorss:a:{i}"), &"0"]));
            }
        }
        for (i, (track, encoder)) in self.subtitles.iter().enumerate() {
            args.extend(arguments([&"-map", &format!("1:{}", track.index)]));
            args.extend(arguments([&format!("-c:s:{i}"), encoder]));
            args.extend(metadata(&format!("-metadata:s:s:{i}"), &titled(track, container)));
            args.extend(disposition(&format!("-disposition:s:{i}"), track));
        }
        args.extend(metadata("-metadata", &extras.metadata));
        let some = !chapters(&extras.chapters, self.source.start, end).is_empty();
        let input = if self.has_media() { "2" } else { "1" };
        args.extend(arguments([&"-map_chapters", &if some { input } else { "-1" }]));
        if self.is_piped() && self.source.cut && self.has_media() {
            // Sound that was sent already may go on after the picture.
            args.extend(arguments([&"-shortest"]));
        }
        args
    }

    /// Options after the output that also read the picture's stream, if ffmpeg repairs timestamps, so that it repairs
    /// them as it did for the picture.
    pub(crate) fn along(&self) -> Vec<OsString> {
        let picture = self.tracks.repair.as_ref().filter(|_| self.has_media());
        let picture = picture.and_then(|repair| repair.streams.first());
        picture.map(|stream| read_along(1, *stream)).unwrap_or_default()
    }

    /// Options that make the start of the picture time 0.
    fn begin(&self) -> Vec<OsString> {
        let seek = self.source.start - self.tracks.shift;
        if self.source.start > Rational::ZERO && seek > Rational::ZERO {
            arguments([&"-ss", &seconds(seek)])
        } else {
            moved(-seek)
        }
    }
}

/// Languages that QuickTime has numbers for: the names of ISO 639 that ffmpeg loses in a MOV, and those that it knows.
const QUICKTIME_LANGUAGES: [(&str, &str); 20] = [
    ("bod", "tib"),
    ("cym", "wel"),
    ("cze", "ces"),
    ("deu", "ger"),
    ("ell", "gre"),
    ("eus", "baq"),
    ("fas", "per"),
    ("fre", "fra"),
    ("hye", "arm"),
    ("isl", "ice"),
    ("kat", "geo"),
    ("mkd", "mac"),
    ("msa", "may"),
    ("mya", "bur"),
    ("nld", "dut"),
    ("rum", "ron"),
    ("slo", "slk"),
    ("sqi", "alb"),
    ("swe", "sve"),
    ("zho", "chi"),
];

/// The tags of `track`. In QuickTime's containers ffmpeg loses titles; players show the handler's name for one.
fn titled(track: &MediaTrack, container: &Container) -> Metadata {
    let mut tags = track.metadata.clone();
    let title = tags.iter().find(|(key, _)| key == "title").map(|(_, title)| title.clone());
    if let Some(title) = title.filter(|_| container.is_quicktime()) {
        tags.push(("handler_name".into(), title));
    }
    for (_, language) in tags.iter_mut().filter(|(key, _)| key == "language") {
        let names = QUICKTIME_LANGUAGES
            .iter()
            .find(|(name, _)| *container == Container::Mov && name == language);
        if let Some((_, name)) = names {
            *language = (*name).into();
        }
    }
    tags
}

/// Option `option` that says what `track` is for.
fn disposition(option: &str, track: &MediaTrack) -> Vec<OsString> {
    let words = track.disposition.join("+");
    arguments([&option, &if words.is_empty() { "0" } else { words.as_str() }])
}

/// Options `option` that set `pairs`.
fn metadata(option: &str, pairs: &Metadata) -> Vec<OsString> {
    let pair = |(key, value): &(String, String)| {
        // Without characters that would end an argument.
        arguments([&option, &format!("{key}={}", value.replace('\0', " "))])
    };
    pairs.iter().flat_map(pair).collect()
}

/// The `chapters` between `start` and `end` as a file of ffmpeg's metadata, times counted from `start`; empty if
/// there are none.
fn chapters(chapters: &[Chapter], start: Rational, end: Option<Rational>) -> String {
    let mut list = String::new();
    for chapter in chapters {
        let from = (chapter.start - start).max(Rational::ZERO);
        let until = chapter.end - start;
        let until = end.map_or(until, |end| until.min(end));
        if until <= from {
            continue;
        }
        let escaped = chapter.title.chars().flat_map(|c| match c {
            '=' | ';' | '#' | '\\' | '\n' => vec!['\\', c],
            '\0' => vec![' '],
            c => vec![c],
        });
        let title: String = escaped.collect();
        let ms = |time: Rational| (time.to_f64() * 1000.0).round() as i64;
        let before = list.len();
        // Writing to a string cannot fail.
        let _ = write!(
            list,
            "\n[CHAPTER]\nTIMEBASE=1/1000\nSTART={}\nEND={}\ntitle={title}\n",
            ms(from),
            ms(until)
        );
        if list.len() > CHAPTERS {
            list.truncate(before);
            break;
        }
    }
    if list.is_empty() { list } else { format!(";FFMETADATA1{list}") }
}

/// Splits the user's own options into those of the picture and those of the sound.
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

    #[test]
    fn chapters_are_cut_with_the_picture() {
        let second = |n| Rational::new(n, 1);
        let chapter = |from, until, title: &str| Chapter {
            start: second(from),
            end: second(until),
            title: title.into(),
        };
        let all = [chapter(0, 2, "a"), chapter(2, 4, "b=c"), chapter(4, 6, "d")];
        let text = chapters(&all, second(1), Some(second(2)));
        assert_eq!(
            text,
            ";FFMETADATA1\n[CHAPTER]\nTIMEBASE=1/1000\nSTART=0\nEND=1000\ntitle=a\n\
             \n[CHAPTER]\nTIMEBASE=1/1000\nSTART=1000\nEND=2000\ntitle=b\\=c\n"
        );
        assert!(chapters(&all, second(9), None).is_empty());
    }
}
