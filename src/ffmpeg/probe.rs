//! What ffprobe tells of a video: size, times, colour, sound.

use std::ffi::OsString;
use std::io::Read;
use std::path::Path;

use serde_json::Value;

use crate::colour::{Coding, Layout, Siting};
use crate::error::{Error, Result};
use crate::ffmpeg::Ffmpeg;
use crate::ffmpeg::child::Child;
use crate::ffmpeg::command::{address, arguments, is_camera, is_url};
use crate::ffmpeg::fields::{clock, decimal, fraction, text};
use crate::ffmpeg::formats::{input_format, is_list, is_still, mending, restarts};
use crate::ffmpeg::heif::{self, Heif};
use crate::ffmpeg::pixels::{alpha_decoder, pipe_format};
use crate::ffmpeg::tracks::{Extras, alpha_stream, codec, extras, picture, streams, tag};
use crate::frame::{Colorimetry, Rational, check_size};
use crate::geom::Size;
use crate::stream::{Loops, StreamInfo};

/// More than this ffprobe has not to say.
const MAX_ANSWER: u64 = 4 << 20;

/// What is asked for.
const ENTRIES: &str = "stream=index,codec_name,codec_type,width,height,pix_fmt,sample_fmt,\
    sample_aspect_ratio,color_range,color_space,color_transfer,color_primaries,chroma_location,\
    r_frame_rate,avg_frame_rate,time_base,start_pts,duration_ts,nb_frames,sample_rate,channels\
    :stream_disposition=attached_pic,default:stream_tags\
    :stream_side_data=rotation:format=format_name,start_time,duration,size:format_tags\
    :chapter=start_time,end_time:chapter_tags=title";

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
    /// The clock of the container, where it may start again.
    pub(crate) repair: Option<Repair>,
    /// Whether it is one picture.
    pub(crate) still: bool,
    /// Filters of ffmpeg that come before all others, each with a comma behind it.
    pub(crate) filters: String,
    /// The stream that is its transparency.
    pub(crate) alpha: Option<u64>,
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

/// How ffmpeg is asked to mend a clock that may start again. It looks at all streams that are read: picture and
/// sound are mended alike only where both are.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Repair {
    /// Options that choose the reader.
    pub(crate) reader: Vec<OsString>,
    /// What ffmpeg's times, which begin at 0 with the first stream, are to be moved by.
    pub(crate) offset: Rational,
    /// The streams that are read, the picture's first.
    pub(crate) streams: Vec<u64>,
}

/// What goes into a video besides the picture, and its times.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SoundTracks {
    pub(crate) extras: Extras,
    /// What our times are ahead of ffmpeg's, which begin at 0 with the first stream.
    pub(crate) shift: Rational,
    /// When the picture beside it begins, in our times, if there is one and it is told.
    pub(crate) picture: Option<Rational>,
    /// How its clock is mended.
    pub(crate) repair: Option<Repair>,
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
    run(path, ffmpeg, &[], ENTRIES)
}

/// Asks ffprobe for `entries` of `path`, with further options.
fn run(path: &Path, ffmpeg: &Ffmpeg, options: &[&str], entries: &str) -> Result<Value> {
    let fail = |what: String| Error::input(path, what);
    let mut args = arguments([&"-v", &"level+error", &"-of", &"json"]);
    args.extend(options.iter().map(OsString::from));
    args.extend(arguments([&"-show_entries", &entries]));
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
        return Err(fail(unreadable(path, &probe.last_words())));
    }
    serde_json::from_str(&answer).map_err(|error| fail(format!("ffprobe's answer: {error}")))
}

/// Why ffprobe could not read `path`, with what helps.
fn unreadable(path: &Path, words: &str) -> String {
    let heif = !is_url(path) && heif::read(path).is_some();
    let help = if words.contains("not on whitelist") {
        "; it lists other files, which only a .m3u8, .mpd, .ffconcat or .sdp may do: rename it if you trust it"
    } else if heif {
        HEIF_HELP
    } else {
        ""
    };
    format!("ffmpeg cannot read it: {words}{help}")
}

const HEIF_HELP: &str = "; this ffmpeg does not know this kind of HEIC or AVIF: convert it first, for \
    instance by heif-dec IN.heic OUT.png (libheif)";

/// Probes the video stream of `path` that ffmpeg would choose, but no cover.
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
    let container = text(&answer["format"], "format_name").unwrap_or("unknown");
    let heif = if container.split(',').any(|name| name == "mp4") && !is_url(path) {
        heif::read(path)
    } else {
        None
    };
    if heif.is_some_and(|heif| heif.grid) {
        return Err(Error::input(path, format!("is put together from tiles{HEIF_HELP}")));
    }
    let pix_fmt = text(stream, "pix_fmt")
        .ok_or_else(|| Error::input(path, "ffmpeg has no decoder for this video"))?;
    let mut size = shown_size(stream).ok_or_else(|| Error::input(path, "the video has no size"))?;
    let frames = text(stream, "nb_frames").and_then(|n| n.parse().ok());
    let still = is_still(container) || heif.is_some() && frames == Some(1);
    let mut filters = String::new();
    // Newer ffmpegs tell how the picture is turned, and turn it.
    if let Some(heif) = heif.filter(|_| still && rotation(stream) == 0.0) {
        filters = turning(heif);
        if heif.turns % 2 == 1 {
            size = Size::new(size.height, size.width);
        }
    }
    check_size(size).map_err(|error| Error::input(path, error.to_string()))?;
    let codec = codec(stream);
    let decoder = alpha_decoder(stream, codec);
    let alpha_stream = heif.filter(|heif| heif.alpha).map(|_| {
        alpha_stream(&answer, stream).ok_or_else(|| {
            Error::input(
                path,
                "has transparency that this ffmpeg does not read (9 does): convert it to PNG first",
            )
        })
    });
    let alpha_stream = alpha_stream.transpose()?;
    let (format, sampling, alpha) =
        pipe_format(pix_fmt, decoder.is_some() || alpha_stream.is_some());
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
    let duration = end.or_else(|| text(&answer["format"], "duration").and_then(decimal));
    let live = is_live(path, &answer);
    let index = stream["index"].as_u64().unwrap_or(0);
    let sound = sound_tracks(&answer, Some(index));
    let info = StreamInfo {
        format: format!("{codec} in {}", container.split(',').next().unwrap_or(container)),
        size,
        frames: if still { Some(1) } else { frames },
        rate: rate(stream).filter(|_| !still),
        duration: duration.filter(|_| !still),
        alpha,
        still,
        loops: Loops::Once,
        audio: streams(&answer, "audio").find(|s| text(s, "sample_fmt").is_some()).map(in_words),
        live,
        colour: sampling.is_some().then_some(tags),
    };
    let zero = match &sound.repair {
        _ if live => None,
        Some(_) => Some(Rational::ZERO),
        None => Some(zero(&answer)),
    };
    let track = Track {
        index,
        time_base,
        format,
        pixels,
        decoder,
        zero,
        // A clock that may start again promises nothing.
        end: end.filter(|_| sound.repair.is_none() && !still),
        // As ffmpeg names them, with their kin: mov,mp4,m4a,3gp,3g2,mj2 and matroska,webm.
        has_index: !live && container.split(',').any(|name| matches!(name, "mp4" | "matroska")),
        repair: sound.repair.clone(),
        still,
        filters,
        alpha: alpha_stream,
    };
    Ok(Probed { info, track, sound })
}

/// Filters that turn a HEIF picture as it is to be shown.
fn turning(heif: Heif) -> String {
    let turn = ["", "transpose=cclock,", "hflip,vflip,", "transpose=clock,"];
    let mirror = match heif.mirror {
        Some(0) => "vflip,",
        Some(_) => "hflip,",
        None => "",
    };
    format!("{}{mirror}", turn[usize::from(heif.turns & 3)])
}

/// The sound of `path`, which need not have a picture.
///
/// # Errors
/// When ffprobe is missing or cannot read the file.
pub(crate) fn probe_sound(path: &Path, ffmpeg: &Ffmpeg) -> Result<SoundTracks> {
    Ok(sound_tracks(&ask(path, ffmpeg)?, None))
}

/// What there is besides the picture in the stream `index`.
fn sound_tracks(answer: &Value, index: Option<u64>) -> SoundTracks {
    let picture = picture(answer).and_then(begin).map(|begin| begin - zero(answer));
    let (extras, shift) = (extras(answer, zero(answer)), origin(answer) - zero(answer));
    let container = text(&answer["format"], "format_name").unwrap_or("unknown");
    let repair = restarts(container).then(|| Repair {
        reader: mending(container),
        offset: shift,
        streams: index.into_iter().chain(extras.sound.iter().map(|track| track.index)).collect(),
    });
    SoundTracks { extras, shift, picture, repair }
}

/// Whether the file `path` has a picture that can be read: the first packet of one is there.
///
/// # Errors
/// When ffprobe is missing or cannot read the file.
pub(crate) fn probe_packet(path: &Path, ffmpeg: &Ffmpeg) -> Result<bool> {
    let which = ["-select_streams", "v:0", "-read_intervals", "%+#1"];
    let answer = run(path, ffmpeg, &which, "packet=size")?;
    Ok(answer["packets"].as_array().is_some_and(|packets| !packets.is_empty()))
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
    told.or_else(|| tag(stream, "rotate")?.parse().ok()).unwrap_or(0.0)
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
    tag(stream, "DURATION").and_then(clock).map(|end| end - zero)
}

/// Cameras and streams without an end. What comes from a network with its size is a finished file, even if it does
/// not tell its duration.
fn is_live(path: &Path, answer: &Value) -> bool {
    let format = &answer["format"];
    let sized = text(format, "size").and_then(|size| size.parse::<u64>().ok()).unwrap_or(0) > 0;
    let container = text(format, "format_name").unwrap_or("unknown");
    let finished = text(format, "duration").is_some() || sized && !is_list(container);
    is_camera(path) || is_url(path) && !finished
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
    fn rates_are_nominal_when_kept() {
        let rate = |r, avg| rate(&json!({"r_frame_rate": r, "avg_frame_rate": avg}));
        assert_eq!(rate("30000/1001", "19001/634"), Some(Rational::new(30000, 1001)));
        assert_eq!(rate("50/1", "20/1"), Some(Rational::new(50, 1)));
        assert_eq!(rate("1000/1", "20/1"), Some(Rational::new(20, 1)));
        assert_eq!(rate("25/1", "0/0"), Some(Rational::new(25, 1)));
        assert_eq!(rate("0/0", "0/0"), None);
    }
}
