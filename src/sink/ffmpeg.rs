//! Writes video files by the ffmpeg of the machine.
//!
//! Frames are sent as planar 4:2:0 in a NUT stream, with their exact times, so that ffmpeg neither converts nor
//! guesses. The file is written to a temporary file in the same folder, and renamed when it is complete.

use std::ffi::OsString;
use std::path::Path;

use crate::error::{Cause, Error, Result};
use crate::ffmpeg::child::Child;
use crate::ffmpeg::command;
use crate::ffmpeg::probe::{probe_lead, probe_packet};
use crate::ffmpeg::{Ffmpeg, FfmpegError};
use crate::frame::{Buffers, Rational};
use crate::sink::encoding::{Encoding, Feed};
use crate::sink::place::Place;
use crate::sink::remux::{Finished, Last, SoundSource, bare, placing, remux};
use crate::sink::sound::{self, Streams};
use crate::sink::unfinished::Entry;
use crate::sink::{Needs, Origin, Picture, Sink, SinkOptions};

pub use crate::sink::container::Container;
pub(crate) use crate::sink::live::LiveSink;
pub use crate::sink::spec::{VideoOptions, VideoSpec};

/// Writes a video file.
pub struct VideoSink {
    encoding: Encoding,
    ffmpeg: Ffmpeg,
    spec: VideoSpec,
    streams: Option<Streams>,
    /// Whether the sound is added while the picture is encoded.
    along: bool,
    sound_args: Vec<OsString>,
    /// Whether the user's own options may have dropped the picture.
    checks_output: bool,
    warnings: Vec<String>,
    feed: Feed,
    child: Child,
    /// After the child: it is ended before its file is removed.
    place: Place,
    _sound: Option<Entry>,
    first: Option<Rational>,
    last_pts: Option<u64>,
    /// Units between the last two frames, and whether these ever differed by more than a millisecond.
    step: Option<u64>,
    is_uneven: bool,
    count: u64,
    end: Rational,
}

impl VideoSink {
    /// Starts an encoder for the file `path`, whose extension chooses the container. Of `with`,
    /// `sound` is not looked at: that of `spec` counts.
    ///
    /// # Errors
    /// [`Error::Usage`] for options that cannot be meant, [`Error::Output`] when ffmpeg is missing or
    /// there is no place to write to, [`Error::Input`] when the source of the sound cannot be read.
    pub fn create(path: &Path, spec: VideoSpec, with: &SinkOptions) -> Result<Self> {
        let container = Container::of(path).ok_or_else(|| {
            Error::usage(format!("{}: not the name of a video, such as .mp4", path.display()))
        })?;
        Self::create_in(container, path, spec, with)
    }

    /// The same in a `container` that the name need not tell.
    ///
    /// # Errors
    /// As [`VideoSink::create`].
    pub(crate) fn create_in(
        container: Container,
        path: &Path,
        spec: VideoSpec,
        with: &SinkOptions,
    ) -> Result<Self> {
        let SinkOptions { background, video: options, .. } = with;
        let mut warnings = Vec::new();
        let encoding = Encoding::of(container, &spec, options, &mut warnings)?;
        let container = &encoding.container;
        let ffmpeg = &options.ffmpeg;
        let streams = match &spec.sound {
            Some(sound) => Streams::of(sound, container, options, &mut warnings)?,
            None => None,
        };
        let place = Place::reserve_named(path, with)?;
        let (picture_args, sound_args) = sound::part(&options.ffmpeg_args);
        let along = streams.as_ref().filter(|streams| streams.go_along());
        let mut args = encoding.reading();
        args.extend(along.iter().flat_map(|streams| streams.input(None)));
        args.extend(encoding.writing(options)?);
        args.extend(picture_args);
        if let Some(streams) = along {
            args.extend(streams.output(container, None));
            args.extend(sound_args.iter().cloned());
            args.extend(bare(container, false));
        }
        let last = streams.is_none() || along.is_some();
        args.extend(placing(container, encoding.time_base, last));
        args.push(command::address(place.path()));
        args.extend(along.iter().flat_map(|streams| streams.along()));
        let along = along.is_some();
        let folder = streams.as_ref().and_then(Streams::folder);
        let sound_entry = folder.map(|folder| with.unfinished.add_temporary(&folder));
        let fail = |what: String| Error::output(path, what);
        let mut child = Child::ffmpeg(ffmpeg, &args)
            .map_err(|error| fail(error.to_string()).caused_by(error))?;
        if streams.as_ref().is_some_and(Streams::is_piped) {
            // It waits for sound of another process, which may wait for a network.
            child.be_patient();
        }
        if options.gives_way {
            // When the stages before it have to wait for their turn it runs dry, and then a core has
            // nothing to do.
            child.give_way();
        }
        let stdin =
            child.stdin().ok_or_else(|| fail("ffmpeg came without standard input".into()))?;
        Ok(Self {
            feed: Feed::begin(stdin, &encoding, *background),
            encoding,
            ffmpeg: options.ffmpeg.clone(),
            spec,
            streams,
            along,
            sound_args,
            checks_output: !options.ffmpeg_args.is_empty(),
            warnings,
            child,
            place,
            _sound: sound_entry,
            first: None,
            last_pts: None,
            step: None,
            is_uneven: false,
            count: 0,
            end: Rational::ZERO,
        })
    }

    /// The error of an encoder that takes no more frames.
    fn fallen(&mut self) -> Error {
        self.feed.close();
        let error = match self.child.wait() {
            Ok(_) => self.child.failure(false),
            Err(error) => FfmpegError::new(error.to_string()).caused_by(error),
        };
        let advice = self.encoding.encoder.advice(error.words());
        match advice {
            Some(advice) if !self.encoding.encoder.is_common() => {
                Error::usage(format!("{}: {advice}", self.place.named().display()))
            }
            Some(advice) => Error::output(self.place.named(), advice).caused_by(error),
            None => Error::output(self.place.named(), format!("the encoder failed: {error}"))
                .caused_by(error),
        }
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
            self.is_uneven |= apart as f64 * self.encoding.time_base.to_f64() > 1e-3;
        }
    }

    /// The last frame, if ffmpeg may have written a wrong duration for it.
    fn last(&self) -> Option<Last> {
        let Encoding { container, time_base, .. } = &self.encoding;
        if !container.holds_lengths() {
            return None;
        }
        let start = Rational::new(i64::try_from(self.last_pts?).ok()?, 1) * *time_base;
        let length = self.end - start;
        let off = self.spec.rate.and_then(Rational::recip).is_none_or(|nominal| {
            let difference = length - nominal;
            difference.max(-difference) > Rational::new(1, 1000)
        });
        let number = self.count.checked_sub(1)?;
        // ffmpeg ends QuickTime's tables with the last packet in decoding order, which after a hold is too early.
        let off = off || self.is_uneven && container.is_quicktime();
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
        let is_piped = self.streams.as_ref().is_some_and(Streams::is_piped);
        if is_piped || self.encoding.container == Container::WebP {
            // What was piped is gone; times of WebP are exact, and ffmpeg does not read it.
            return Ok(None);
        }
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
            container: &self.encoding.container,
            time_base: self.encoding.time_base,
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
        self.feed.needs(self.spec.size)
    }

    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        let span = picture.span;
        if picture.frame.size() != self.spec.size {
            let (size, own) = (picture.frame.size(), self.spec.size);
            let what = format!("a picture of {size} among those of {own}");
            return Err(Error::output(self.place.named(), what));
        }
        let Ok((pts, buffers)) = self.feed.write(picture) else { return Err(self.fallen()) };
        self.first.get_or_insert(Rational::new(pts as i64, 1) * self.encoding.time_base);
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
        self.feed.close();
        self.streams.iter().for_each(Streams::end_pipe);
        let status =
            self.child.wait().map_err(|e| Error::output(self.place.named(), e.to_string()))?;
        // With sound in it, a complaint may be of that: the last step, which looks at the picture
        // alone and puts the sound in anew, decides.
        let complained = self.child.complained();
        if !status.success() || complained && !self.along {
            return Err(self.fallen());
        }
        if self.checks_output && self.encoding.container != Container::WebP {
            self.check_output()?;
        }
        let completed = self.complete(complained)?;
        completed.unwrap_or(self.place).commit()
    }
}
