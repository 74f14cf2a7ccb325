//! What is decided about a video before its first frame: sizes, units of time, pixel formats; and frames on their way to
//! ffmpeg.

use std::ffi::OsString;
use std::io;
use std::process::ChildStdin;

use crate::colour::{Coding, Form, Layout, Sampling, Siting};
use crate::error::{Error, Result};
use crate::ffmpeg::Pipe;
use crate::ffmpeg::command::arguments;
use crate::ffmpeg::nut::NutWriter;
use crate::frame::{Buffers, Colorimetry, Rational, Rgba, check_size};
use crate::geom::Size;
use crate::sink::codec::{AlphaPixels, Encoder};
use crate::sink::container::Container;
use crate::sink::planes::fill_planes;
use crate::sink::spec::{VideoOptions, VideoSpec};
use crate::sink::tags::{tag_arguments, tags};
use crate::sink::{Needs, Picture};
use crate::stream::is_hdr;

/// The pixels that are sent to ffmpeg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Wire {
    /// Planes of luma and chroma, and perhaps alpha.
    Planes(Form),
    /// Red, green, blue and alpha.
    Rgba,
}

impl Wire {
    /// NUT's name of it.
    fn fourcc(self) -> [u8; 4] {
        let Self::Planes(Form { layout, .. }) = self else { return *b"RGBA" };
        match (layout.alpha, layout.sampling) {
            (false, _) => *b"I420",
            (true, Sampling::Yuv444) => [b'Y', b'4', 0, 8],
            (true, _) => [b'Y', b'4', 11, 8],
        }
    }

    fn alpha(self) -> bool {
        match self {
            Self::Planes(form) => form.layout.alpha,
            Self::Rgba => true,
        }
    }
}

/// How a video is encoded.
#[derive(Clone, Debug)]
pub(crate) struct Encoding {
    pub(crate) container: Container,
    pub(crate) encoder: Encoder,
    /// The size of encoded pictures.
    pub(crate) size: Size,
    pub(crate) wire: Wire,
    /// The encoder's own format.
    format: &'static str,
    alpha: Option<AlphaPixels>,
    pub(crate) tags: Colorimetry,
    pub(crate) time_base: Rational,
    rate: Option<Rational>,
}

/// What keeps transparency, for messages.
const KEEP_ALPHA: &str =
    ".webm, .mov with --codec prores or png, .mkv with --codec ffv1, .apng, .webp, .gif";

impl Encoding {
    /// How pictures of `spec` are encoded for `container`. Adds warnings about what is changed or lost.
    ///
    /// # Errors
    /// When the size is out of range, or the codec does not suit HDR that is to stay.
    pub(crate) fn of(
        container: Container,
        spec: &VideoSpec,
        options: &VideoOptions,
        warnings: &mut Vec<String>,
    ) -> Result<Self> {
        check_size(spec.size)?;
        let hdr = options.hdr && spec.colour.as_ref().is_some_and(is_hdr);
        let unnamed = if container == Container::WebM { "av1" } else { "h265" };
        let codec = options.codec.as_deref().or(hdr.then_some(unnamed));
        let encoder = Encoder::of(codec, &container);
        if hdr && !encoder.takes_deep() {
            return Err(Error::usage(format!(
                "--hdr needs 10 bits, which {} has not: --codec h265 or av1",
                encoder.title()
            )));
        }
        let alpha = encoder.alpha(&container).filter(|_| spec.alpha);
        if spec.alpha && alpha.is_none() {
            warnings.push(format!(
                "transparency is lost: {} in {} has none, and the background shows; kept by {KEEP_ALPHA}",
                encoder.title(),
                container.muxer()
            ));
        }
        let whole = alpha.is_some_and(|alpha| alpha.sampling != Some(Sampling::Yuv420));
        let size = if whole || encoder.takes_odd() { spec.size } else { even(spec.size) };
        if size != spec.size {
            warnings.push(format!(
                "{} cannot hold {}: the last column or row is repeated, to {size}; WebM keeps odd sizes",
                encoder.title(),
                spec.size
            ));
        }
        let mut tags = tags(spec.colour.as_ref());
        let wire = match alpha {
            Some(AlphaPixels { sampling: Some(sampling), .. }) => {
                let layout = Layout { size, sampling, siting: Siting::Left, alpha: true };
                Wire::Planes(Form { layout, coding: Coding::of(&tags, spec.size) })
            }
            Some(AlphaPixels { sampling: None, .. }) => {
                // Of RGB there is no matrix, and its range is full.
                (tags.matrix, tags.range) = (None, None);
                Wire::Rgba
            }
            None => {
                let layout = Layout::of_video(size);
                Wire::Planes(Form { layout, coding: Coding::of(&tags, spec.size) })
            }
        };
        let limit = encoder.most_units().or(container.counts_frames().then_some(65535));
        let time_base = match (&container, limit) {
            (Container::WebP, _) => Rational::new(1, 1000),
            (_, Some(limit)) => coarse_time_base(spec.rate, limit),
            (_, None) => time_base(spec.rate),
        };
        let opaque = if hdr { "yuv420p10le" } else { "yuv420p" };
        let format = alpha.map_or(opaque, |alpha| alpha.format);
        let rate = spec.rate;
        Ok(Self { container, encoder, size, wire, format, alpha, tags, time_base, rate })
    }

    /// The options that read our frames.
    pub(crate) fn reading(&self) -> Vec<OsString> {
        let mut args =
            arguments([&"-nostdin", &"-hide_banner", &"-loglevel", &"level+warning", &"-y"]);
        // The headers are complete: ffmpeg must not buffer frames to analyse them.
        args.extend(arguments([&"-probesize", &"32", &"-analyzeduration", &"0"]));
        args.extend(arguments([&"-fpsprobesize", &"0", &"-f", &"nut"]));
        // The input is tagged as well, so that ffmpeg converts nothing.
        args.extend(tag_arguments(&self.tags));
        args.extend(arguments([&"-i", &"pipe:0"]));
        args
    }

    /// The options that encode frames and keep their times as they are.
    ///
    /// # Errors
    /// As [`Encoder::options`].
    pub(crate) fn writing(&self, options: &VideoOptions) -> Result<Vec<OsString>> {
        let units = format!("{}:{}", self.time_base.num, self.time_base.den);
        let mut args = arguments([&"-map", &"0:v:0", &"-pix_fmt", &self.format]);
        args.extend(arguments([&"-fps_mode", &"passthrough", &"-enc_time_base:v", &units]));
        args.extend(self.encoder.tag(&self.container));
        args.extend(self.encoder.options(options.crf, options.encoder_preset.as_deref())?);
        args.extend(self.alpha.iter().flat_map(|alpha| alpha.options.iter().map(OsString::from)));
        if self.container.is_in_order() {
            args.extend(arguments([&"-bf", &"0"]));
        }
        args.extend(tag_arguments(&self.tags));
        Ok(args)
    }
}

/// Frames on their way to ffmpeg.
pub(crate) struct Feed {
    /// `None` once it is closed.
    writer: Option<NutWriter<Pipe<ChildStdin>>>,
    wire: Wire,
    background: Option<Rgba>,
    time_base: Rational,
    planes: Vec<u8>,
    last_pts: Option<u64>,
}

impl Feed {
    /// Begins a stream to `stdin`. What is transparent shows `background` if there is no alpha.
    pub(crate) fn begin(stdin: Pipe<ChildStdin>, encoding: &Encoding, background: Rgba) -> Self {
        let Encoding { wire, size, time_base, rate, .. } = *encoding;
        // A write error is reported at the first frame, with ffmpeg's message.
        let writer = NutWriter::new(stdin, size, wire.fourcc(), time_base, rate).ok();
        let background = (!wire.alpha()).then_some(background);
        Self { writer, wire, background, time_base, planes: Vec::new(), last_pts: None }
    }

    /// What pictures of `size` should be.
    pub(crate) fn needs(&self, size: Size) -> Needs {
        let form = match self.wire {
            Wire::Planes(form) => Some(form),
            Wire::Rgba => None,
        };
        let fits = |form: &Form| form.layout.is_squared() && form.layout.size == size;
        Needs { form: form.filter(fits), ..Needs::default() }
    }

    /// The time of a picture in units of the time base: the nearest, but after the one before.
    fn pts(&self, start: Rational) -> u64 {
        let (num, den) = (i128::from(start.num), i128::from(start.den));
        let (unit, units) = (i128::from(self.time_base.num), i128::from(self.time_base.den));
        let nearest = (2 * num * units + den * unit).div_euclid(2 * den * unit);
        let nearest = u64::try_from(nearest.max(0)).unwrap_or(u64::MAX >> 1);
        self.last_pts.map_or(nearest, |last| nearest.max(last + 1))
    }

    /// Sends `picture`; its time, and the buffers that are free.
    ///
    /// # Errors
    /// When ffmpeg takes no more.
    pub(crate) fn write(&mut self, picture: Picture) -> io::Result<(u64, Buffers)> {
        let pts = self.pts(picture.span.start);
        let Some(writer) = &mut self.writer else { return Err(io::ErrorKind::BrokenPipe.into()) };
        let buffers = match &self.wire {
            Wire::Planes(form) => {
                let buffers = fill_planes(&mut self.planes, picture.frame, form, self.background);
                writer.write(pts, &self.planes)?;
                buffers
            }
            Wire::Rgba => {
                let pixels = picture.frame.into_pixels();
                writer.write(pts, pixels.as_flattened())?;
                Buffers { pixels, ..Buffers::default() }
            }
        };
        self.last_pts = Some(pts);
        Ok((pts, buffers))
    }

    /// Ends the stream.
    pub(crate) fn close(&mut self) {
        self.writer = None;
    }
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

/// Both sides rounded up to even.
fn even(size: Size) -> Size {
    Size::new(size.width.next_multiple_of(2), size.height.next_multiple_of(2))
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
