//! Selects the streams of a file, and its metadata.

use serde_json::Value;

use super::fields::{decimal, text};
use crate::frame::Rational;

/// Pairs of a key and a value.
pub(crate) type Metadata = Vec<(String, String)>;

/// A stream of sound or subtitles.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MediaTrack {
    /// Its number in the container.
    pub(crate) index: u64,
    /// Its codec, by ffmpeg's name.
    pub(crate) codec: String,
    /// Its language and title.
    pub(crate) metadata: Metadata,
    /// What it is for, in ffmpeg's words: `default`, `forced`, `comment` ...
    pub(crate) disposition: Vec<&'static str>,
}

/// A chapter, in seconds of our times.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chapter {
    pub(crate) start: Rational,
    pub(crate) end: Rational,
    pub(crate) title: String,
}

/// The contents of a file besides the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Extras {
    /// Sound that ffmpeg can decode.
    pub(crate) sound: Vec<MediaTrack>,
    /// Numbers of the streams of sound that it cannot decode.
    pub(crate) unreadable: Vec<u64>,
    pub(crate) subtitles: Vec<MediaTrack>,
    pub(crate) chapters: Vec<Chapter>,
    /// Title, artist and the like of the whole.
    pub(crate) metadata: Metadata,
}

impl Extras {
    /// Forgets titles, languages, chapters and all other metadata.
    pub(crate) fn forget(&mut self) {
        (self.chapters, self.metadata) = (Vec::new(), Vec::new());
        self.sound.iter_mut().chain(&mut self.subtitles).for_each(|track| track.metadata.clear());
    }
}

/// The metadata keys that are kept; others belong to the container or the encoder.
const KEPT: [&str; 14] = [
    "title",
    "artist",
    "album",
    "album_artist",
    "composer",
    "genre",
    "date",
    "comment",
    "description",
    "synopsis",
    "copyright",
    "show",
    "network",
    "keywords",
];

/// What a track may be for.
const DISPOSITIONS: [&str; 9] = [
    "default",
    "dub",
    "original",
    "comment",
    "lyrics",
    "karaoke",
    "forced",
    "hearing_impaired",
    "visual_impaired",
];

/// Codecs of single pictures, which are covers where there is another video.
const PICTURES: [&str; 8] = ["png", "mjpeg", "bmp", "tiff", "webp", "gif", "jpegls", "jpegxl"];

/// The bonus of a default stream in the comparison of sizes, in pixels, as in ffmpeg.
const DEFAULT_BONUS: u64 = 5_000_000;

/// Streams of `kind`.
pub(crate) fn streams<'a>(answer: &'a Value, kind: &'a str) -> impl Iterator<Item = &'a Value> {
    let all = answer["streams"].as_array().map_or(&[][..], Vec::as_slice);
    all.iter().filter(move |stream| text(stream, "codec_type") == Some(kind))
}

/// The codec of a stream, by ffmpeg's name.
pub(crate) fn codec(stream: &Value) -> &str {
    text(stream, "codec_name").unwrap_or("unknown")
}

/// A tag of a stream. The case of keys is ignored: Matroska has capitals.
pub(crate) fn tag<'a>(value: &'a Value, key: &str) -> Option<&'a str> {
    let tags = value["tags"].as_object()?;
    tags.iter().find(|(own, _)| own.eq_ignore_ascii_case(key))?.1.as_str()
}

/// The video stream to read: as ffmpeg, the largest, those marked as the default first. Covers, and streams
/// that cannot be decoded, come last.
pub(crate) fn picture(answer: &Value) -> Option<&Value> {
    let is_picture = |stream: &Value| PICTURES.contains(&codec(stream));
    let score = |stream: &Value| {
        let side = |key| stream[key].as_u64().unwrap_or(0);
        let marked = stream["disposition"]["default"].as_u64() == Some(1);
        let pixels = side("width").saturating_mul(side("height"));
        let frames = text(stream, "nb_frames").and_then(|n| n.parse::<u64>().ok());
        (
            text(stream, "pix_fmt").is_some(),
            !is_picture(stream),
            // A picture in front of an animation (AVIF).
            frames != Some(1),
            pixels + if marked { DEFAULT_BONUS } else { 0 },
        )
    };
    let mut best: Option<&Value> = None;
    for stream in streams(answer, "video") {
        let attached = stream["disposition"]["attached_pic"].as_u64() == Some(1);
        if !attached && best.is_none_or(|best| score(stream) > score(best)) {
            best = Some(stream);
        }
    }
    best
}

/// The stream with the alpha of `picture` in a HEIF file: gray, of the same size, right after it.
pub(crate) fn alpha_stream(answer: &Value, picture: &Value) -> Option<u64> {
    let index = picture["index"].as_u64()?;
    let next =
        streams(answer, "video").find(|stream| stream["index"].as_u64() == Some(index + 1))?;
    let same = |key| next[key] == picture[key];
    let gray = text(next, "pix_fmt").is_some_and(|format| format.starts_with("gray"));
    (gray && same("width") && same("height")).then_some(index + 1)
}

/// The contents of the file besides its picture, with times counted from `zero`.
pub(crate) fn extras(answer: &Value, zero: Rational) -> Extras {
    let track = |stream: &Value| MediaTrack {
        index: stream["index"].as_u64().unwrap_or(0),
        codec: codec(stream).to_string(),
        metadata: kept(stream, &["language", "title"]),
        disposition: DISPOSITIONS
            .into_iter()
            .filter(|name| stream["disposition"][name].as_u64() == Some(1))
            .collect(),
    };
    // Without a decoder ffprobe does not know the format of the samples.
    let (sound, unreadable): (Vec<&Value>, _) =
        streams(answer, "audio").partition(|stream| text(stream, "sample_fmt").is_some());
    Extras {
        sound: sound.into_iter().map(track).collect(),
        unreadable: unreadable.into_iter().filter_map(|stream| stream["index"].as_u64()).collect(),
        subtitles: streams(answer, "subtitle").map(track).collect(),
        chapters: chapters(answer, zero),
        metadata: kept(&answer["format"], &KEPT).into_iter().chain(timecode(answer)).collect(),
    }
}

/// The timecode of the first frame, wherever the container has it.
fn timecode(answer: &Value) -> Option<(String, String)> {
    let all = answer["streams"].as_array().map_or(&[][..], Vec::as_slice);
    let code = all.iter().chain([&answer["format"]]).find_map(|part| tag(part, TIMECODE))?;
    Some((TIMECODE.into(), code.into()))
}

/// The tag of a timecode.
pub(crate) const TIMECODE: &str = "timecode";

/// What was found in a file besides frames, in words.
pub(crate) fn in_words(answer: &Value, picture: u64, extras: &Extras) -> Vec<String> {
    let mut notes = Vec::new();
    let covers = |stream: &&Value| stream["disposition"]["attached_pic"].as_u64() == Some(1);
    let films = streams(answer, "video").filter(|stream| !covers(stream)).count();
    if films > 1 {
        notes.push(format!("{films} video tracks: stream {picture} is read"));
    }
    let described = |track: &MediaTrack| -> String {
        let words = track.metadata.iter().map(|(_, value)| value.as_str());
        let words = words.chain([track.codec.as_str()]).chain(track.disposition.iter().copied());
        words.collect::<Vec<_>>().join(", ")
    };
    for (kind, tracks) in [("sound", &extras.sound), ("subtitles", &extras.subtitles)] {
        for track in tracks {
            notes.push(format!("{kind}: stream {}, {}", track.index, described(track)));
        }
    }
    if !extras.chapters.is_empty() {
        notes.push(format!("{} chapters", extras.chapters.len()));
    }
    let shown = ["title", "date", TIMECODE];
    let shown = extras.metadata.iter().filter(|(key, _)| shown.contains(&key.as_str()));
    notes.extend(shown.map(|(key, value)| format!("{key}: {value}")));
    notes
}

/// The tags of `value` with `keys`.
fn kept(value: &Value, keys: &[&str]) -> Metadata {
    let pair = |key: &&str| Some((key.to_string(), tag(value, key)?.to_string()));
    // "Undetermined" is what muxers write for none.
    keys.iter().filter_map(pair).filter(|(_, value)| value != "und").collect()
}

fn chapters(answer: &Value, zero: Rational) -> Vec<Chapter> {
    let all = answer["chapters"].as_array().map_or(&[][..], Vec::as_slice);
    let time = |chapter: &Value, key| Some(text(chapter, key).and_then(decimal)? - zero);
    let chapter = |chapter: &Value| {
        let (start, end) = (time(chapter, "start_time")?, time(chapter, "end_time")?);
        let title = tag(chapter, "title").unwrap_or("").to_string();
        Some(Chapter { start, end, title })
    };
    all.iter().filter_map(chapter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn video(index: u64, codec: &str, side: u64, default: u64) -> Value {
        json!({"index": index, "codec_type": "video", "codec_name": codec, "width": side,
            "height": side, "pix_fmt": "yuv420p",
            "disposition": {"default": default, "attached_pic": 0}})
    }

    #[test]
    fn the_largest_stream_that_is_no_cover_is_read() {
        let chosen = |streams: &[Value]| {
            picture(&json!({"streams": streams})).and_then(|stream| stream["index"].as_u64())
        };
        let small = video(1, "h264", 320, 0);
        assert_eq!(chosen(&[video(0, "mjpeg", 1000, 0), small.clone()]), Some(1));
        assert_eq!(chosen(&[small.clone(), video(2, "h264", 640, 0)]), Some(2));
        assert_eq!(chosen(&[video(0, "h264", 160, 1), small.clone()]), Some(0));
        assert_eq!(chosen(&[video(0, "h264", 320, 0), small]), Some(0), "the first of equals");
        let mut unknown = video(0, "none", 4000, 1);
        unknown["pix_fmt"] = Value::Null;
        assert_eq!(chosen(&[unknown, video(1, "mjpeg", 10, 0)]), Some(1));
    }

    #[test]
    fn tags_are_found_in_any_case() {
        let stream = json!({"tags": {"ALPHA_MODE": "1", "Language": "ger"}});
        assert_eq!(tag(&stream, "alpha_mode"), Some("1"));
        assert_eq!(kept(&stream, &["language", "title"]), [("language".into(), "ger".into())]);
    }

    #[test]
    fn sound_without_a_decoder_is_set_aside() {
        let answer = json!({"streams": [
            {"index": 1, "codec_type": "audio", "codec_name": "aac", "sample_fmt": "fltp"},
            {"index": 2, "codec_type": "audio", "codec_name": "apple_apac"}]});
        let extras = extras(&answer, Rational::ZERO);
        assert_eq!((extras.sound[0].index, extras.sound.len(), extras.unreadable), (1, 1, vec![2]));
    }
}
