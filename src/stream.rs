//! What is known of a stream before its frames are read, and when its frames are shown.

use crate::colour::Colorimetry;
use crate::frame::Rational;
use crate::geom::Size;

/// How often an animation plays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub enum Loops {
    /// Once (also for what is no animation).
    #[default]
    Once,
    /// This many times in all, at least twice.
    Times(u32),
    /// Without end.
    Forever,
}

/// What is known of a stream before its frames are read.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct StreamInfo {
    /// Format as recognised by content: `png`, `gif`, `apng`, `webp`, `y4m`, `h264 in mov` ...
    pub format: String,
    /// Size of every frame, after rotation and pixel aspect are applied.
    pub size: Size,
    /// Number of frames, where the container tells it or counting is cheap.
    pub frames: Option<u64>,
    /// Frames per second, where it is constant or the container tells a nominal one.
    pub rate: Option<Rational>,
    /// Length in seconds.
    pub duration: Option<Rational>,
    /// Whether pixels may be transparent.
    pub alpha: bool,
    /// Whether this is one picture, not a sequence of frames.
    pub still: bool,
    /// How often it plays.
    pub loops: Loops,
    /// The sound, in words (`aac 44100 Hz 2 ch`).
    pub audio: Option<String>,
    /// Whether frames arrive by their own clock (camera, stream) and may be dropped at admission.
    pub live: bool,
    /// Colour tags of a video.
    pub colour: Option<Colorimetry>,
}

impl StreamInfo {
    /// A film of `size` of which nothing else is known.
    pub fn of(size: Size) -> Self {
        Self {
            format: String::new(),
            size,
            frames: None,
            rate: None,
            duration: None,
            alpha: false,
            still: false,
            loops: Loops::Once,
            audio: None,
            live: false,
            colour: None,
        }
    }
}

/// When a frame is shown, in seconds from the start of the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// First moment.
    pub start: Rational,
    /// How long, where it is known.
    pub length: Option<Rational>,
}

/// Whether `tags` are those of HDR: of PQ or HLG.
pub fn is_hdr(tags: &Colorimetry) -> bool {
    matches!(tags.transfer.as_deref(), Some("smpte2084" | "arib-std-b67"))
}
