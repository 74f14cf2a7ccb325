//! Decodes video by the ffmpeg of the machine.
//!
//! Frames come as raw pictures in a NUT stream, which carries their times exactly. Times are those of
//! the container's clock, so that picture and sound keep their distance; a clock that does not start
//! near 0 (MPEG-TS) is set to 0 at the first stream. Rotation and pixel
//! aspect are applied by ffmpeg, colour by [`crate::colour`].

use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::ChildStdout;
use std::sync::Arc;

use crate::colour::{Coding, Colorimetry, Form, Planes, to_rgba};
use crate::error::{Error, Result};
use crate::ffmpeg::child::Child;
use crate::ffmpeg::command::{STANDARD, arguments, is_camera, is_url};
use crate::ffmpeg::feed::PipedInput;
use crate::ffmpeg::nut::NutReader;
use crate::ffmpeg::probe::{Pixels, Probed, Repair, probe};
use crate::ffmpeg::side::SoundPipe;
use crate::ffmpeg::{Ffmpeg, FfmpegError, Pipe};
use crate::frame::{Buffers, Frame, Rational};
use crate::source::decode::{self, SideSound};
use crate::source::{Decoded, Input, Sound, Source, SourceOptions};
use crate::stream::{Span, StreamInfo, is_hdr};

/// The output of ffmpeg.
type Frames = NutReader<BufReader<Pipe<ChildStdout>>>;

/// Bytes that are read at once where little is wanted.
const BUFFER: usize = 1 << 16;

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
        let stdout = BufReader::with_capacity(BUFFER, stdout);
        Ok(VideoSource { stdout: Some(stdout), place: seconds, ..self.source(child) })
    }

    fn source(&self, child: Child) -> VideoSource {
        VideoSource {
            video: self.clone(),
            place: 0,
            stdout: None,
            reader: None,
            child,
            ahead: None,
            spare: Vec::new(),
            buffers: Buffers::default(),
            outcome: None,
            from: Rational::ZERO,
            delivered: 0,
            received: 0,
            last_start: None,
            longest: Rational::ZERO,
            length: self.probed.info.rate.and_then(Rational::recip),
        }
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

/// A frame as it came through the pipe.
struct Raw {
    start: Rational,
    data: Vec<u8>,
}

/// A video being decoded. Dropping it ends ffmpeg.
pub struct VideoSource {
    video: Video,
    /// Where ffmpeg began, in seconds; 0 is the beginning.
    place: i64,
    /// The pipe until its headers are read.
    stdout: Option<BufReader<Pipe<ChildStdout>>>,
    reader: Option<Frames>,
    child: Child,
    /// The frame after the one last delivered: its time gives the duration of that one.
    ahead: Option<Raw>,
    spare: Vec<u8>,
    /// Buffers of a recycled frame.
    buffers: Buffers,
    /// The result when it has ended: the error, if any.
    outcome: Option<Result<(), FfmpegError>>,
    /// Frames before this time are skipped.
    from: Rational,
    delivered: u64,
    received: u64,
    last_start: Option<Rational>,
    /// The longest time between two frames.
    longest: Rational,
    /// Length of the frame before, at first of one at the nominal rate.
    length: Option<Rational>,
}

impl VideoSource {
    /// Reads a frame off the pipe; at its end learns how ffmpeg fared.
    fn read(&mut self) -> Option<Raw> {
        if self.outcome.is_some() {
            return None;
        }
        let mut data = std::mem::take(&mut self.spare);
        let broken = match self.read_into(&mut data) {
            Ok(Some(start)) => {
                if let Some(before) = self.last_start.replace(start) {
                    self.longest = self.longest.max(start - before);
                }
                self.received += 1;
                return Some(Raw { start, data });
            }
            Ok(None) => None,
            Err(error) => Some(error),
        };
        // Only now that nothing is left in the pipe.
        (self.reader, self.stdout) = (None, None);
        self.outcome = Some(self.judge(broken));
        None
    }

    /// The first frame that is not skipped; skipped ones are not converted.
    fn wanted(&mut self) -> Option<Raw> {
        loop {
            let raw = self.read();
            let missed = match &raw {
                Some(raw) => self.received == 1 && raw.start > self.from,
                None => self.received == 0,
            };
            if self.place > 0 && missed {
                // There may have been one before, which is wanted.
                self.start_over();
                continue;
            }
            let raw = raw?;
            if raw.start >= self.from {
                return Some(raw);
            }
            self.spare = raw.data;
            // The number of frames that were not decoded is unknown.
            self.delivered += u64::from(self.place == 0);
        }
    }

    /// Restarts at the beginning.
    fn start_over(&mut self) {
        match self.video.start_at(0) {
            Ok(source) => *self = Self { from: self.from, ..source },
            Err(error) => (self.place, self.outcome) = (0, Some(Err(error))),
        }
    }

    fn read_into(&mut self, data: &mut Vec<u8>) -> io::Result<Option<Rational>> {
        if let Some(pipe) = self.stdout.take() {
            self.reader = Some(NutReader::new(
                pipe,
                self.video.probed.track.bytes(self.video.probed.info.size),
            )?);
        }
        let Some(reader) = &mut self.reader else { return Ok(None) };
        if reader.size() != self.video.probed.info.size {
            return Err(io::Error::other(format!("frames of {} arrived", reader.size())));
        }
        let pts = reader.next(data)?;
        Ok(pts.map(|pts| {
            let time = Rational::new(pts, 1) * reader.time_base();
            time - *self.video.probed.track.zero.get_or_insert(time)
        }))
    }

    /// Whether the end of the pipe was the end of the video. ffmpeg exits with 0 after most
    /// truncated and damaged inputs, but it complains.
    fn judge(&mut self, broken: Option<io::Error>) -> Result<(), FfmpegError> {
        let status = self
            .child
            .wait()
            .map_err(|error| FfmpegError::new(format!("ffmpeg: {error}")).caused_by(error))?;
        if !status.success() || self.child.complained() {
            return Err(self.child.failure(is_address(&self.video.path)));
        }
        match broken {
            Some(error) if self.received > 0 => {
                Err(FfmpegError::new(format!("its output cannot be read: {error}")))
            }
            // A stream without a header has no frame.
            Some(_) => Err(FfmpegError::new("not one frame could be decoded")
                .caused_by(io::ErrorKind::InvalidData)),
            None => self.check_promise(),
        }
    }

    /// Whether the frames reach the end that the container promises. ffmpeg takes some containers for
    /// complete wherever they end. A last frame that is held is no miss: only more than ten seconds,
    /// and more than twice any gap before, are missed, and only if frames are missing.
    fn check_promise(&self) -> Result<(), FfmpegError> {
        let (Some(end), Some(last)) = (self.video.probed.track.end, self.last_start) else {
            return Ok(());
        };
        // Where they were not counted from the first one it is left to ffmpeg to complain.
        let all = self
            .video
            .probed
            .info
            .frames
            .is_some_and(|frames| self.place > 0 || self.received >= frames);
        let slack = self.longest.max(Rational::new(5, 1)) * Rational::new(2, 1);
        if all || end - last <= slack {
            return Ok(());
        }
        let (last, end) = (last.to_f64(), end.to_f64());
        let words = format!("its last frame is at {last:.3} s of {end:.3} s");
        Err(FfmpegError::new(words).caused_by(io::ErrorKind::UnexpectedEof))
    }

    /// The error of a video that did not end well.
    fn failed(&self, error: FfmpegError) -> Error {
        let fault = if error.is_truncation() {
            "the video is cut short"
        } else if error.is_corruption() {
            "the video is damaged"
        } else {
            "ffmpeg failed"
        };
        let kept = self.delivered > 0 && (error.is_truncation() || error.is_corruption());
        let help = if kept { "; keep what can be read with --allow-truncated" } else { "" };
        let what = format!("{fault}: {error}{help}");
        Error::input_frame(&self.video.path, self.delivered, what).caused_by(error)
    }

    /// The frame in `data`, in the buffers of a recycled one.
    fn frame(&mut self, data: Vec<u8>) -> Result<Frame> {
        let Buffers { mut pixels, planes } = std::mem::take(&mut self.buffers);
        match self.video.probed.track.pixels {
            Pixels::Planar(layout, coding) if layout.is_squared() => {
                self.spare = planes;
                Ok(Frame::planar(Planes { form: Form { layout, coding }, data }, pixels)?)
            }
            Pixels::Planar(layout, coding) => {
                to_rgba(&layout, coding, &data, &mut pixels);
                self.spare = data;
                Ok(Frame::known(self.video.probed.info.size, pixels, !layout.alpha)?)
            }
            Pixels::Rgba => {
                pixels.clear();
                pixels.extend_from_slice(data.as_chunks::<4>().0);
                self.spare = data;
                Ok(Frame::new(self.video.probed.info.size, pixels)?)
            }
        }
    }

    /// How long the frame that starts at `start` is shown, and the last frame if there is no next.
    fn length(&self, start: Rational) -> Option<Rational> {
        if let Some(next) = &self.ahead {
            return Some(next.start - start);
        }
        match self.video.probed.track.end {
            Some(end) if end > start && matches!(self.outcome, Some(Ok(()))) => Some(end - start),
            _ => self.length,
        }
    }
}

impl Source for VideoSource {
    fn skip_to(&mut self, start: Rational) {
        self.from = start;
        let place = self.video.place(start);
        if self.received == 0
            && place != self.place
            && let Ok(source) = self.video.start_at(place)
        {
            *self = Self { from: start, ..source };
        }
    }

    fn recycle(&mut self, frame: Frame) {
        self.buffers = frame.into_buffers();
    }

    fn next(&mut self) -> Result<Option<Decoded>> {
        let Some(raw) = self.ahead.take().or_else(|| self.wanted()) else {
            return match self.outcome.take() {
                Some(Err(error)) => Err(self.failed(error)),
                _ => Ok(None),
            };
        };
        // A live input must not wait for the next frame.
        if !self.video.probed.info.live {
            self.ahead = self.read();
        }
        self.length = self.length(raw.start);
        let span = Span { start: raw.start, length: self.length };
        let frame = self.frame(raw.data)?;
        self.delivered += 1;
        Ok(Some(Decoded::new(frame, span)))
    }
}
