//! Writes video files by the ffmpeg of the machine.
//!
//! Frames are sent as planar 4:2:0 in a NUT stream, with their exact times, so that ffmpeg neither converts nor
//! guesses. The file is written to a temporary file in the same folder, and renamed when it is complete.

use std::ffi::OsString;
use std::io;
use std::path::Path;
use std::process::ChildStdin;

use crate::colour::{Coding, Form, Layout};
use crate::error::{Cause, Error, Result};
use crate::ffmpeg::child::Child;
use crate::ffmpeg::command::{self, arguments};
use crate::ffmpeg::nut::NutWriter;
use crate::ffmpeg::probe::{probe_lead, probe_packet};
use crate::ffmpeg::{Ffmpeg, FfmpegError, Pipe};
use crate::frame::{Buffers, Colorimetry, Rational, Rgba, check_size};
use crate::geom::Size;
use crate::sink::codec::Encoder;
use crate::sink::place::Place;
use crate::sink::planes::fill_planes;
use crate::sink::remux::{Finished, Last, SoundSource, bare, placing, remux};
use crate::sink::sound::{self, Streams};
use crate::sink::tags::{tag_arguments, tags};
use crate::sink::{Needs, Origin, Picture, Sink, SinkOptions};

pub use crate::sink::codec::Container;
pub use crate::sink::spec::{VideoOptions, VideoSpec};

/// Writes a video file.
pub struct VideoSink {
    container: Container,
    ffmpeg: Ffmpeg,
    background: Rgba,
    spec: VideoSpec,
    form: Form,
    time_base: Rational,
    streams: Option<Streams>,
    /// Whether the sound is added while the picture is encoded.
    along: bool,
    sound_args: Vec<OsString>,
    /// Whether the user's own options may have dropped the picture.
    checks_output: bool,
    warnings: Vec<String>,
    /// `None` once it is closed.
    writer: Option<NutWriter<Pipe<ChildStdin>>>,
    child: Child,
    /// After the child: it is ended before its file is removed.
    place: Place,
    planes: Vec<u8>,
    first: Option<Rational>,
    last_pts: Option<u64>,
    /// Units between the last two frames, and whether these ever differed by more than a millisecond.
    step: Option<u64>,
    is_uneven: bool,
    count: u64,
    end: Rational,
}

/// Units of time: 1/90000 s, which holds milliseconds and the usual rates, made finer until a frame
/// of the nominal rate is a whole number of them, within the limits of what readers of MP4 take. A mean rate is
/// none whose frames have to be whole.
fn time_base(rate: Option<Rational>) -> Rational {
    const USUAL: i64 = 90_000;
    // ffmpeg's reader takes no table with an offset above 2^28 units between decoding and showing a frame, so
    // this is also how long a frame may be held: 64 s.
    const FINEST: i64 = 1 << 22;
    let rate = rate.filter(|rate| rate.num > 0);
    let fine = rate.and_then(|rate| {
        let common = Rational::new(rate.num, USUAL);
        // Least common multiple of numerator and 90000.
        let whole = rate.num.checked_mul(common.den).filter(|den| *den < FINEST);
        // Else a multiple of the numerator alone.
        whole.or_else(|| Some(rate.num * (USUAL / rate.num + 1)).filter(|den| *den < FINEST))
    });
    Rational::new(1, fine.unwrap_or(USUAL))
}

/// The same for encoders that count in at most `limit` units a second: a frame of the nominal rate,
/// or else a millisecond.
fn coarse_time_base(rate: Option<Rational>, limit: i64) -> Rational {
    rate.filter(|rate| rate.num > 0 && rate.num <= limit)
        .and_then(Rational::recip)
        .unwrap_or(Rational::new(1, 1000))
}

impl VideoSink {
    /// Starts an encoder for the file `path`, whose extension chooses the container. Of `with`,
    /// `sound` is not looked at: that of `spec` counts.
    ///
    /// # Errors
    /// [`Error::Usage`] for options that cannot be meant, [`Error::Output`] when ffmpeg is missing or
    /// there is no place to write to, [`Error::Input`] when the source of the sound cannot be read.
    pub fn create(path: &Path, spec: VideoSpec, with: &SinkOptions) -> Result<Self> {
        let SinkOptions { background, video: options, .. } = with;
        check_size(spec.size)?;
        let container = Container::of(path).ok_or_else(|| {
            Error::usage(format!("{}: not .mp4, .mov, .mkv or .webm", path.display()))
        })?;
        let encoder = Encoder::of(options.codec.as_deref(), container);
        let mut warnings = Vec::new();
        let size = if encoder.takes_odd() { spec.size } else { even(spec.size) };
        if size != spec.size {
            warnings.push(format!(
                "{} cannot hold {}: the last column or row is repeated, to {size}; WebM keeps odd sizes",
                encoder.name, spec.size
            ));
        }
        let tags = tags(spec.colour.as_ref());
        let coding = Coding::of(&tags, spec.size);
        let time_base = match encoder.most_units() {
            Some(limit) => coarse_time_base(spec.rate, limit),
            None => time_base(spec.rate),
        };
        let ffmpeg = &options.ffmpeg;
        let streams = match &spec.sound {
            Some(sound) => Streams::of(sound, ffmpeg, container, options.audio, &mut warnings)?,
            None => None,
        };
        let place = Place::reserve_named(path, with)?;
        let (picture_args, sound_args) = sound::part(&options.ffmpeg_args);
        let along = streams.as_ref().filter(|streams| streams.go_along());
        let mut args = reading(&tags);
        args.extend(along.iter().flat_map(|streams| streams.input(None)));
        args.extend(leaving(time_base));
        args.extend(encoder.tag(container));
        args.extend(encoder.options(options.crf, options.encoder_preset.as_deref())?);
        args.extend(tag_arguments(&tags));
        args.extend(picture_args);
        if let Some(streams) = along {
            args.extend(streams.output(container, None));
            args.extend(sound_args.iter().cloned());
            args.extend(bare(container, false));
        }
        args.extend(placing(container, time_base, streams.is_none() || along.is_some()));
        args.push(command::address(place.path()));
        args.extend(along.iter().flat_map(|streams| streams.along()));
        let along = along.is_some();
        let fail = |what: String| Error::output(path, what);
        let mut child = Child::ffmpeg(ffmpeg, &args)
            .map_err(|error| fail(error.to_string()).caused_by(error))?;
        if options.gives_way {
            // When the stages before it have to wait for their turn it runs dry, and then a core has
            // nothing to do.
            child.give_way();
        }
        let stdin =
            child.stdin().ok_or_else(|| fail("ffmpeg came without standard input".into()))?;
        // A write error is reported at the first frame, with ffmpeg's message.
        let writer = NutWriter::new(stdin, size, *b"I420", time_base, spec.rate).ok();
        let layout = Layout::of_video(size);
        Ok(Self {
            container,
            ffmpeg: options.ffmpeg.clone(),
            background: *background,
            spec,
            form: Form { layout, coding },
            time_base,
            streams,
            along,
            sound_args,
            checks_output: !options.ffmpeg_args.is_empty(),
            warnings,
            writer,
            child,
            place,
            planes: Vec::new(),
            first: None,
            last_pts: None,
            step: None,
            is_uneven: false,
            count: 0,
            end: Rational::ZERO,
        })
    }

    /// The time of a picture in units of the time base: the nearest, but after the one before.
    fn pts(&self, start: Rational) -> u64 {
        let (num, den) = (i128::from(start.num), i128::from(start.den));
        let nearest = (2 * num * i128::from(self.time_base.den) + den).div_euclid(2 * den);
        let nearest = u64::try_from(nearest.max(0)).unwrap_or(u64::MAX >> 1);
        self.last_pts.map_or(nearest, |last| nearest.max(last + 1))
    }

    /// The error of an encoder that takes no more frames.
    fn fallen(&mut self) -> Error {
        self.writer = None;
        let error = match self.child.wait() {
            Ok(_) => self.child.failure(false),
            Err(error) => FfmpegError::new(error.to_string()).caused_by(error),
        };
        Error::output(self.place.named(), format!("the encoder failed: {error}")).caused_by(error)
    }

    /// The end of the sound, if before its own end: that of the picture, if it was asked to end early or was stopped.
    fn sound_end(&self, streams: &Streams) -> Option<Rational> {
        let whole = self.spec.duration.is_some_and(|duration| {
            // Containers round durations; a difference of a frame or two is not an early end.
            let nominal = self.spec.rate.and_then(Rational::recip).unwrap_or(Rational::ZERO);
            self.end + Rational::new(1, 10) + nominal >= duration
        });
        (streams.source().cut || !whole).then_some(self.end)
    }

    fn note_step(&mut self, pts: u64) {
        if let Some(last) = self.last_pts.replace(pts) {
            let step = pts - last;
            let apart = self.step.replace(step).map_or(0, |before| before.abs_diff(step));
            self.is_uneven |= apart as f64 * self.time_base.to_f64() > 1e-3;
        }
    }

    /// The last frame, if ffmpeg may have written a wrong duration for it.
    fn last(&self) -> Option<Last> {
        let start = Rational::new(i64::try_from(self.last_pts?).ok()?, 1) * self.time_base;
        let length = self.end - start;
        let off = self.spec.rate.and_then(Rational::recip).is_none_or(|nominal| {
            let difference = length - nominal;
            difference.max(-difference) > Rational::new(1, 1000)
        });
        let number = self.count.checked_sub(1)?;
        // ffmpeg ends QuickTime's tables with the last packet in decoding order, which after a hold is too early.
        let off = off || self.is_uneven && self.container.is_quicktime();
        (off && length > Rational::ZERO).then_some(Last { number, start, length })
    }

    /// Whether the written file has a picture, whatever the user's options.
    fn check_output(&self) -> Result<()> {
        if probe_packet(self.place.path(), &self.ffmpeg).unwrap_or(false) {
            return Ok(());
        }
        let what = "ffmpeg wrote no frame of the picture; look at the options in --ffmpeg-args";
        Err(Error::output(self.place.named(), what))
    }

    /// Adds the data that was not known before. `None` if there is nothing to add: the picture begins at 0, and the
    /// sound, if any, was added with it, was not `doubtful`, and ends where it should.
    fn complete(&self, doubtful: bool) -> Result<Option<Place>> {
        let last = self.last();
        let first = self.first.unwrap_or(Rational::ZERO);
        let heard = |streams| self.along && !doubtful && self.sound_end(streams).is_none();
        if first == Rational::ZERO && self.streams.as_ref().is_none_or(heard) && last.is_none() {
            return Ok(None);
        }
        let fail = |cause: Cause| {
            let what = format!("the file could not be completed: {cause}");
            Error::output(self.place.named(), what).caused_by(cause)
        };
        let ffmpeg = &self.ffmpeg;
        let completed = self.place.another()?;
        let mut picture = Finished {
            path: self.place.path(),
            container: self.container,
            time_base: self.time_base,
            first,
            last,
            lead: Rational::ZERO,
        };
        if self.along {
            picture.lead = probe_lead(picture.path, ffmpeg).map_err(|e| fail(e.into()))?;
        }
        let sound = self.streams.as_ref().map(|streams| SoundSource {
            streams,
            end: self.sound_end(streams),
            options: &self.sound_args,
        });
        remux(&picture, sound.as_ref(), completed.path(), ffmpeg).map_err(|e| fail(e.into()))?;
        Ok(Some(completed))
    }
}

impl Sink for VideoSink {
    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn needs(&self) -> Needs {
        let Layout { size, .. } = self.form.layout;
        let fits = |form: &Form| form.layout.is_squared() && size == self.spec.size;
        Needs { form: Some(self.form).filter(fits), ..Needs::default() }
    }

    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        let (frame, span) = (picture.frame, picture.span);
        if frame.size() != self.spec.size {
            let what = format!("a picture of {} among those of {}", frame.size(), self.spec.size);
            return Err(Error::output(self.place.named(), what));
        }
        let pts = self.pts(span.start);
        let buffers = fill_planes(&mut self.planes, frame, &self.form, Some(self.background));
        let written = match &mut self.writer {
            Some(writer) => writer.write(pts, &self.planes),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        };
        if written.is_err() {
            return Err(self.fallen());
        }
        self.first.get_or_insert(Rational::new(pts as i64, 1) * self.time_base);
        self.note_step(pts);
        self.count += 1;
        let length = span.length.or(self.spec.rate.and_then(Rational::recip));
        self.end = span.start + length.unwrap_or(Rational::ZERO);
        Ok(buffers)
    }

    fn finish(mut self: Box<Self>) -> Result<()> {
        if self.first.is_none() {
            return Err(Error::output(self.place.named(), "there is not one frame to write"));
        }
        self.writer = None;
        let status =
            self.child.wait().map_err(|e| Error::output(self.place.named(), e.to_string()))?;
        // With sound in it, a complaint may be of that: the last step, which looks at the picture
        // alone and puts the sound in anew, decides.
        let complained = self.child.complained();
        if !status.success() || complained && !self.along {
            return Err(self.fallen());
        }
        if self.checks_output {
            self.check_output()?;
        }
        let completed = self.complete(complained)?;
        completed.unwrap_or(self.place).commit()
    }
}

/// Both sides rounded up to even.
fn even(size: Size) -> Size {
    Size::new(size.width.next_multiple_of(2), size.height.next_multiple_of(2))
}

/// The options that read our frames.
fn reading(tags: &Colorimetry) -> Vec<OsString> {
    let mut args = arguments([&"-nostdin", &"-hide_banner", &"-loglevel", &"level+warning", &"-y"]);
    // The headers are complete: ffmpeg must not buffer frames to analyse them.
    args.extend(arguments([&"-probesize", &"32", &"-analyzeduration", &"0"]));
    args.extend(arguments([&"-fpsprobesize", &"0", &"-f", &"nut"]));
    // The input is tagged as well, so that ffmpeg converts nothing.
    args.extend(tag_arguments(tags));
    args.extend(arguments([&"-i", &"pipe:0"]));
    args
}

/// The options that keep frames and times as they are.
fn leaving(time_base: Rational) -> Vec<OsString> {
    let units = format!("{}:{}", time_base.num, time_base.den);
    let mut args = arguments([&"-map", &"0:v:0", &"-pix_fmt", &"yuv420p"]);
    args.extend(arguments([&"-fps_mode", &"passthrough", &"-enc_time_base:v", &units]));
    args
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_a_whole_number_of_units() {
        for (num, den) in [(24, 1), (25, 1), (30000, 1001), (24000, 1001), (60000, 1001), (8, 1)] {
            let rate = Rational::new(num, den);
            let length = rate.recip().expect("a rate is not 0");
            let base = time_base(Some(rate));
            let units = length * base.recip().expect("a rate is not 0");
            assert_eq!(units.den, 1, "{rate} in {base}");
            assert_eq!(base.num, 1);
        }
        assert_eq!(time_base(Some(Rational::new(1_000_000_007, 3))).den, 90_000);
        let ntsc = Rational::new(30000, 1001);
        assert_eq!(coarse_time_base(Some(ntsc), 65535), Rational::new(1001, 30000));
        assert_eq!(coarse_time_base(None, 65535), Rational::new(1, 1000));
    }
}
