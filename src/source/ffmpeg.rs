//! Decodes video by the ffmpeg of the machine.
//!
//! Frames come as raw pictures in a NUT stream, which carries their times exactly. Times are those of
//! the container's clock, so that picture and sound keep their distance; a clock that does not start
//! near 0 (MPEG-TS) is set to 0 at the first stream. Rotation and pixel
//! aspect are applied by ffmpeg, colour by [`crate::colour`].

mod frames;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::colour::{Coding, Colorimetry};
use crate::error::{Error, Result};
use crate::ffmpeg::child::Child;
use crate::ffmpeg::command::{STANDARD, arguments, is_camera, is_url};
use crate::ffmpeg::feed::PipedInput;
use crate::ffmpeg::probe::{Pixels, Probed, Repair, probe};
use crate::ffmpeg::side::SoundPipe;
use crate::ffmpeg::{Ffmpeg, FfmpegError};
use crate::frame::Rational;
use crate::source::decode::{self, SideSound};
use crate::source::{Input, Sound, SourceOptions};
use crate::stream::{StreamInfo, is_hdr};

pub use frames::VideoSource;

/// Whether `path` is for ffmpeg to open: a URL, or a camera.
pub(crate) fn is_address(path: &Path) -> bool {
    is_url(path) || is_camera(path)
}

/// Opens the video `path` as [`Video::open`] does.
///
/// # Errors
/// As [`Video::open`].
pub(crate) fn open(path: PathBuf, options: &SourceOptions) -> Result<Input> {
    input(Video::open(&path, &options.ffmpeg)?, options)
}

/// Opens the video that comes out of `pipe`, which is called `path`.
///
/// # Errors
/// As [`Video::open`].
pub(crate) fn open_pipe(
    path: &Path,
    pipe: Box<dyn Read + Send>,
    options: &SourceOptions,
) -> Result<Input> {
    input(Video::open_pipe(path, pipe, &options.ffmpeg)?, options).map(Input::once)
}

/// The input that `video` is.
fn input(mut video: Video, options: &SourceOptions) -> Result<Input> {
    let path = video.path.clone();
    let start = options.start.unwrap_or(Rational::ZERO);
    if options.to_sdr {
        video.map_tones(options.to_bt709);
    }
    let info = video.info().clone();
    // Others can be read a second time.
    let is_once = info.live || video.feed.is_some();
    video.sound_pipe = is_once.then(SoundPipe::default);
    let sound = (!info.still).then(|| Sound {
        path: path.clone(),
        start,
        cut: options.end.is_some() || options.frames.is_some(),
        tracks: Some(video.probed.sound.clone()),
        pipe: video.sound_pipe.clone(),
    });
    let notes = video.probed.notes.clone();
    let no_file = is_address(&path) || path == Path::new(STANDARD);
    let files: Arc<[PathBuf]> = if no_file { Arc::from([]) } else { Arc::from([path]) };
    let input = Input::new(files, info, move || Ok(Box::new(video.start_before(start)?)));
    Ok(input.with_sound(sound).with_notes(notes))
}

/// Only from here on ffmpeg looks for a place to begin at: what comes before is decoded in less than a second.
const FAR: f64 = 10.0;

/// Seconds before the first wanted frame at which it begins: key frames have times of decoding, or come with
/// frames that refer to missing ones; and the first stream may begin up to a second before our 0 or after it.
const AHEAD: i64 = 3;

/// Where ffmpeg is to begin, in seconds, if frames from `start` on are wanted; 0 for the beginning.
fn place(start: Rational) -> i64 {
    let start = start.to_f64();
    if start < FAR { 0 } else { start as i64 - AHEAD }
}

/// A video that was probed but not started.
#[derive(Clone, Debug)]
pub struct Video {
    path: PathBuf,
    ffmpeg: Ffmpeg,
    probed: Probed,
    /// What it is read from, if it can be read only once.
    feed: Option<PipedInput>,
    /// Where its sound goes, if it can be read only once, and somebody wants it.
    sound_pipe: Option<SoundPipe>,
}

impl Video {
    /// Looks at `path`: a file, a URL that ffmpeg reads, or a camera (`/dev/video0`). `ffmpeg` is
    /// the program to use, and the list that its processes are entered in.
    ///
    /// # Errors
    /// [`Error::Input`] when ffmpeg is missing or cannot read it, or there is no video in it.
    pub fn open(path: &Path, ffmpeg: &Ffmpeg) -> Result<Self> {
        let (probed, ffmpeg) = (probe(path, None, ffmpeg)?, ffmpeg.clone());
        Ok(Self { path: path.into(), ffmpeg, probed, feed: None, sound_pipe: None })
    }

    /// Looks at what comes out of `pipe`, which is called `path`, and keeps it for the decoder.
    ///
    /// # Errors
    /// As [`Video::open`].
    fn open_pipe(path: &Path, pipe: Box<dyn Read + Send>, ffmpeg: &Ffmpeg) -> Result<Self> {
        let feed = PipedInput::new(pipe);
        let (probed, ffmpeg) = (probe(path, Some(&feed), ffmpeg)?, ffmpeg.clone());
        Ok(Self { path: path.into(), ffmpeg, probed, feed: Some(feed), sound_pipe: None })
    }

    /// The same, with its sound on its way to who wants it: where `start` is requested, times of both are counted from
    /// there, and of a live input from where ffmpeg begins to read.
    fn hand_on_sound(&self, start: Rational) -> (Self, Option<SideSound>) {
        let mut video = self.clone();
        let Some(pipe) = self.sound_pipe.as_ref().and_then(SoundPipe::path) else {
            return (video, None);
        };
        let Probed { track, sound, .. } = &mut video.probed;
        let streams: Vec<u64> = sound.extras.sound.iter().map(|track| track.index).collect();
        if track.zero.is_none() {
            track.zero = Some(Rational::ZERO);
            let streams = [&[track.index], &streams[..]].concat();
            let repair = Repair { reader: Vec::new(), offset: Rational::ZERO, streams };
            track.repair.get_or_insert(repair);
        }
        let from = track.zero.unwrap_or(Rational::ZERO) + start;
        (video, Some(SideSound { pipe, streams, from }))
    }

    /// Asks for HDR brought to SDR, where this ffmpeg has the filters for it; else it stays HDR, and its tags say so.
    /// Colours of a wide gamut become those of BT.709 if that `narrows` SDR, too.
    fn map_tones(&mut self, narrows: bool) {
        let Probed { info, track, notes, .. } = &mut self.probed;
        let Pixels::Planar(layout, _) = track.pixels else { return };
        let Some(colour) = &info.colour else { return };
        let (hdr, wide) = (is_hdr(colour), colour.primaries.as_deref() == Some("bt2020"));
        if !(hdr || wide && narrows) || layout.alpha || !has_filters(&self.ffmpeg) {
            return;
        }
        let curve = colour.transfer.as_deref().unwrap_or("unknown");
        let (filter, done) = if hdr {
            (decode::TO_SDR, format!("HDR ({curve}): its tones become SDR of BT.709"))
        } else {
            (decode::TO_BT709, "Rec. 2020: its colours become those of BT.709".to_owned())
        };
        notes.push(done);
        let bt709 = || Some("bt709".to_string());
        let tags = Colorimetry {
            matrix: bt709(),
            range: Some("tv".into()),
            primaries: bt709(),
            transfer: bt709(),
        };
        track.pixels = Pixels::Planar(layout, Coding::of(&tags, info.size));
        track.filters = format!("{}{filter},", track.filters);
        info.colour = Some(tags);
    }

    /// The properties that are known before frames are read.
    pub fn info(&self) -> &StreamInfo {
        &self.probed.info
    }

    /// Starts ffmpeg.
    ///
    /// # Errors
    /// [`Error::Input`] when it cannot be started.
    pub fn start(&self) -> Result<VideoSource> {
        self.start_before(Rational::ZERO)
    }

    /// The same, but not always from the beginning if only frames from `start` on are needed.
    fn start_before(&self, start: Rational) -> Result<VideoSource> {
        let (video, sound) = self.hand_on_sound(start);
        video
            .start_with(video.place(start), sound.as_ref())
            .map_err(|error| Error::input(&self.path, error.to_string()).caused_by(error))
    }

    /// As [`place`], in this container.
    fn place(&self, start: Rational) -> i64 {
        if self.probed.track.has_index { place(start) } else { 0 }
    }

    /// The same, from `seconds` after the beginning of the first stream.
    fn start_at(&self, seconds: i64) -> Result<VideoSource, FfmpegError> {
        self.start_with(seconds, None)
    }

    /// The same with sound to another process.
    fn start_with(
        &self,
        seconds: i64,
        sound: Option<&SideSound>,
    ) -> Result<VideoSource, FfmpegError> {
        let Probed { info, track, .. } = &self.probed;
        let path = if self.feed.is_some() { Path::new(STANDARD) } else { &self.path };
        let args = decode::track(path, info, track, seconds, sound);
        let mut child = Child::ffmpeg(&self.ffmpeg, &args)?;
        if is_address(&self.path) {
            child.be_patient();
        }
        let stdout = child
            .stdout()
            .ok_or_else(|| FfmpegError::new("ffmpeg came without standard output"))?;
        if let Some(feed) = &self.feed {
            // Who writes to the pipe may take any time.
            child.wait_for_ever();
            let stdin = child.stdin().map(|stdin| feed.give(stdin));
            stdin.transpose().map_err(|error| FfmpegError::new(error.to_string()))?;
        }
        Ok(VideoSource::new(self.clone(), child, stdout, seconds))
    }
}

/// Whether `ffmpeg` can bring HDR to SDR: it does so with one small picture.
fn has_filters(ffmpeg: &Ffmpeg) -> bool {
    let mut args = arguments([&"-nostdin", &"-v", &"error", &"-f", &"lavfi", &"-i"]);
    // Tagged behind the source: ffmpeg 5.1 takes no tags from one.
    let tags = "setparams=color_trc=smpte2084:color_primaries=bt2020:colorspace=bt2020nc:range=tv";
    let filters = format!("{tags},{}", decode::TO_SDR);
    args.extend(arguments([&"color=s=16x16:d=0.04,format=yuv420p10le", &"-vf", &filters]));
    args.extend(arguments([&"-f", &"null", &"-"]));
    let ended = Child::ffmpeg(ffmpeg, &args).map(|mut child| child.wait());
    matches!(ended, Ok(Ok(status)) if status.success())
}
