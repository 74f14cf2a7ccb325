//! Asks ffprobe about a video: size, times, colour, sound.

use std::ffi::OsString;
use std::io::Read;
use std::path::Path;

use serde_json::Value;

use crate::colour::{Coding, Layout, Sampling, Siting};
use crate::error::{Error, Result};
use crate::ffmpeg::Ffmpeg;
use crate::ffmpeg::child::Child;
use crate::ffmpeg::command::{STANDARD, address, arguments, is_camera, is_url};
use crate::ffmpeg::feed::PipedInput;
use crate::ffmpeg::fields::{decimal, fraction, text};
use crate::ffmpeg::formats::{input_format, is_still, mending, restarts};
use crate::ffmpeg::heif;
use crate::ffmpeg::pixels::{alpha_decoder, pipe_format};
use crate::ffmpeg::shape::{DolbyVision, colorimetry, flat_size, rate, shown_size, turning};
use crate::ffmpeg::times::{begin, is_live, origin, promised_end, zero};
use crate::ffmpeg::tracks::{self, Extras, alpha_stream, codec, extras, picture, streams};
use crate::frame::{Rational, check_size};
use crate::geom::Size;
use crate::stream::{Loops, StreamInfo};

/// The most bytes of ffprobe's answer that are read.
const MAX_ANSWER: u64 = 4 << 20;

/// The fields that ffprobe is asked for.
const ENTRIES: &str = "stream=index,codec_name,codec_type,width,height,pix_fmt,sample_fmt,\
    sample_aspect_ratio,color_range,color_space,color_transfer,color_primaries,chroma_location,\
    field_order,r_frame_rate,avg_frame_rate,time_base,start_pts,duration_ts,nb_frames,sample_rate,channels\
    :stream_disposition:stream_tags\
    :stream_side_data=rotation,crop_top,crop_bottom,crop_left,crop_right,dv_profile,dv_bl_signal_compatibility_id:format=format_name,start_time,duration,size:format_tags\
    :chapter=start_time,end_time:chapter_tags=title";

/// The orders of fields, of interlaced frames.
const INTERLACED: [&str; 4] = ["tt", "bb", "tb", "bt"];
/// A frame of each frame that is marked as interlaced.
const DEINTERLACE: &str = "bwdif=mode=send_frame:deint=interlaced,";

/// The pixel format of the pipe from ffmpeg.
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
    /// Unit of its times, in seconds.
    pub(crate) time_base: Rational,
    /// ffmpeg's name of the pixel format of the pipe.
    pub(crate) format: &'static str,
    /// The same as a type.
    pub(crate) pixels: Pixels,
    /// The decoder to request where ffmpeg's default loses alpha.
    pub(crate) decoder: Option<&'static str>,
    /// The container's time that becomes time 0, in seconds. `None`: the time of the first frame (live inputs).
    pub(crate) zero: Option<Rational>,
    /// End of the stream by the container's header, in seconds.
    pub(crate) end: Option<Rational>,
    /// Whether the container has an index of its frames, so that ffmpeg can seek.
    pub(crate) has_index: bool,
    /// How ffmpeg repairs timestamps, for containers in which they may restart.
    pub(crate) repair: Option<Repair>,
    /// Whether it is one picture.
    pub(crate) still: bool,
    /// ffmpeg filters in front of all others, each followed by a comma.
    pub(crate) filters: String,
    /// Whether ffmpeg applies its rotation. That of HEIF only newer ones know, and not that of the alpha beside it.
    pub(crate) is_turned_by_ffmpeg: bool,
    /// Index of the stream that holds its alpha.
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

/// How ffmpeg repairs timestamps that may restart. It looks at all streams that it reads: picture and sound are
/// repaired alike only if both are read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Repair {
    /// ffmpeg options that choose the demuxer.
    pub(crate) reader: Vec<OsString>,
    /// Seconds to add to ffmpeg's times, which begin at 0 with the first stream.
    pub(crate) offset: Rational,
    /// The streams that are read, the picture's first.
    pub(crate) streams: Vec<u64>,
}

/// The streams of a video besides the picture, and their times.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SoundTracks {
    pub(crate) extras: Extras,
    /// Our times less ffmpeg's, which begin at 0 with the first stream, in seconds.
    pub(crate) shift: Rational,
    /// Start time of the picture in the same file, if known.
    pub(crate) picture: Option<Rational>,
    /// How its timestamps are repaired.
    pub(crate) repair: Option<Repair>,
}

/// The answer of ffprobe, parsed.
#[derive(Clone, Debug)]
pub(crate) struct Probed {
    pub(crate) info: StreamInfo,
    pub(crate) track: Track,
    pub(crate) sound: SoundTracks,
    /// What was found, and what is done with it, in words.
    pub(crate) notes: Vec<String>,
}

/// Asks ffprobe for [`ENTRIES`] of `path`.
fn ask(path: &Path, ffmpeg: &Ffmpeg) -> Result<Value> {
    run(path, None, ffmpeg, &[], ENTRIES)
}

/// Asks ffprobe for `entries` of `path`, or of the pipe `feed` of that name, with further options.
fn run(
    path: &Path,
    feed: Option<&PipedInput>,
    ffmpeg: &Ffmpeg,
    options: &[&str],
    entries: &str,
) -> Result<Value> {
    let fail = |what: String| Error::input(path, what);
    let mut args = arguments([&"-v", &"level+error", &"-of", &"json"]);
    args.extend(options.iter().map(OsString::from));
    args.extend(arguments([&"-show_entries", &entries]));
    let from = if feed.is_some() { Path::new(STANDARD) } else { path };
    args.extend(input_format(from));
    args.extend([OsString::from("-i"), address(from)]);
    let mut probe =
        Child::ffprobe(ffmpeg, &args).map_err(|error| fail(error.to_string()).caused_by(error))?;
    let from_network = is_url(path) || is_camera(path);
    if from_network {
        probe.be_patient();
    }
    let mut answer = String::new();
    let stdout = probe.stdout();
    if let Some(feed) = feed
        && let Some(stdin) = probe.stdin()
    {
        // Who writes to the pipe may take any time.
        probe.wait_for_ever();
        feed.probe(stdin).map_err(|error| Error::thread("pipe-probe", error))?;
    }
    if let Some(stdout) = stdout {
        stdout
            .take(MAX_ANSWER)
            .read_to_string(&mut answer)
            .map_err(|error| fail(format!("ffprobe's answer cannot be read: {error}")))?;
    }
    let status = probe.wait().map_err(|error| fail(format!("ffprobe: {error}")))?;
    if !status.success() {
        let error = probe.failure(from_network);
        return Err(fail(unreadable(path, error.words())).caused_by(error));
    }
    serde_json::from_str(&answer).map_err(|error| fail(format!("ffprobe's answer: {error}")))
}

/// The message for a `path` that ffprobe cannot read, with advice.
fn unreadable(path: &Path, words: &str) -> String {
    let heif = !is_url(path) && path.is_file() && heif::read(path).is_some();
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

/// Probes the video stream of `path`, or of the pipe `feed` of that name, that ffmpeg would choose; cover pictures are ignored.
///
/// # Errors
/// When ffprobe is missing, cannot read the file, or there is no video that we can work on.
pub(crate) fn probe(path: &Path, feed: Option<&PipedInput>, ffmpeg: &Ffmpeg) -> Result<Probed> {
    let answer = run(path, feed, ffmpeg, &[], ENTRIES)?;
    let stream = picture(&answer).ok_or_else(|| Error::input(path, "there is no video in it"))?;
    if text(&answer["format"], "format_name") == Some("tty") {
        // ffmpeg reads any text as ANSI art (its demuxer `tty`).
        return Err(Error::input(path, "is text, neither a picture nor a video"));
    }
    let container = text(&answer["format"], "format_name").unwrap_or("unknown");
    let is_file = feed.is_none() && !is_url(path);
    let heif = if container.split(',').any(|name| name == "mp4") && is_file {
        heif::read(path)
    } else {
        None
    };
    if heif.is_some_and(|heif| heif.grid) {
        return Err(Error::input(path, format!("is put together from tiles{HEIF_HELP}")));
    }
    let pix_fmt = text(stream, "pix_fmt")
        .ok_or_else(|| Error::input(path, "ffmpeg has no decoder for this video"))?;
    let dolby_vision = DolbyVision::of(stream);
    if let Some(DolbyVision { profile, base: 0 }) = dolby_vision {
        return Err(Error::input(
            path,
            format!(
                "is Dolby Vision of profile {profile}, whose colours ffmpeg alone does not decode: convert it first, for instance \
                 by ffmpeg -init_hw_device vulkan -i IN -vf libplacebo=format=yuv420p:colorspace=bt709:color_primaries=bt709:color_trc=bt709 OUT.mp4"
            ),
        ));
    }
    let mut size = shown_size(stream).ok_or_else(|| Error::input(path, "the video has no size"))?;
    let frames = text(stream, "nb_frames").and_then(|n| n.parse().ok());
    let still = is_still(container) || heif.is_some() && frames == Some(1);
    let mut filters = String::new();
    let turned_here = heif.filter(|_| still);
    if let Some(heif) = turned_here {
        size = flat_size(stream).unwrap_or(size);
        filters = turning(heif);
        if heif.turns % 2 == 1 {
            size = Size::new(size.height, size.width);
        }
    }
    let fields = text(stream, "field_order").filter(|order| INTERLACED.contains(order));
    if fields.is_some() && !still {
        filters += DEINTERLACE;
    }
    check_size(size).map_err(|error| Error::input(path, error.to_string()))?;
    let codec = codec(stream);
    let decoder = alpha_decoder(stream, codec);
    let alpha_stream = heif.filter(|heif| heif.alpha).map(|_| {
        alpha_stream(&answer, stream).ok_or_else(|| {
            Error::input(
                path,
                "has transparency that this ffmpeg does not read: name a newer one with --ffmpeg PATH (9 reads it), \
                 or convert it first, for instance by avifdec IN.avif OUT.png (libavif)",
            )
        })
    });
    let alpha_stream = alpha_stream.transpose()?;
    if alpha_stream.is_some() && heif.is_some_and(|heif| heif.premultiplied) {
        filters.insert_str(0, UNPREMULTIPLY);
    }
    let (format, sampling, alpha) =
        pipe_format(pix_fmt, decoder.is_some() || alpha_stream.is_some());
    let mut tags = colorimetry(stream);
    if sampling == Some(Sampling::Yuv444) && tags.matrix.as_deref() == Some("ycgco") {
        filters += FROM_YCGCO;
        tags.matrix = Some("bt709".into());
    }
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
        // Timestamps that may restart make the end unknown.
        end: end.filter(|_| sound.repair.is_none() && !still),
        // ffmpeg's names are mov,mp4,m4a,3gp,3g2,mj2 and matroska,webm.
        has_index: !live
            && feed.is_none()
            && container.split(',').any(|name| matches!(name, "mp4" | "matroska")),
        repair: sound.repair.clone(),
        still,
        filters,
        is_turned_by_ffmpeg: turned_here.is_none(),
        alpha: alpha_stream,
    };
    let mut notes = tracks::in_words(&answer, index, &sound.extras);
    if let Some(fields) = fields.filter(|_| !still) {
        notes.push(format!("interlaced ({fields}): deinterlaced"));
    }
    if let Some(DolbyVision { profile, .. }) = dolby_vision {
        notes.push(format!("Dolby Vision (profile {profile}): its base layer is read"));
    }
    Ok(Probed { info, track, sound, notes })
}

/// Filters that divide colours by alpha. The filter `unpremultiply` does so only in some versions: newer ones want to be
/// told first, by an option that older ones lack.
const UNPREMULTIPLY: &str = "format=gbrap,geq=r='min(255,255*r(X,Y)/max(1,alpha(X,Y)))':\
    g='min(255,255*g(X,Y)/max(1,alpha(X,Y)))':b='min(255,255*b(X,Y)/max(1,alpha(X,Y)))':a='alpha(X,Y)',";

/// Filter from Y'CgCo, which lossless screen recordings have, to the matrix of BT.709.
const FROM_YCGCO: &str = "zscale=matrixin=ycgco:matrix=709,";

/// The sound of `path`, which need not have a picture.
///
/// # Errors
/// When ffprobe is missing or cannot read the file.
pub(crate) fn probe_sound(path: &Path, ffmpeg: &Ffmpeg) -> Result<SoundTracks> {
    Ok(sound_tracks(&ask(path, ffmpeg)?, None))
}

/// The streams besides the picture, which is stream `index`.
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

/// Whether the file `path` has a video packet.
///
/// # Errors
/// When ffprobe is missing or cannot read the file.
pub(crate) fn probe_packet(path: &Path, ffmpeg: &Ffmpeg) -> Result<bool> {
    let which = ["-select_streams", "v:0", "-read_intervals", "%+#1"];
    let answer = run(path, None, ffmpeg, &which, "packet=size")?;
    Ok(answer["packets"].as_array().is_some_and(|packets| !packets.is_empty()))
}

/// Start of the picture of the file `path` after that of its first stream, in seconds.
///
/// # Errors
/// When ffprobe is missing or cannot read the file.
pub(crate) fn probe_lead(path: &Path, ffmpeg: &Ffmpeg) -> Result<Rational> {
    let answer = ask(path, ffmpeg)?;
    let begin = picture(&answer).and_then(begin).unwrap_or_else(|| origin(&answer));
    Ok(begin - origin(&answer))
}

/// Describes a sound track: codec, rate and channels.
fn in_words(stream: &Value) -> String {
    let rate = text(stream, "sample_rate").unwrap_or("?");
    let channels = stream["channels"].as_u64().unwrap_or(0);
    format!("{} {rate} Hz {channels} ch", codec(stream))
}
