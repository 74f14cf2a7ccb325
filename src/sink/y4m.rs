//! Writes YUV4MPEG2 (y4m) for pipes. `source/y4m.rs` describes the format.
//!
//! The output is 4:2:0 with chroma sited as in MPEG-2 (other samplings on request). Its range is that of a video
//! source, else limited; the matrix follows from the size. A stream has one constant rate, the nominal one of the
//! source: a frame that is shown for longer is repeated, so that all frames begin within half a frame of their times.
//! No frame is dropped.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};

use crate::colour::{Coding, Form, Layout, Range, Sampling, Siting};
use crate::error::{Error, Result};
use crate::frame::{Buffers, Colorimetry, Rational, check_size};
use crate::geom::Size;
use crate::sink::place::Place;
use crate::sink::planes::fill_planes;
use crate::sink::{Needs, Origin, Picture, Sink, SinkOptions};
use crate::stream::StreamInfo;

/// The rate for frames of varying length without a nominal rate: the resolution of GIF delays.
const FINEST_RATE: Rational = Rational { num: 100, den: 1 };
/// The rate of a still: the default of y4m readers.
const STILL_RATE: Rational = Rational { num: 25, den: 1 };

/// Writes a y4m stream. Alpha is ignored.
pub struct Y4mSink<W> {
    output: W,
    path: PathBuf,
    form: Form,
    /// The header, until it is written with the first frame.
    header: Option<String>,
    planes: Vec<u8>,
    rate: Rational,
    /// The index of the next frame, counted from time 0; `None` before the first.
    next: Option<i64>,
    /// End of the last frame in seconds.
    end: Rational,
}

impl Y4mSink<io::Stdout> {
    /// A stream on standard output, for the input `info`.
    ///
    /// # Errors
    /// [`Error::Usage`] when that is a terminal.
    pub(crate) fn standard(info: &StreamInfo) -> Result<Box<dyn Sink>> {
        let output = standard_output()?;
        Ok(Box::new(Self::new(output, Path::new("-"), info, info.size, Sampling::Yuv420)?))
    }
}

impl Y4mSink<File> {
    /// A stream to the named pipe `path`, for the input `info`. Waits for a reader.
    ///
    /// # Errors
    /// [`Error::Output`] when it cannot be opened.
    pub(crate) fn pipe(path: &Path, info: &StreamInfo) -> Result<Box<dyn Sink>> {
        let output = File::options().write(true).open(path);
        let output = output.map_err(|e| Error::output(path, format!("cannot be opened: {e}")))?;
        Ok(Box::new(Self::new(output, path, info, info.size, Sampling::Yuv420)?))
    }
}

/// Standard output.
///
/// # Errors
/// [`Error::Usage`] when that is a terminal.
pub(crate) fn standard_output() -> Result<io::Stdout> {
    let output = io::stdout();
    if output.is_terminal() {
        return Err(Error::usage(
            "standard output is a terminal; pipe it into what reads video: polyreel ... -o - | ffplay -",
        ));
    }
    Ok(output)
}

/// A y4m stream in a file.
pub(crate) struct Y4mFile {
    stream: Box<Y4mSink<BufWriter<File>>>,
    place: Place,
}

impl Y4mFile {
    /// A file at `path`, for the input `info`.
    ///
    /// # Errors
    /// As [`Place::reserve`].
    pub(crate) fn create(path: &Path, info: &StreamInfo, options: &SinkOptions) -> Result<Self> {
        let place = Place::reserve(path, options)?;
        let file = place.file().try_clone().map_err(|error| place.failed(&error))?;
        let stream = Y4mSink::new(BufWriter::new(file), path, info, info.size, Sampling::Yuv420)?;
        Ok(Self { stream: Box::new(stream), place })
    }
}

impl Sink for Y4mFile {
    fn needs(&self) -> Needs {
        self.stream.needs()
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        self.stream.write(picture, origin)
    }

    fn finish(self: Box<Self>) -> Result<()> {
        self.stream.finish()?;
        self.place.commit()
    }
}

impl<W: Write + Send> Y4mSink<W> {
    /// A stream of pictures of `size`, for the input `info`. `path` is its name in messages (`-` for standard output).
    ///
    /// # Errors
    /// [`Error::Core`] when a side is 0 or too large.
    pub fn new(
        output: W,
        path: &Path,
        info: &StreamInfo,
        size: Size,
        sampling: Sampling,
    ) -> Result<Self> {
        check_size(size)?;
        let tags = info.colour.as_ref().map(|c| c.range.clone()).unwrap_or_default();
        let coding = Coding::of(&Colorimetry { range: tags, ..Colorimetry::default() }, size);
        let layout = Layout { size, sampling, siting: Siting::Left, alpha: false };
        let usual = if info.still { STILL_RATE } else { FINEST_RATE };
        let rate = info.rate.unwrap_or(usual);
        let space = match sampling {
            Sampling::Gray => "mono",
            Sampling::Yuv420 => "420mpeg2",
            Sampling::Yuv422 => "422",
            Sampling::Yuv444 => "444",
        };
        let range = if coding.range == Range::Full { "FULL" } else { "LIMITED" };
        let header = format!(
            "YUV4MPEG2 W{} H{} F{}:{} Ip A1:1 C{space} XCOLORRANGE={range}\n",
            size.width, size.height, rate.num, rate.den
        );
        let header = Some(header);
        Ok(Self {
            output,
            path: path.into(),
            form: Form { layout, coding },
            header,
            planes: Vec::new(),
            rate,
            next: None,
            end: Rational::ZERO,
        })
    }

    /// Repeats the last frame until `time`, in seconds.
    fn hold(&mut self, time: Rational) -> io::Result<()> {
        let ticks = time * self.rate;
        let tick = (2 * ticks.num + ticks.den).div_euclid(2 * ticks.den);
        let next = self.next.get_or_insert(tick);
        let missing = tick - *next;
        *next = tick.max(*next);
        (0..missing).try_for_each(|_| self.put())
    }

    /// Adds the output's name to an error. A closed pipe is [`Error::Closed`]: an end, not a failure.
    fn named(&self, result: io::Result<()>) -> Result<()> {
        result.map_err(|error| match error.kind() {
            io::ErrorKind::BrokenPipe => Error::Closed,
            _ => Error::output(&self.path, error.to_string()).caused_by(error),
        })
    }

    /// Writes the current planes as a frame, after the header if it is the first.
    fn put(&mut self) -> io::Result<()> {
        if let Some(header) = self.header.take() {
            self.output.write_all(header.as_bytes())?;
        }
        self.output.write_all(b"FRAME\n")?;
        self.output.write_all(&self.planes)?;
        // Readers of a pipe get each frame at once.
        self.output.flush()
    }
}

impl<W: Write + Send> Sink for Y4mSink<W> {
    fn needs(&self) -> Needs {
        let form = Some(self.form).filter(|form| form.layout.is_squared());
        Needs { form, ..Needs::default() }
    }

    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        let frame = &picture.frame;
        let size = self.form.layout.size;
        if frame.size() != size {
            let what = format!("a picture of {} among those of {size}", frame.size());
            return Err(Error::output(&self.path, what));
        }
        let held = self.hold(picture.span.start);
        self.named(held)?;
        let buffers = fill_planes(&mut self.planes, picture.frame, &self.form, None);
        let result = self.put();
        self.next = self.next.map(|next| next + 1);
        let length = picture.span.length.or(self.rate.recip()).unwrap_or(Rational::ZERO);
        self.end = picture.span.start + length;
        self.named(result)?;
        Ok(buffers)
    }

    fn finish(mut self: Box<Self>) -> Result<()> {
        let result = match self.header.take() {
            Some(header) => self.output.write_all(header.as_bytes()),
            None => self.hold(self.end),
        };
        let result = result.and_then(|()| self.output.flush());
        self.named(result)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::source::Source;
    use crate::source::y4m::Y4mSource;
    use crate::stream::Span;

    fn info(range: Option<&str>) -> StreamInfo {
        let colour = Colorimetry { range: range.map(String::from), ..Colorimetry::default() };
        let rate = Some(Rational::new(24000, 1001));
        StreamInfo { rate, colour: Some(colour), ..StreamInfo::of(Size::new(5, 3)) }
    }

    fn picture(frame: Frame) -> Picture {
        Picture { frame, fills: vec![], span: Span { start: Rational::ZERO, length: None } }
    }

    #[test]
    fn flat_colours_come_back() {
        let size = Size::new(5, 3);
        for sampling in [Sampling::Yuv420, Sampling::Yuv422, Sampling::Yuv444] {
            for range in [None, Some("pc")] {
                let mut bytes = Vec::new();
                let sink = Y4mSink::new(&mut bytes, Path::new("-"), &info(range), size, sampling);
                let mut sink = Box::new(sink.expect("a size"));
                for colour in [[250, 10, 90, 255], [3, 200, 100, 255]] {
                    sink.write(picture(Frame::filled(size, colour).expect("a size")), None)
                        .expect("memory");
                }
                sink.finish().expect("memory");
                let mut source = Y4mSource::new(&bytes[..], Path::new("-")).expect("our header");
                assert_eq!(source.info().rate, Some(Rational::new(24000, 1001)));
                for colour in [[250, 10, 90, 255], [3u8, 200, 100, 255]] {
                    let back = source.next().expect("whole").expect("a frame").frame;
                    for pixel in back.pixels() {
                        let off = (0..3).map(|i| pixel[i].abs_diff(colour[i])).max();
                        assert!(off <= Some(2), "{pixel:?} {colour:?} {sampling:?} {range:?}");
                    }
                }
                assert!(source.next().expect("the end").is_none());
            }
        }
    }

    #[test]
    fn long_frames_are_repeated_and_none_is_dropped() {
        let size = Size::new(2, 2);
        let mut bytes = Vec::new();
        let at10 = StreamInfo { rate: Some(Rational::new(10, 1)), ..info(None) };
        let sink = Y4mSink::new(&mut bytes, Path::new("-"), &at10, size, Sampling::Gray);
        let mut sink = Box::new(sink.expect("a size"));
        // The second and the third would both be number 1; the fourth begins late and lasts long.
        for (grey, start, length) in [(0, 0, 100), (60, 96, 40), (120, 140, 160), (180, 500, 310)] {
            let frame = Frame::filled(size, [grey, grey, grey, 255]).expect("a size");
            let (start, length) = (Rational::new(start, 1000), Rational::new(length, 1000));
            let span = Span { start, length: Some(length) };
            sink.write(Picture { span, ..picture(frame) }, None).expect("memory");
        }
        sink.finish().expect("memory");
        let mut source = Y4mSource::new(&bytes[..], Path::new("-")).expect("our header");
        let mut greys = Vec::new();
        while let Some(decoded) = source.next().expect("whole") {
            greys.push(decoded.frame.at(0, 0)[0] / 60);
        }
        assert_eq!(greys, [0, 1, 2, 2, 2, 3, 3, 3]);
    }

    /// A reader that goes away at once.
    struct Gone;

    impl Write for Gone {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::BrokenPipe.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_closed_pipe_is_reported_as_closed() {
        let size = Size::new(2, 2);
        let mut sink = Y4mSink::new(Gone, Path::new("-"), &info(None), size, Sampling::Yuv420)
            .expect("a size");
        let frame = Frame::filled(size, [0; 4]).expect("a size");
        assert!(matches!(sink.write(picture(frame), None), Err(Error::Closed)));
    }

    #[test]
    fn a_stream_without_frames_has_its_header() {
        let mut bytes = Vec::new();
        let size = Size::new(2, 2);
        let sink = Y4mSink::new(&mut bytes, Path::new("-"), &info(None), size, Sampling::Gray);
        Box::new(sink.expect("a size")).finish().expect("memory");
        assert!(bytes.starts_with(b"YUV4MPEG2 W2 H2 F24000:1001 Ip A1:1 Cmono"));
    }
}
