//! What ffprobe tells of a video: size, times, colour, sound.

use std::ffi::OsString;
use std::io::Read;
use std::path::Path;

use serde_json::Value;

use crate::colour::{Coding, Layout, Sampling, Siting};
use crate::error::{Error, Result};
use crate::ffmpeg::Ffmpeg;
use crate::ffmpeg::child::Child;
use crate::ffmpeg::command::{address, arguments, input_format, is_camera, is_url};
use crate::ffmpeg::fields::{clock, decimal, fraction, text};
use crate::frame::{Colorimetry, Rational, check_size};
use crate::geom::Size;
use crate::stream::{Loops, StreamInfo};

/// More than this ffprobe has not to say.
const MAX_ANSWER: u64 = 4 << 20;

/// What is asked for.
const ENTRIES: &str = "stream=index,codec_name,codec_type,width,height,pix_fmt,\
    sample_aspect_ratio,color_range,color_space,color_transfer,color_primaries,chroma_location,\
    r_frame_rate,avg_frame_rate,time_base,start_pts,duration_ts,nb_frames,sample_rate,channels\
    :stream_disposition=attached_pic:stream_tags=DURATION,alpha_mode,rotate\
    :stream_side_data=rotation:format=format_name,start_time,duration";

/// How pixels come through the pipe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Pixels {
    /// Planes of 8 bits.
    Planar(Layout, Coding),
    /// Red, green, blue, alpha.
    Rgba,
}

/// The video stream to be read.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    /// Its number in the container.
    pub(crate) index: u64,
    /// Seconds of a unit of its times.
    pub(crate) time_base: Rational,
    /// ffmpeg's name of the pixel format to ask for.
    pub(crate) format: &'static str,
    /// The same for us.
    pub(crate) pixels: Pixels,
    /// The decoder to ask for where ffmpeg's own choice loses alpha.
    pub(crate) decoder: Option<&'static str>,
    /// The moment of the container's clock that is our 0; of what is live, the first frame's.
    pub(crate) zero: Option<Rational>,
    /// The end that the container promises, in seconds.
    pub(crate) end: Option<Rational>,
    /// Whether the container tells where its frames lie, so that one need not begin at the first.
    pub(crate) has_index: bool,
}

impl Track {
    /// Bytes of a frame of `size`.
    pub(crate) fn bytes(&self, size: Size) -> usize {
        match self.pixels {
            Pixels::Planar(layout, _) => layout.bytes(),
            Pixels::Rgba => size.pixels() * 4,
        }
    }
}

/// The sound of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SoundTracks {
    /// The codec of each track in ffmpeg's words; none if there is nothing to hear.
    pub(crate) codecs: Vec<String>,
    /// What our times are ahead of ffmpeg's, which begin at 0 with the first stream.
    pub(crate) shift: Rational,
    /// When the picture beside it begins, in our times, if there is one and it is told.
    pub(crate) picture: Option<Rational>,
}

/// Everything that ffprobe told.
#[derive(Clone, Debug)]
pub(crate) struct Probed {
    pub(crate) info: StreamInfo,
    pub(crate) track: Track,
    pub(crate) sound: SoundTracks,
}

/// Asks ffprobe about `path`.
fn ask(path: &Path, ffmpeg: &Ffmpeg) -> Result<Value> {
    let fail = |what: String| Error::input(path, what);
    let mut args = arguments([&"-v", &"level+error", &"-of", &"json"]);
    args.extend(arguments([&"-show_entries", &ENTRIES]));
    args.extend(input_format(path));
    args.extend([OsString::from("-i"), address(path)]);
    let mut probe = Child::ffprobe(ffmpeg, &args).map_err(fail)?;
    if is_url(path) || is_camera(path) {
        probe.be_patient();
    }
    let mut answer = String::new();
    if let Some(stdout) = probe.stdout() {
        stdout
            .take(MAX_ANSWER)
            .read_to_string(&mut answer)
            .map_err(|error| fail(format!("ffprobe's answer cannot be read: {error}")))?;
    }
    let status = probe.wait().map_err(|error| fail(format!("ffprobe: {error}")))?;
    if !status.success() {
        return Err(fail(format!("ffmpeg cannot read it: {}", probe.last_words())));
    }
    serde_json::from_str(&answer).map_err(|error| fail(format!("ffprobe's answer: {error}")))
}

/// Probes the first video stream of `path` that is not a cover picture.
///
/// # Errors
/// When ffprobe is missing, cannot read the file, or there is no video that we can work on.
pub(crate) fn probe(path: &Path, ffmpeg: &Ffmpeg) -> Result<Probed> {
    let answer = ask(path, ffmpeg)?;
    let stream = picture(&answer).ok_or_else(|| Error::input(path, "there is no video in it"))?;
    if text(&answer["format"], "format_name") == Some("tty") {
        // ffmpeg takes any text for a film of a terminal.
        return Err(Error::input(path, "is text, neither a picture nor a video"));
    }
    let pix_fmt = text(stream, "pix_fmt")
        .ok_or_else(|| Error::input(path, "ffmpeg has no decoder for this video"))?;
    let size = shown_size(stream).ok_or_else(|| Error::input(path, "the video has no size"))?;
    check_size(size).map_err(|error| Error::input(path, error.to_string()))?;
    let codec = codec(stream);
    let decoder = alpha_decoder(stream, codec);
    let (format, sampling, alpha) = pipe_format(pix_fmt, decoder.is_some());
    let tags = colorimetry(stream);
    let pixels = match sampling {
        Some(sampling) => {
            let siting = match text(stream, "chroma_location") {
                Some("center") => Siting::Centre,
                None if pix_fmt.starts_with("yuvj") => Siting::Centre,
                _ => Siting::Left,
            };
            let alpha = alpha && format != "gray";
            Pixels::Planar(Layout { size, sampling, siting, alpha }, Coding::of(&tags, size))
        }
        None => Pixels::Rgba,
    };
    let time_base = text(stream, "time_base").and_then(fraction).unwrap_or(Rational::new(1, 1000));
    let end = promised_end(&answer, stream, time_base);
    let container = text(&answer["format"], "format_name").unwrap_or("unknown");
    let info = StreamInfo {
        format: format!("{codec} in {}", container.split(',').next().unwrap_or(container)),
        size,
        frames: text(stream, "nb_frames").and_then(|n| n.parse().ok()),
        rate: rate(stream),
        duration: end.or_else(|| text(&answer["format"], "duration").and_then(decimal)),
        alpha,
        still: false,
        loops: Loops::Once,
        audio: streams(&answer, "audio").next().map(in_words),
        live: is_live(path, &answer),
        colour: sampling.is_some().then_some(tags),
    };
    let index = stream["index"].as_u64().unwrap_or(0);
    let zero = (!info.live).then(|| zero(&answer));
    // As ffmpeg names them, with their kin: mov,mp4,m4a,3gp,3g2,mj2 and matroska,webm.
    let has_index =
        !info.live && container.split(',').any(|name| matches!(name, "mp4" | "matroska"));
    let track = Track { index, time_base, format, pixels, decoder, zero, end, has_index };
    Ok(Probed { info, track, sound: sound_tracks(&answer) })
}

/// The sound of `path`, which need not have a picture.
///
/// # Errors
/// When ffprobe is missing or cannot read the file.
pub(crate) fn probe_sound(path: &Path, ffmpeg: &Ffmpeg) -> Result<SoundTracks> {
    Ok(sound_tracks(&ask(path, ffmpeg)?))
}

fn streams<'a>(answer: &'a Value, kind: &'a str) -> impl Iterator<Item = &'a Value> {
    let all = answer["streams"].as_array().map_or(&[][..], Vec::as_slice);
    all.iter().filter(move |stream| text(stream, "codec_type") == Some(kind))
}

fn sound_tracks(answer: &Value) -> SoundTracks {
    let codecs = streams(answer, "audio").map(|stream| codec(stream).to_string()).collect();
    let picture = picture(answer).and_then(begin).map(|begin| begin - zero(answer));
    SoundTracks { codecs, shift: origin(answer) - zero(answer), picture }
}

/// How long after the first stream of the file `path` its picture begins, in seconds.
///
/// # Errors
/// When ffprobe is missing or cannot read the file.
pub(crate) fn probe_lead(path: &Path, ffmpeg: &Ffmpeg) -> Result<Rational> {
    let answer = ask(path, ffmpeg)?;
    let begin = picture(&answer).and_then(begin).unwrap_or_else(|| origin(&answer));
    Ok(begin - origin(&answer))
}

/// The first video stream that is not a cover picture.
fn picture(answer: &Value) -> Option<&Value> {
    streams(answer, "video")
        .find(|stream| stream["disposition"]["attached_pic"].as_u64() != Some(1))
}

/// The moment at which a stream begins, by the container's clock.
fn begin(stream: &Value) -> Option<Rational> {
    let start = stream["start_pts"].as_i64()?;
    Some(Rational::new(start, 1) * text(stream, "time_base").and_then(fraction)?)
}

/// A track of sound in words.
fn in_words(stream: &Value) -> String {
    let rate = text(stream, "sample_rate").unwrap_or("?");
    let channels = stream["channels"].as_u64().unwrap_or(0);
    format!("{} {rate} Hz {channels} ch", codec(stream))
}

fn codec(stream: &Value) -> &str {
    text(stream, "codec_name").unwrap_or("unknown")
}

/// The rate in whose steps all frames are shown (some may be left out), if it is one that a camera
/// may have, else the mean one.
fn rate(stream: &Value) -> Option<Rational> {
    let nominal = text(stream, "r_frame_rate").and_then(fraction);
    let mean = text(stream, "avg_frame_rate").and_then(fraction);
    nominal.filter(|rate| mean.is_none() || *rate <= Rational::new(240, 1)).or(mean)
}

/// Width and height after the pixel aspect and the rotation are applied, as ffmpeg does it.
fn shown_size(stream: &Value) -> Option<Size> {
    let side = |key| stream[key].as_u64().and_then(|side| u32::try_from(side).ok());
    let (width, height) = (side("width")?, side("height")?);
    let aspect = text(stream, "sample_aspect_ratio").and_then(fraction);
    let stretched = aspect.map_or(f64::from(width), |a| f64::from(width) * a.to_f64());
    let width = stretched.round().clamp(1.0, f64::from(u32::MAX)) as u32;
    let turned = rotation(stream).rem_euclid(180.0);
    // As ffmpeg's own: within a degree of a quarter turn.
    let upright = (turned - 90.0).abs() >= 1.0;
    Some(if upright { Size::new(width, height) } else { Size::new(height, width) })
}

/// Degrees by which the picture is to be turned.
fn rotation(stream: &Value) -> f64 {
    let side_data = stream["side_data_list"].as_array().map_or(&[][..], Vec::as_slice);
    let told = side_data.iter().find_map(|data| data["rotation"].as_f64());
    told.or_else(|| stream["tags"]["rotate"].as_str()?.parse().ok()).unwrap_or(0.0)
}

fn colorimetry(stream: &Value) -> Colorimetry {
    let tag = |key| text(stream, key).map(str::to_string);
    Colorimetry {
        matrix: tag("color_space"),
        range: tag("color_range"),
        primaries: tag("color_primaries"),
        transfer: tag("color_transfer"),
    }
}

/// ffmpeg's own VP8 and VP9 decoders leave alpha out; the library's have it.
fn alpha_decoder(stream: &Value, codec: &str) -> Option<&'static str> {
    match (stream["tags"]["alpha_mode"].as_str()?, codec) {
        ("1", "vp8") => Some("libvpx"),
        ("1", "vp9") => Some("libvpx-vp9"),
        _ => None,
    }
}

/// The format to ask for when the stream has `pix_fmt`: the same where it has planes of 8 bits, else
/// what loses least; its sampling (`None` for RGB); and whether it has alpha.
fn pipe_format(pix_fmt: &str, with_alpha: bool) -> (&'static str, Option<Sampling>, bool) {
    use Sampling::{Gray, Yuv420, Yuv422, Yuv444};
    let has = |parts: &[&str]| parts.iter().any(|part| pix_fmt.contains(part));
    let alpha = with_alpha
        || pix_fmt.starts_with("ya")
        || has(&["yuva", "rgba", "bgra", "argb", "abgr", "gbrap", "pal8", "vuya", "ayuv"]);
    let sampling = if has(&["420", "nv12", "nv21", "p010", "p012", "p016"]) {
        Yuv420
    } else if has(&["422", "nv16", "nv20", "p210", "p216", "y210", "y212"]) {
        Yuv422
    } else if has(&["yuv", "nv24", "nv42", "p410", "p416", "vuy", "xv"]) {
        Yuv444
    } else if has(&["gray", "mono"]) {
        Gray
    } else {
        return ("rgba", None, alpha);
    };
    // The `j` formats are full range: asking for the others would make ffmpeg convert it.
    let full = pix_fmt.starts_with("yuvj");
    let format = match (sampling, alpha, full) {
        (Yuv420, true, _) => "yuva420p",
        (Yuv422, true, _) => "yuva422p",
        (Yuv444, true, _) => "yuva444p",
        (Yuv420, _, true) => "yuvj420p",
        (Yuv422, _, true) => "yuvj422p",
        (Yuv444, _, true) => "yuvj444p",
        (Yuv420, ..) => "yuv420p",
        (Yuv422, ..) => "yuv422p",
        (Yuv444, ..) => "yuv444p",
        (Gray, ..) => "gray",
    };
    (format, Some(sampling), alpha)
}

/// The moment at which the first stream begins, by the container's clock.
fn origin(answer: &Value) -> Rational {
    text(&answer["format"], "start_time").and_then(decimal).unwrap_or(Rational::ZERO)
}

/// Our 0. We keep the container's own clock if it starts within a second of 0: small offsets are an
/// encoder's run-in and are meant. One that starts anywhere, as that of MPEG-TS, is set to 0.
fn zero(answer: &Value) -> Rational {
    let origin = origin(answer);
    let one = Rational::new(1, 1);
    if origin > -one && origin < one { Rational::ZERO } else { origin }
}

/// The end of the video in seconds of our times, where the container tells it for
/// this stream alone.
fn promised_end(answer: &Value, stream: &Value, time_base: Rational) -> Option<Rational> {
    let zero = zero(answer);
    let scale = |ticks: i64| Rational::new(ticks, 1) * time_base;
    if let Some(duration) = stream["duration_ts"].as_i64().filter(|d| *d > 0) {
        let start = scale(stream["start_pts"].as_i64().unwrap_or(0));
        return Some(start + scale(duration) - zero);
    }
    stream["tags"]["DURATION"].as_str().and_then(clock).map(|end| end - zero)
}

/// Cameras and streams without an end.
fn is_live(path: &Path, answer: &Value) -> bool {
    is_camera(path) || is_url(path) && text(&answer["format"], "duration").is_none()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn sizes_are_those_that_are_shown() {
        let stream = json!({"width": 720, "height": 576, "sample_aspect_ratio": "16:15",
            "side_data_list": [{"rotation": -90}]});
        assert_eq!(shown_size(&stream), Some(Size::new(576, 768)));
        let plain = json!({"width": 3, "height": 5, "sample_aspect_ratio": "0:1"});
        assert_eq!(shown_size(&plain), Some(Size::new(3, 5)));
    }

    #[test]
    fn formats_keep_what_they_can() {
        assert_eq!(pipe_format("yuv420p", false).0, "yuv420p");
        assert_eq!(pipe_format("yuvj422p", false).0, "yuvj422p");
        assert_eq!(pipe_format("yuv422p10le", false).0, "yuv422p");
        assert_eq!(pipe_format("nv12", false).0, "yuv420p");
        assert_eq!(pipe_format("yuva444p12le", false), ("yuva444p", Some(Sampling::Yuv444), true));
        assert_eq!(pipe_format("gbrp", false), ("rgba", None, false));
        assert_eq!(pipe_format("bgra", false), ("rgba", None, true));
        assert_eq!(pipe_format("yuv420p", true).0, "yuva420p");
        assert_eq!(pipe_format("gray10le", false).0, "gray");
        assert_eq!(pipe_format("ya8", false), ("rgba", None, true));
    }

    #[test]
    fn rates_are_nominal_when_kept() {
        let rate = |r, avg| rate(&json!({"r_frame_rate": r, "avg_frame_rate": avg}));
        assert_eq!(rate("30000/1001", "19001/634"), Some(Rational::new(30000, 1001)));
        assert_eq!(rate("50/1", "20/1"), Some(Rational::new(50, 1)));
        assert_eq!(rate("1000/1", "20/1"), Some(Rational::new(20, 1)));
        assert_eq!(rate("25/1", "0/0"), Some(Rational::new(25, 1)));
        assert_eq!(rate("0/0", "0/0"), None);
    }
}
