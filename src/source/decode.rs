//! The command lines that decode a video.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::colour::{Coding, Range};
use crate::ffmpeg::command;
use crate::ffmpeg::formats::input_format;
use crate::ffmpeg::probe::{Pixels, Track};
use crate::frame::Rational;
use crate::stream::StreamInfo;

/// ffmpeg's scaler flags: the best quality.
const SCALING: &str = "bicubic+accurate_rnd+full_chroma_int";

/// Filters from HDR to BT.709: diffuse white (203 nits, ITU-R BT.2408) becomes nearly the white of SDR; brighter
/// values are compressed.
pub(crate) const TO_SDR: &str = "zscale=t=linear:npl=203:p=bt709,format=gbrpf32le,\
    tonemap=tonemap=mobius:param=0.8:desat=0,zscale=t=bt709:m=bt709:p=bt709:r=tv";

/// Filters from colours of Rec. 2020, of SDR, to BT.709.
pub(crate) const TO_BT709: &str =
    "zscale=t=linear,format=gbrpf32le,zscale=t=bt709:m=bt709:p=bt709:r=tv";

/// Sound that goes to another process while the picture is decoded.
#[derive(Clone, Debug)]
pub(crate) struct SideSound {
    /// The named pipe.
    pub(crate) pipe: PathBuf,
    /// The numbers of its streams.
    pub(crate) streams: Vec<u64>,
    /// The time that becomes 0, in seconds.
    pub(crate) from: Rational,
}

impl SideSound {
    /// Options that decode it and send it.
    fn output(&self) -> Vec<OsString> {
        let mut args = Vec::new();
        for stream in &self.streams {
            args.extend(command::arguments([&"-map", &format!("0:{stream}")]));
        }
        let (num, den) = (self.from.num, self.from.den);
        // Gaps, as they occur in live sound, become silence.
        let filter = format!("aresample=async=1,asetpts=PTS-({num}/{den})/TB,atrim=start=0");
        args.extend(command::arguments([&"-af", &filter, &"-c:a", &"pcm_s16le", &"-f", &"nut"]));
        args.extend(command::arguments([&"-flush_packets", &"1", &"-y"]));
        args.push(self.pipe.clone().into());
        args
    }
}

/// Options that decode `track` of `path`, with the properties `info`, from `seconds` after the beginning of its first
/// stream.
pub(crate) fn track(
    path: &Path,
    info: &StreamInfo,
    track: &Track,
    seconds: i64,
    sound: Option<&SideSound>,
) -> Vec<OsString> {
    let mut args =
        command::arguments([&"-nostdin", &"-hide_banner", &"-loglevel", &"level+warning"]);
    if info.live {
        // ffprobe has looked at it for long enough.
        args.extend(command::arguments([&"-analyzeduration", &"1000000"]));
    }
    args.extend(input(path, track, seconds));
    args.extend(picture(info, track));
    args.extend(command::arguments([&"-an", &"-sn", &"-dn"]));
    if track.still {
        args.extend(command::arguments([&"-frames:v", &"1"]));
    }
    // Times are not changed, in the container's own units.
    let units = format!("{}:{}", track.time_base.num, track.time_base.den);
    args.extend(command::arguments([&"-fps_mode", &"passthrough", &"-enc_time_base", &units]));
    args.extend(command::arguments([&"-c:v", &"rawvideo", &"-f", &"nut", &"pipe:1"]));
    args.extend(sound.iter().flat_map(|sound| sound.output()));
    for stream in track.repair.iter().flat_map(|repair| repair.streams.iter().skip(1)) {
        args.extend(read_along(0, *stream));
    }
    args
}

/// Options that read `stream` of input `input` and discard it, so that ffmpeg repairs timestamps with its help.
pub(crate) fn read_along(input: usize, stream: u64) -> Vec<OsString> {
    let map = format!("{input}:{stream}");
    command::arguments([&"-map", &map, &"-c", &"copy", &"-f", &"null", &"-"])
}

/// Options that open `path` at `seconds` after its beginning.
fn input(path: &Path, track: &Track, seconds: i64) -> Vec<OsString> {
    // A truncated packet would give a damaged frame.
    let mut args = command::arguments([&"-fflags", &"+discardcorrupt"]);
    match &track.repair {
        Some(repair) => {
            args.extend(repair.reader.iter().cloned());
            args.extend(command::moved(repair.offset));
        }
        None => args.extend(command::arguments([&"-copyts"])),
    }
    if let Some(decoder) = track.decoder {
        args.extend(command::arguments([&"-c:v", &decoder]));
    }
    if !track.is_turned_by_ffmpeg {
        args.extend(command::arguments([&"-noautorotate"]));
    }
    if seconds > 0 {
        args.extend(command::arguments([&"-ss", &seconds.to_string()]));
    }
    args.extend(input_format(path));
    args.extend([OsString::from("-i"), command::address(path)]);
    args
}

/// Matrices that ffmpeg's scaler knows. Since 7.1 it refuses frames with other ones, though it would not convert them.
const SCALED: [&str; 7] = ["gbr", "bt709", "fcc", "bt470bg", "smpte170m", "smpte240m", "bt2020nc"];

/// Options that select, filter and convert the frames.
fn picture(info: &StreamInfo, track: &Track) -> Vec<OsString> {
    let size = info.size;
    // Without explicit ranges ffmpeg converts video of more than 8 bits to limited range.
    let range = match track.pixels {
        Pixels::Planar(_, Coding { range: Range::Full, .. }) => ":in_range=full:out_range=full",
        _ => "",
    };
    let filters = &track.filters;
    let matrix = info.colour.as_ref().and_then(|tags| tags.matrix.as_deref());
    let is_strange = matrix.is_some_and(|matrix| !SCALED.contains(&matrix));
    let untagged = if is_strange { "setparams=colorspace=unknown," } else { "" };
    // Frames of this size and format are not changed.
    let filter = format!(
        "{filters}{untagged}scale={}:{}:flags={SCALING}:sws_dither=none{range},setsar=1,format={}",
        size.width, size.height, track.format
    );
    let index = track.index;
    match track.alpha {
        None => command::arguments([&"-map", &format!("0:{index}"), &"-vf", &filter]),
        Some(alpha) => {
            let graph = format!("[0:{index}][0:{alpha}]alphamerge,{filter}[v]");
            command::arguments([&"-filter_complex", &graph, &"-map", &"[v]"])
        }
    }
}
