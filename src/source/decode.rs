//! The command lines that decode a video.

use std::ffi::OsString;
use std::path::Path;

use crate::colour::{Coding, Range};
use crate::ffmpeg::command;
use crate::ffmpeg::probe::{Pixels, Track};
use crate::stream::StreamInfo;

/// How ffmpeg scales: what loses least.
const SCALING: &str = "bicubic+accurate_rnd+full_chroma_int";

/// `track` of `path`, as `info` has it, from so many `seconds` after the first stream's beginning on.
pub(crate) fn track(path: &Path, info: &StreamInfo, track: &Track, seconds: i64) -> Vec<OsString> {
    let size = info.size;
    // Without a word on ranges, ffmpeg makes limited range of what has more than 8 bits.
    let range = match track.pixels {
        Pixels::Planar(_, Coding { range: Range::Full, .. }) => ":in_range=full:out_range=full",
        _ => "",
    };
    // Does nothing to frames that have this size and format already.
    let filter = format!(
        "scale={}:{}:flags={SCALING}:sws_dither=none{range},setsar=1,format={}",
        size.width, size.height, track.format
    );
    let shape = command::arguments([&"-vf", &filter]);
    let units = format!("{}:{}", track.time_base.num, track.time_base.den);
    decode(path, seconds, track.decoder, &format!("0:{}", track.index), shape, &units)
}

/// The track that ffmpeg calls `map`, from so many `seconds` on, its frames brought into `shape`, their times in
/// `units`.
fn decode(
    path: &Path,
    seconds: i64,
    decoder: Option<&str>,
    map: &str,
    shape: Vec<OsString>,
    units: &str,
) -> Vec<OsString> {
    let mut args =
        command::arguments([&"-nostdin", &"-hide_banner", &"-loglevel", &"level+warning"]);
    // A packet that was cut short would only give a spoilt frame.
    args.extend(command::arguments([&"-fflags", &"+discardcorrupt", &"-copyts"]));
    if let Some(decoder) = decoder {
        args.extend(command::arguments([&"-c:v", &decoder]));
    }
    if seconds > 0 {
        args.extend(command::arguments([&"-ss", &seconds.to_string()]));
    }
    args.extend(command::input_format(path));
    args.extend([OsString::from("-i"), command::address(path)]);
    args.extend(command::arguments([&"-map", &map, &"-an", &"-sn", &"-dn"]));
    args.extend(shape);
    // Times as they are, in the container's own units.
    args.extend(command::arguments([&"-fps_mode", &"passthrough", &"-enc_time_base", &units]));
    args.extend(command::arguments([&"-c:v", &"rawvideo", &"-f", &"nut", &"pipe:1"]));
    args
}
