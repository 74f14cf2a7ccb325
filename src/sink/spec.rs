//! The content of a video, and its encoding.

use crate::ffmpeg::Ffmpeg;
use crate::frame::{Colorimetry, Rational};
use crate::geom::Size;
use crate::source::Sound;
use crate::stream::StreamInfo;

/// How to encode.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct VideoOptions {
    /// A codec (`h264`, `h265`, `vp8`, `vp9`, `av1`, `prores`) or ffmpeg's name of an encoder.
    /// Default `None`: H.264, in WebM VP9.
    pub codec: Option<String>,
    /// Constant quality on the encoder's own scale; smaller is better. Default `None`: 18 for H.264, similar ones for
    /// others.
    pub crf: Option<u32>,
    /// Effort, by x264's names: `ultrafast` to `placebo`. Default `None`: the encoder's own.
    pub encoder_preset: Option<String>,
    /// Whether the sound of the source is kept. Default true.
    pub audio: bool,
    /// Whether titles, dates, chapters, languages and timecodes of the source are kept. Default true.
    pub metadata: bool,
    /// Whether HDR stays HDR, of 10 bits, as HEVC unless another codec is named. Default false.
    pub hdr: bool,
    /// Further options of ffmpeg, in front of the output file. Default none.
    pub ffmpeg_args: Vec<String>,
    /// The ffmpeg to use. Default: the one on the search path.
    pub ffmpeg: Ffmpeg,
    /// Whether the encoder runs at a lower priority than this process, by 10 as with `nice`. Useful if earlier stages
    /// take longer than encoding, as with refinement; otherwise it only loses time to other programs. Default false.
    pub gives_way: bool,
}

impl Default for VideoOptions {
    fn default() -> Self {
        Self {
            codec: None,
            crf: None,
            encoder_preset: None,
            audio: true,
            metadata: true,
            hdr: false,
            ffmpeg_args: Vec::new(),
            ffmpeg: Ffmpeg::default(),
            gives_way: false,
        }
    }
}

/// The content of a video.
#[derive(Clone, Debug, PartialEq)]
pub struct VideoSpec {
    /// Size of all pictures.
    pub size: Size,
    /// Nominal rate, if there is one.
    pub rate: Option<Rational>,
    /// Expected length in seconds, to know a run that was stopped early.
    pub duration: Option<Rational>,
    /// Colour tags of a video source, which are kept; without tags the size decides
    /// ([`Coding::of`](crate::colour::Coding::of)). `None` for sources in RGB, which are tagged BT.709.
    pub colour: Option<Colorimetry>,
    /// Whether pixels may be transparent, which is kept where the container and the encoder can.
    pub alpha: bool,
    /// The sound to add.
    pub sound: Option<Sound>,
}

impl VideoSpec {
    /// Pictures of `size` made from the stream `info`, without sound.
    pub fn of(info: &StreamInfo, size: Size) -> Self {
        let (rate, duration, colour) = (info.rate, info.duration, info.colour.clone());
        Self { size, rate, duration, colour, alpha: info.alpha, sound: None }
    }
}
