//! Reads YUV4MPEG2 (y4m), the raw video of pipes: a line of text, then the planes of each frame after a line of its
//! own.
//!
//! 4:2:0 (sited as JPEG, MPEG-2 or PAL DV), 4:1:1, 4:2:2, 4:4:4, 4:4:4 with alpha, and mono; of 8 bits, and all but
//! 4:1:1 of up to 16, which become 8. The
//! range is that of `XCOLORRANGE=FULL` or `LIMITED`, by default limited. There is no field for the matrix: the size
//! decides it ([`Coding::of`]). The frame rate is constant. Reference: yuv4mpeg(5) of mjpegtools, and ffmpeg's reader
//! and writer.

use std::fs::File;
use std::io::{self, BufRead, BufReader, IsTerminal, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::imageops::{self, FilterType};

use crate::colour::{Coding, Form, Layout, Planes, to_rgba};
use crate::error::{Error, Result};
use crate::frame::{Buffers, Colorimetry, Frame, Rational, check_size};
use crate::geom::Size;
use crate::source::y4m_samples::{self, Samples};
use crate::source::{Decoded, Input, Source, detect};
use crate::stream::{Loops, Span, StreamInfo};

/// Advice in messages about other formats.
const CURE: &str = "ffmpeg makes one with -f yuv4mpegpipe";
/// The first bytes of a stream.
pub const MAGIC: &[u8] = b"YUV4MPEG2";
/// The longest line of text that is read, in bytes.
const MAX_LINE: u64 = 4096;
/// Rate of a stream without one; ffmpeg's default.
const DEFAULT_RATE: Rational = Rational { num: 25, den: 1 };

/// A y4m stream being read.
pub struct Y4mSource<R> {
    input: BufReader<R>,
    path: PathBuf,
    info: StreamInfo,
    header: Header,
    planes: Vec<u8>,
    /// The bytes of a frame whose samples must be converted.
    raw: Vec<u8>,
    /// Of a recycled frame.
    buffers: Buffers,
    count: u64,
    /// Frames before this time are skipped, in seconds.
    from: Rational,
}

/// The first line.
#[derive(Clone, Debug, PartialEq)]
struct Header {
    layout: Layout,
    samples: Samples,
    rate: Rational,
    /// Width of a pixel by its height.
    aspect: Rational,
    /// `XCOLORRANGE`, by ffmpeg's names.
    range: Option<String>,
    /// Whether fields of a frame belong to different times.
    is_interlaced: bool,
    /// Length of the line.
    bytes: u64,
}

/// Opens y4m on standard input. Its header is read now.
///
/// # Errors
/// As [`Y4mSource::new`], and when standard input is a terminal.
pub(crate) fn open_standard() -> Result<Input> {
    let input = io::stdin();
    if input.is_terminal() {
        return Err(Error::input(
            "-",
            "standard input is a terminal; pipe y4m into it: ffmpeg -i clip.mp4 -f yuv4mpegpipe - | \
             polyreel ...",
        ));
    }
    Ok(piped(Y4mSource::new(input, Path::new("-"))?, Arc::from([])))
}

/// Whether y4m waits on standard input, or nothing that could be something else. Nothing is taken from it.
pub(crate) fn waits_on_standard_input() -> bool {
    let input = io::stdin();
    if input.is_terminal() {
        return true;
    }
    input
        .lock()
        .fill_buf()
        .is_ok_and(|bytes| bytes.is_empty() || MAGIC.starts_with(bytes) || bytes.starts_with(MAGIC))
}

/// Opens y4m that comes out of `pipe`, which is called `path`.
///
/// # Errors
/// As [`Y4mSource::new`].
pub(crate) fn open_pipe(pipe: impl Read + Send + 'static, path: PathBuf) -> Result<Input> {
    let source = Y4mSource::new(pipe, &path)?;
    Ok(piped(source, Arc::from([path])))
}

/// Opens y4m in a file.
///
/// # Errors
/// As [`Y4mSource::new`], and when it cannot be opened.
pub(crate) fn open(path: PathBuf) -> Result<Input> {
    let file = detect::open(&path)?;
    let mut source = Y4mSource::new(file, &path)?;
    source.count_frames();
    let paths = Arc::from([path.clone()]);
    let info = source.info.clone();
    let warning = source.warning();
    // The first pass continues after the header, which has been read.
    let mut first = Some(source);
    Ok(Input::new(paths, info, move || {
        Ok(Box::new(match first.take() {
            Some(source) => source,
            None => Y4mSource::new(detect::open(&path)?, &path)?,
        }))
    })
    .with_warning(warning))
}

fn piped<R: Read + Send + 'static>(source: Y4mSource<R>, paths: Arc<[PathBuf]>) -> Input {
    let warning = source.warning();
    let (info, mut first) = (source.info.clone(), Some(source));
    Input::new(paths, info, move || match first.take() {
        Some(source) => Ok(Box::new(source)),
        None => Err(Error::usage("a pipe can be read only once")),
    })
    .once()
    .with_warning(warning)
}

impl Y4mSource<File> {
    /// Finds the number of frames from the length of the file.
    fn count_frames(&mut self) {
        let frame = self.header.samples.bytes(&self.header.layout) as u64 + "FRAME\n".len() as u64;
        let Ok(file) = self.input.get_ref().metadata() else { return };
        let bytes = file.len().saturating_sub(self.header.bytes);
        // Frame lines may have parameters, and the file may be truncated: then the number is unknown.
        if file.is_file() && bytes.is_multiple_of(frame) {
            let frames = bytes / frame;
            self.info.frames = Some(frames);
            let frames = i64::try_from(frames).ok().map(|n| Rational::new(n, 1));
            self.info.duration = frames.and_then(|n| Some(n * self.header.rate.recip()?));
        }
    }
}

impl<R: Read> Y4mSource<R> {
    /// Reads the header of `input`, which is called `path` in messages (`-` for standard input).
    ///
    /// # Errors
    /// [`Error::Input`] when it is not y4m, or has a pixel format that is not supported.
    pub fn new(input: R, path: &Path) -> Result<Self> {
        let mut input = BufReader::with_capacity(1 << 16, input);
        let fail = |what: String| Error::input(path, what);
        let nothing = input.fill_buf().is_ok_and(<[u8]>::is_empty);
        if nothing {
            return Err(fail("nothing came in; expected y4m video".into()));
        }
        let line = read_line(&mut input).map_err(|error| {
            fail(format!("the y4m header cannot be read: {error}; {CURE}")).caused_by(error)
        })?;
        let header = parse(&line).map_err(&fail)?;
        let size = square(header.layout.size, header.aspect);
        check_size(header.layout.size).map_err(|error| fail(error.to_string()))?;
        check_size(size).map_err(|error| fail(error.to_string()))?;
        let colour = Colorimetry { range: header.range.clone(), ..Colorimetry::default() };
        let info = StreamInfo {
            format: "y4m".into(),
            size,
            frames: None,
            rate: Some(header.rate),
            duration: None,
            alpha: header.layout.alpha,
            still: false,
            loops: Loops::Once,
            audio: None,
            live: false,
            colour: Some(colour),
        };
        Ok(Self {
            input,
            path: path.into(),
            info,
            header,
            planes: Vec::new(),
            raw: Vec::new(),
            buffers: Buffers::default(),
            count: 0,
            from: Rational::ZERO,
        })
    }

    /// The properties of the stream, from its header.
    pub fn info(&self) -> &StreamInfo {
        &self.info
    }

    /// What is said of frames that are left as they are.
    fn warning(&self) -> Option<String> {
        self.header.is_interlaced.then(|| {
            format!(
                "{}: is interlaced, and stays so: ffmpeg -vf bwdif deinterlaces it",
                self.path.display()
            )
        })
    }

    /// Reads the planes of the next frame; false at the end.
    fn read_planes(&mut self) -> Result<bool> {
        match self.input.fill_buf() {
            Ok([]) => return Ok(false),
            Ok(_) => {}
            Err(error) => return Err(self.failed(error)),
        }
        let line = read_line(&mut self.input).map_err(|error| self.failed(error))?;
        if line != "FRAME" && !line.starts_with("FRAME ") {
            let what = "a frame of a y4m stream begins with FRAME; this does not";
            return Err(Error::input_frame(&self.path, self.count, what).corrupt());
        }
        self.fill_planes().map_err(|error| self.failed(error))?;
        Ok(true)
    }

    fn failed(&self, error: io::Error) -> Error {
        let what = match error.kind() {
            io::ErrorKind::UnexpectedEof => format!("the stream is cut short: {error}"),
            _ => format!("the stream cannot be read: {error}"),
        };
        Error::input_frame(&self.path, self.count, what).caused_by(error)
    }

    /// Reads the planes of a frame. New memory is allocated only as data arrives, since the header may be wrong.
    fn fill_planes(&mut self) -> io::Result<()> {
        let Header { layout, samples, .. } = self.header;
        let full = self.header.range.as_deref() == Some("pc");
        if samples.is_plain() {
            return self.fill(layout.bytes());
        }
        std::mem::swap(&mut self.planes, &mut self.raw);
        let filled = self.fill(samples.bytes(&layout));
        std::mem::swap(&mut self.planes, &mut self.raw);
        filled?;
        samples.convert(&layout, full, &self.raw, &mut self.planes);
        Ok(())
    }

    /// Reads `bytes` bytes.
    fn fill(&mut self, bytes: usize) -> io::Result<()> {
        let known = self.planes.capacity().min(bytes);
        self.planes.resize(known, 0);
        self.input.read_exact(&mut self.planes)?;
        let missing = (bytes - known) as u64;
        let came = (&mut self.input).take(missing).read_to_end(&mut self.planes)?;
        if (came as u64) < missing { Err(io::ErrorKind::UnexpectedEof.into()) } else { Ok(()) }
    }
}

impl<R: Read> Source for Y4mSource<R> {
    fn skip_to(&mut self, start: Rational) {
        self.from = start;
    }

    fn recycle(&mut self, frame: Frame) {
        self.buffers = frame.into_buffers();
    }

    fn next(&mut self) -> Result<Option<Decoded>> {
        let length = self.header.rate.recip();
        let start = loop {
            if !self.read_planes()? {
                return Ok(None);
            }
            let number = Rational::new(i64::try_from(self.count).unwrap_or(i64::MAX), 1);
            let start = number * length.unwrap_or(Rational::ZERO);
            if start >= self.from {
                break start;
            }
            self.count += 1;
        };
        let layout = self.header.layout;
        let coding =
            Coding::of(self.info.colour.as_ref().unwrap_or(&Colorimetry::default()), layout.size);
        let Buffers { mut pixels, planes } = std::mem::take(&mut self.buffers);
        let mut frame = if layout.is_squared() {
            let data = std::mem::replace(&mut self.planes, planes);
            Frame::planar(Planes { form: Form { layout, coding }, data }, pixels)?
        } else {
            to_rgba(&layout, coding, &self.planes, &mut pixels);
            Frame::known(layout.size, pixels, !layout.alpha)?
        };
        if self.info.size != layout.size {
            let Size { width, height } = self.info.size;
            let image =
                imageops::resize(&frame.into_image(), width, height, FilterType::CatmullRom);
            frame = Frame::from_image(image)?;
        }
        let span = Span { start, length };
        self.count += 1;
        Ok(Some(Decoded::new(frame, span)))
    }
}

/// A line of text without its line break.
fn read_line(input: &mut impl BufRead) -> io::Result<String> {
    let mut line = Vec::new();
    input.take(MAX_LINE).read_until(b'\n', &mut line)?;
    if line.pop() != Some(b'\n') {
        return Err(if line.len() as u64 + 1 >= MAX_LINE {
            io::Error::new(io::ErrorKind::InvalidData, "a line has no end")
        } else {
            io::Error::new(io::ErrorKind::UnexpectedEof, "it ends in a line")
        });
    }
    String::from_utf8(line)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "a line is not text"))
}

/// The size with square pixels: the height stays.
fn square(size: Size, aspect: Rational) -> Size {
    let width = (f64::from(size.width) * aspect.to_f64()).round().clamp(1.0, f64::from(u32::MAX));
    Size::new(width as u32, size.height)
}

fn parse(line: &str) -> Result<Header, String> {
    let mut fields = line.split(' ');
    if fields.next().map(str::as_bytes) != Some(MAGIC) {
        return Err(format!("this is no y4m stream: it does not begin with YUV4MPEG2; {CURE}"));
    }
    let (mut width, mut height, mut space) = (0, 0, "420jpeg");
    let (mut rate, mut aspect, mut range) = (DEFAULT_RATE, Rational::new(1, 1), None);
    let mut is_interlaced = false;
    for field in fields.filter(|field| !field.is_empty()) {
        let Some((tag, value)) = field.split_at_checked(1) else { continue };
        let wrong = || format!("the y4m header has an impossible '{field}'");
        match tag {
            "W" => width = value.parse().map_err(|_| wrong())?,
            "H" => height = value.parse().map_err(|_| wrong())?,
            "F" => rate = fraction(value).ok_or_else(wrong)?.unwrap_or(DEFAULT_RATE),
            "A" => aspect = fraction(value).ok_or_else(wrong)?.unwrap_or(aspect),
            "C" => space = value,
            "X" => match value.strip_prefix("COLORRANGE=") {
                Some("FULL") => range = Some("pc".to_string()),
                Some("LIMITED") => range = Some("tv".to_string()),
                _ => {}
            },
            "I" => is_interlaced = matches!(value, "t" | "b" | "m"),
            // Other fields are comments.
            _ => {}
        }
    }
    let known = y4m_samples::parse(space).ok_or_else(|| {
        format!(
            "y4m in '{space}' is not read, only 420, 411, 422, 444, 444alpha or mono; with ffmpeg: -pix_fmt yuv420p"
        )
    });
    let (samples, sampling, siting, alpha) = known?;
    let layout = Layout { size: Size::new(width, height), sampling, siting, alpha };
    let bytes = line.len() as u64 + 1;
    Ok(Header { layout, samples, rate, aspect, range, is_interlaced, bytes })
}

/// A fraction such as `30000:1001`; inner `None` for `0:0`, which means unknown. 32-bit parts keep times exact.
fn fraction(text: &str) -> Option<Option<Rational>> {
    let (num, den) = text.split_once(':')?;
    let (num, den): (u32, u32) = (num.parse().ok()?, den.parse().ok()?);
    if num == 0 || den == 0 {
        return Some(None);
    }
    Some(Some(Rational::new(num.into(), den.into())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(bytes: &[u8]) -> Result<Y4mSource<&[u8]>> {
        Y4mSource::new(bytes, Path::new("-"))
    }

    #[test]
    fn a_header_has_size_rate_and_range() {
        let source = open(b"YUV4MPEG2 W6 H4 F30000:1001 Ip A4:3 C420mpeg2 XCOLORRANGE=FULL\n")
            .expect("fine");
        let info = source.info();
        assert_eq!((info.size, info.rate), (Size::new(8, 4), Some(Rational::new(30000, 1001))));
        assert_eq!(info.colour.as_ref().and_then(|c| c.range.as_deref()), Some("pc"));
        let bare = open(b"YUV4MPEG2 W6 H4 F0:0 A0:0\n").expect("fine");
        assert_eq!((bare.info().size, bare.info().rate), (Size::new(6, 4), Some(DEFAULT_RATE)));
    }

    #[test]
    fn wrong_headers_say_what_is_wrong() {
        for (header, part) in [
            ("RIFF\n", "YUV4MPEG2"),
            ("YUV4MPEG2 W4 H4 C410\n", "410"),
            ("YUV4MPEG2 W4 Hx\n", "Hx"),
            ("YUV4MPEG2 W4\n", "no pixels"),
            ("YUV4MPEG2 W99999 H4\n", "larger"),
            ("YUV4MPEG2 W16384 H4 A1000:1\n", "larger"),
            ("YUV4MPEG2 W4 H4", "header"),
        ] {
            let error = open(header.as_bytes()).err().expect(header).to_string();
            assert!(error.contains(part), "{header}: {error}");
        }
    }

    #[test]
    fn frames_come_in_time_and_a_short_one_is_an_error() {
        let mut bytes = b"YUV4MPEG2 W2 H2 F24:1 Cmono XCOLORRANGE=FULL\n".to_vec();
        bytes.extend(b"FRAME\n\x00\x40\x80\xFFFRAME Ixyz\n\x01\x02\x03\x04FRAME\n\x00");
        let mut source = open(&bytes).expect("a header");
        let first = source.next().expect("whole").expect("there is one");
        assert_eq!(first.frame.at(1, 1), [255; 4]);
        let second = source.next().expect("whole").expect("there is one");
        assert_eq!(second.span.start, Rational::new(1, 24));
        let error = source.next().expect_err("cut short").to_string();
        assert!(error.contains("frame 2") && error.contains("cut short"), "{error}");
    }

    #[test]
    fn something_else_between_frames_is_an_error() {
        let mut source = open(b"YUV4MPEG2 W1 H1 Cmono\nFRAME\nxHello\n").expect("a header");
        assert!(source.next().expect("whole").is_some());
        assert!(source.next().expect_err("no frame").to_string().contains("FRAME"));
    }

    #[test]
    fn a_recycled_frame_is_filled_again() {
        let film = [b"YUV4MPEG2 W2 H2 F25:1 Cmono\n" as &[u8], b"FRAME\n\x10\x20\x30\x40"].concat();
        let film = [&film[..], b"FRAME\n\xf0\xf1\xf2\xf3"].concat();
        let next = |source: &mut Y4mSource<&[u8]>| source.next().expect("fine").expect("a frame");
        let mut fresh = open(&film).expect("fine");
        let (_, second) = (next(&mut fresh), next(&mut fresh));

        let mut source = open(&film).expect("fine");
        let first = next(&mut source);
        let memory = first.frame.pixels().as_ptr();
        source.recycle(first.frame);
        let again = next(&mut source);
        assert_eq!(again.frame, second.frame);
        assert_eq!(again.frame.pixels().as_ptr(), memory);
    }
}
