//! The last step of a video file, if it needs one: a second, fast run of ffmpeg that copies the finished picture.
//!
//! It sets what could not be known before: how long the last frame is shown, and where the sound ends if
//! the picture ends before it. Sound that has to come from a network is put in here too, so that the
//! picture does not wait for it.

use std::ffi::OsString;
use std::path::Path;

use crate::ffmpeg::child::Child;
use crate::ffmpeg::command::{self, arguments, seconds};
use crate::ffmpeg::{Ffmpeg, FfmpegError};
use crate::frame::Rational;
use crate::sink::container::Container;
use crate::sink::sound::Streams;

/// The finished picture.
pub(crate) struct Finished<'a> {
    /// Its path.
    pub(crate) path: &'a Path,
    /// Its container, and that of the result.
    pub(crate) container: &'a Container,
    /// The unit of its times.
    pub(crate) time_base: Rational,
    /// When its first frame is shown, in seconds.
    pub(crate) first: Rational,
    /// The last frame, if its length must be set.
    pub(crate) last: Option<Last>,
    /// Its start after that of the first stream of the file, in seconds.
    pub(crate) lead: Rational,
}

/// The last frame of a picture: raw video in NUT has no durations, and ffmpeg takes the nominal one.
pub(crate) struct Last {
    /// Its index, from 0.
    pub(crate) number: u64,
    /// Its start time in seconds.
    pub(crate) start: Rational,
    /// Its duration.
    pub(crate) length: Rational,
}

/// The sound to add.
pub(crate) struct SoundSource<'a> {
    pub(crate) streams: &'a Streams,
    /// Its end, if before its own end.
    pub(crate) end: Option<Rational>,
    /// The user's own options for it.
    pub(crate) options: &'a [OsString],
}

/// Writes `picture`, and `sound` if there is any, to `to`.
///
/// # Errors
/// The message of ffmpeg, when it fails.
pub(crate) fn remux(
    picture: &Finished<'_>,
    sound: Option<&SoundSource<'_>>,
    to: &Path,
    ffmpeg: &Ffmpeg,
) -> Result<(), FfmpegError> {
    let container = picture.container;
    let mut args = arguments([&"-nostdin", &"-hide_banner", &"-loglevel", &"level+warning", &"-y"]);
    // ffmpeg moves the first stream of every input to 0; this moves the picture back.
    args.extend(arguments([&"-itsoffset", &seconds(picture.first - picture.lead), &"-i"]));
    args.push(command::address(picture.path));
    if let Some(sound) = sound {
        args.extend(sound.streams.input(sound.end));
    }
    args.extend(arguments([&"-map", &"0:v:0", &"-c:v", &"copy"]));
    if let Some(last) = &picture.last {
        args.extend(arguments([&"-bsf:v", &lengthen(last, picture)]));
    }
    if let Some(sound) = sound {
        args.extend(sound.streams.output(container, sound.end));
        args.extend(sound.options.iter().cloned());
    }
    args.extend(bare(container, sound.is_none()));
    args.extend(placing(container, picture.time_base, true));
    args.push(command::address(to));
    args.extend(sound.iter().flat_map(|sound| sound.streams.along()));
    let mut ffmpeg = Child::ffmpeg(ffmpeg, &args)?;
    if sound.is_some_and(|sound| command::is_url(&sound.streams.source().path)) {
        ffmpeg.be_patient();
    }
    let status =
        ffmpeg.wait().map_err(|error| FfmpegError::new(error.to_string()).caused_by(error))?;
    if status.success() && !ffmpeg.complained() {
        return Ok(());
    }
    // Complaints may come from damaged sound, which is no reason to lose the picture; a full disk is.
    let error = ffmpeg.failure(false);
    let full = error.words().contains("No space left");
    if status.success() && !full { Ok(()) } else { Err(error) }
}

/// Options that leave the times of streams where they are, and, if `alone`, take over the picture and nothing else.
pub(crate) fn bare(container: &Container, alone: bool) -> Vec<OsString> {
    let mut args = Vec::new();
    if alone {
        args.extend(arguments([&"-map_metadata", &"-1", &"-map_chapters", &"-1"]));
    }
    if matches!(container, Container::Mkv | Container::WebM | Container::Avi) {
        // An encoder's run-in before 0 must not push the picture to a later time: Matroska keeps it
        // as the codec's delay, and in AVI it would be rounded to a frame.
        args.extend(arguments([&"-avoid_negative_ts", &"disabled"]));
    }
    args
}

/// The filter of packets that gives the last frame its length. QuickTime's tables end with the last packet in
/// decoding order, which with frames out of order is another one than the last shown, and its edit list ends with
/// the latest end of any frame. So that packet ends where the picture ends at the latest; where it is decoded long
/// before it is shown (a frame was held before it), it is decoded later.
fn lengthen(last: &Last, picture: &Finished<'_>) -> String {
    let end = (last.start + last.length).to_f64();
    // Half a millisecond before the start, to be safe from rounding.
    let (start, length) = (last.start.to_f64() - 5e-4, last.length.to_f64());
    let shown = format!("if(gte(PTS*TB\\,{start:.6})\\,{length:.6}/TB\\,DURATION)");
    // No frame ends later: the latest end of all is the file's.
    let shown = format!("min({shown}\\,{end:.6}/TB-PTS)");
    if !picture.container.is_quicktime() {
        return format!("setts=pts=PTS:dts=DTS:duration={shown}");
    }
    let number = last.number;
    let decoded = "max(DTS\\,PTS-STARTPTS+STARTDTS)";
    // To the end of the tables, but not beyond the end of the picture.
    let left = format!("{end:.6}/TB-STARTPTS-({decoded}-STARTDTS)");
    let left = format!("max({shown}\\,min({left}\\,{end:.6}/TB-PTS))");
    format!(
        "setts=pts=PTS:dts=if(eq(N\\,{number})\\,{decoded}\\,DTS):duration=if(eq(N\\,{number})\\,{left}\\,{shown})"
    )
}

/// Options of the container, the last before the file: units of time, tables in front in the `last`
/// run.
pub(crate) fn placing(container: &Container, time_base: Rational, last: bool) -> Vec<OsString> {
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
