//! Writes video to places that take it as it comes: pipes, networks, playlists and devices. What was sent cannot be
//! changed afterwards, and encoders are set up for a short delay.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::error::{Error, Result};
use crate::ffmpeg::FfmpegError;
use crate::ffmpeg::child::Child;
use crate::ffmpeg::command::{self, arguments};
use crate::frame::{Buffers, Rational};
use crate::sink::container::Container;
use crate::sink::encoding::{Encoding, Feed};
use crate::sink::sound::{self, Streams};
use crate::sink::spec::{VideoOptions, VideoSpec};
use crate::sink::target::Target;
use crate::sink::unfinished::Entry;
use crate::sink::{Needs, Origin, Picture, Sink, SinkOptions};

/// Constant quality of H.264 on a network, where 18 of files would need too wide a line.
const CRF: u32 = 21;
/// Seconds between key frames, at which receivers can begin.
const KEY_SECONDS: i64 = 1;
/// Frames a second where the stream has no nominal rate.
const USUAL_RATE: Rational = Rational { num: 25, den: 1 };

/// A video on its way.
pub(crate) struct LiveSink {
    named: PathBuf,
    target: Target,
    spec: VideoSpec,
    streams: Option<Streams>,
    feed: Feed,
    child: Child,
    playlist: Option<Playlist>,
    _sound: Option<Entry>,
    warnings: Vec<String>,
    is_empty: bool,
}

impl LiveSink {
    /// Starts an encoder for `output`. `format` is the container, by default the usual one of the place; `live`
    /// whether frames come by a clock of their own.
    ///
    /// # Errors
    /// [`Error::Usage`] for options that cannot be meant, [`Error::Output`] when ffmpeg is missing or a pipe cannot be
    /// opened, [`Error::Input`] when the source of the sound cannot be read.
    pub(crate) fn create(
        output: &Path,
        target: Target,
        live: bool,
        spec: VideoSpec,
        with: &SinkOptions,
    ) -> Result<Self> {
        let container = container(output, target, with.format.as_deref())?;
        let video = &settings(&container, target, &with.video);
        let mut warnings = Vec::new();
        let encoding = Encoding::of(container, &spec, video, &mut warnings)?;
        let container = &encoding.container;
        let streams = match &spec.sound {
            Some(sound) if target != Target::Device => {
                Streams::of(sound, container, video, &mut warnings)?
            }
            _ => None,
        };
        let playlist = match target {
            Target::Playlist => Playlist::reserve(output, with)?,
            _ => None,
        };
        let (picture_args, sound_args) = sound::part(&video.ffmpeg_args);
        let mut args = encoding.reading();
        if target.is_paced() && !live {
            // In front of the input, which is the last option.
            args.splice(args.len() - 2..args.len() - 2, arguments([&"-re"]));
        }
        let end = spec.duration;
        args.extend(streams.iter().flat_map(|streams| streams.input_now(end)));
        args.extend(encoding.writing(video)?);
        if target.is_live() {
            args.extend(low_delay(&encoding, &spec, video));
        }
        args.extend(picture_args);
        if let Some(streams) = &streams {
            args.extend(streams.output(container, end));
            args.extend(sound_args);
        }
        args.extend(muxing(container, output, target, live));
        args.push(match target {
            Target::Pipe => "pipe:1".into(),
            _ => command::address(output),
        });
        let folder = streams.as_ref().and_then(Streams::folder);
        let _sound = folder.map(|folder| with.unfinished.add_temporary(&folder));
        let fail = |what: String| Error::output(output, what);
        let stdout = match target {
            Target::Pipe => opened(output)?,
            _ => Stdio::null(),
        };
        let mut child = Child::ffmpeg_to(stdout, &video.ffmpeg, &args)
            .map_err(|error| fail(error.to_string()).caused_by(error))?;
        match target {
            // A reader may pause for as long as it likes.
            Target::Pipe => child.wait_for_ever(),
            _ => child.be_patient(),
        }
        let stdin =
            child.stdin().ok_or_else(|| fail("ffmpeg came without standard input".into()))?;
        let feed = Feed::begin(stdin, &encoding, with.background);
        let named = output.to_owned();
        Ok(Self {
            named,
            target,
            spec,
            streams,
            feed,
            child,
            playlist,
            _sound,
            warnings,
            is_empty: true,
        })
    }

    /// The error of an encoder that takes no more frames, or ended badly.
    fn fallen(&mut self) -> Error {
        self.feed.close();
        let error = match self.child.wait() {
            Ok(_) => self.child.failure(false),
            Err(error) => FfmpegError::new(error.to_string()).caused_by(error),
        };
        if self.target == Target::Pipe && error.words().contains("Broken pipe") {
            return Error::Closed;
        }
        let what = match self.target {
            Target::Network => "the stream ended, since it cannot be sent any more",
            _ => "the encoder failed",
        };
        Error::output(&self.named, format!("{what}: {error}")).caused_by(error)
    }
}

impl Sink for LiveSink {
    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn needs(&self) -> Needs {
        Needs { live: self.target.is_live(), ..self.feed.needs(self.spec.size) }
    }

    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        if picture.frame.size() != self.spec.size {
            let (size, own) = (picture.frame.size(), self.spec.size);
            return Err(Error::output(
                &self.named,
                format!("a picture of {size} among those of {own}"),
            ));
        }
        self.is_empty = false;
        match self.feed.write(picture) {
            Ok((_, buffers)) => Ok(buffers),
            Err(_) => Err(self.fallen()),
        }
    }

    fn finish(mut self: Box<Self>) -> Result<()> {
        if self.is_empty {
            return Err(Error::output(&self.named, "there is not one frame to write"));
        }
        self.feed.close();
        self.streams.iter().for_each(Streams::end_pipe);
        let ended = self.child.wait().map_err(|e| Error::output(&self.named, e.to_string()))?;
        if !ended.success() {
            return Err(self.fallen());
        }
        if let Some(playlist) = &mut self.playlist {
            playlist.is_whole = true;
        }
        Ok(())
    }
}

/// A playlist in a folder. If it is dropped before it is whole, it and its segments are removed.
struct Playlist {
    path: PathBuf,
    is_whole: bool,
}

impl Playlist {
    /// Takes the place of `path`; `None` if it is on another machine.
    ///
    /// # Errors
    /// When it is there already.
    fn reserve(path: &Path, with: &SinkOptions) -> Result<Option<Self>> {
        if command::is_url(path) {
            return Ok(None);
        }
        super::place::check_target(path, with)?;
        let playlist = Self { path: path.to_owned(), is_whole: false };
        playlist.remove();
        Ok(Some(playlist))
    }

    /// Removes the list and the segments that it names.
    fn remove(&self) {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let list = fs::read_to_string(&self.path).unwrap_or_default();
        let own = |line: &&str| line.strip_prefix(&*stem).is_some_and(is_segment);
        for segment in list.lines().filter(own) {
            // What is gone already need not be removed.
            let _ = fs::remove_file(folder.join(segment));
        }
        let _ = fs::remove_file(&self.path);
    }
}

impl Drop for Playlist {
    fn drop(&mut self) {
        if !self.is_whole {
            self.remove();
        }
    }
}

/// Whether `rest` of a name, after the playlist's own, is that of a segment.
fn is_segment(rest: &str) -> bool {
    let number = rest.strip_prefix('_').and_then(|rest| rest.strip_suffix(".ts"));
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()))
}

/// The container of `output`: that of `format`, or else the usual one of its place.
fn container(output: &Path, target: Target, format: Option<&str>) -> Result<Container> {
    if let Some(format) = format {
        return Ok(Container::named(format));
    }
    let scheme = output.to_str().and_then(|text| text.split_once("://")).map(|(scheme, _)| scheme);
    Ok(match (target, scheme.unwrap_or("").to_ascii_lowercase().as_str()) {
        (Target::Playlist, _) => Container::Hls,
        (Target::Device, _) => Container::Device,
        (Target::Network, "rtmp" | "rtmps" | "rtmpt" | "rtmpe") => Container::Flv,
        (Target::Network, "srt" | "udp" | "tcp" | "rist") => Container::Ts,
        (Target::Network, "rtp") => Container::named("rtp_mpegts"),
        (Target::Network, "rtsp" | "rtsps") => Container::named("rtsp"),
        _ => Container::of(output).ok_or_else(|| {
            Error::usage(format!(
                "{}: what is to be sent there? name it with --format, for instance --format mpegts",
                output.display()
            ))
        })?,
    })
}

/// The options of the encoder where none are given.
fn settings(container: &Container, target: Target, given: &VideoOptions) -> VideoOptions {
    let mut video = given.clone();
    let unnamed = video.codec.is_none();
    if target.is_live() && unnamed && matches!(container, Container::Other(_)) {
        video.codec = Some("h264".into());
    }
    let is_h264 = !matches!(container, Container::WebM | Container::Ogg | Container::Device);
    if target.is_live() && unnamed && is_h264 {
        video.crf = video.crf.or(Some(CRF));
    }
    video
}

/// Options that keep the delay of the encoder short, and let receivers begin soon.
fn low_delay(encoding: &Encoding, spec: &VideoSpec, given: &VideoOptions) -> Vec<OsString> {
    let rate = spec.rate.filter(|rate| rate.num > 0).unwrap_or(USUAL_RATE);
    let frames = (rate * Rational::new(KEY_SECONDS, 1)).to_f64().ceil().max(1.0);
    let mut args = arguments([&"-g", &frames.to_string()]);
    let unset = given.encoder_preset.is_none();
    match encoding.encoder.name.as_str() {
        name @ ("libx264" | "libx265") => {
            args.extend(arguments([&"-tune", &"zerolatency"]));
            args.extend(arguments([&"-maxrate", &"8M", &"-bufsize", &"4M"]));
            if unset {
                let preset = if name == "libx264" { "veryfast" } else { "ultrafast" };
                args.extend(arguments([&"-preset", &preset]));
            }
        }
        "libvpx" | "libvpx-vp9" => {
            args.extend(arguments([&"-deadline", &"realtime", &"-lag-in-frames", &"0"]));
            if unset {
                args.extend(arguments([&"-cpu-used", &"8"]));
            }
        }
        "libsvtav1" if unset => args.extend(arguments([&"-preset", &"11"])),
        _ => {}
    }
    args
}

/// Options of the container, the last before the output.
fn muxing(container: &Container, output: &Path, target: Target, live: bool) -> Vec<OsString> {
    let mut args = match container {
        Container::Mp4 | Container::Mov => {
            // In pieces, since nothing before can be changed.
            // Frames in order, since their table cannot begin before 0.
            let flags = "+frag_keyframe+empty_moov+default_base_moof";
            arguments([&"-bf", &"0", &"-movflags", &flags])
        }
        Container::Ts => arguments([&"-muxdelay", &"0", &"-muxpreload", &"0"]),
        Container::Flv => arguments([&"-flvflags", &"+no_duration_filesize"]),
        Container::Hls => {
            let mut segments = output.with_extension("").into_os_string();
            if let Some(text) = segments.to_str().filter(|text| text.contains('%')) {
                segments = text.replace('%', "%%").into();
            }
            segments.push("_%05d.ts");
            let (seconds, kept) = if live { ("1", "6") } else { ("2", "0") };
            let flags = if live { "+delete_segments" } else { "" };
            let mut args = arguments([&"-hls_time", &seconds, &"-hls_list_size", &kept]);
            let flags = format!("+independent_segments{flags}");
            args.extend(arguments([&"-hls_flags", &flags, &"-hls_segment_filename", &segments]));
            if !live {
                args.extend(arguments([&"-hls_playlist_type", &"event"]));
            }
            if command::is_url(output) {
                args.extend(arguments([&"-method", &"PUT"]));
            }
            args
        }
        _ => Vec::new(),
    };
    if target != Target::Device {
        args.extend(arguments([&"-flush_packets", &"1"]));
    }
    args.extend(arguments([&"-f", &container.muxer()]));
    args
}

/// The pipe `output`, opened; a named one waits for a reader.
fn opened(output: &Path) -> Result<Stdio> {
    if output == Path::new("-") || output == Path::new("/dev/stdout") {
        return super::y4m::standard_output().map(|_| Stdio::inherit());
    }
    let file = fs::OpenOptions::new().write(true).open(output);
    let file = file.map_err(|e| Error::output(output, format!("cannot be opened: {e}")))?;
    Ok(file.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_have_their_usual_containers() {
        let of = |name: &str, target| container(Path::new(name), target, None);
        assert_eq!(of("rtmp://h/a", Target::Network).expect("known"), Container::Flv);
        assert_eq!(of("srt://h:9", Target::Network).expect("known"), Container::Ts);
        assert_eq!(of("x.m3u8", Target::Playlist).expect("known"), Container::Hls);
        assert_eq!(of("pipe.mkv", Target::Pipe).expect("known"), Container::Mkv);
        let error = of("gopher://h", Target::Network).expect_err("unknown").to_string();
        assert!(error.contains("--format"), "{error}");
        let named = container(Path::new("-"), Target::Pipe, Some("mpegts"));
        assert_eq!(named.expect("known"), Container::Ts);
    }

    #[test]
    fn a_device_gets_raw_pictures() {
        let args = muxing(&Container::Device, Path::new("/dev/video9"), Target::Device, false);
        assert_eq!(args, ["-f", "v4l2"]);
    }

    #[test]
    fn only_own_segments_are_removed() {
        let dir = tempfile::tempdir().expect("a folder");
        let path = |name: &str| dir.path().join(name);
        let names = ["x_00000.ts", "x_00001.ts", "y_00000.ts", "x_notes.ts"];
        names.iter().for_each(|name| fs::write(path(name), "").expect("a file"));
        fs::write(path("x.m3u8"), format!("#EXTM3U\n{}\n../z\n", names.join("\n")))
            .expect("a list");
        drop(Playlist { path: path("x.m3u8"), is_whole: false });
        let left = |name: &&str| path(name).exists();
        assert_eq!(names.iter().filter(|name| left(name)).count(), 2);
        assert!(!path("x.m3u8").exists() && path("x_notes.ts").exists());
    }
}
