//! The properties of a stream that are known before its frames are read, and the times of frames.

use crate::colour::Colorimetry;
use crate::frame::Rational;
use crate::geom::Size;

/// How often an animation plays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Loops {
    /// Once; also for inputs that are not animations.
    #[default]
    Once,
    /// This number of times, at least 2.
    Times(u32),
    /// For ever.
    Forever,
}

impl Loops {
    /// The number of times, as most formats have it: 0 for ever.
    pub(crate) fn plays(self) -> u32 {
        match self {
            Self::Once => 1,
            Self::Times(n) => n,
            Self::Forever => 0,
        }
    }
}

/// The properties of a stream that are known before its frames are read.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub struct StreamInfo {
    /// Format as recognised by content: `png`, `gif`, `apng`, `webp`, `y4m`, `h264 in mov` ...
    pub format: String,
    /// Size of every frame, after rotation and pixel aspect are applied.
    pub size: Size,
    /// Number of frames, if the container has it or counting is fast.
    pub frames: Option<u64>,
    /// Frames per second, if the rate is constant or the container has a nominal one.
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
    /// A video of `size`, all other properties unknown.
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
    /// Start time in seconds.
    pub start: Rational,
    /// Duration in seconds, if known.
    pub length: Option<Rational>,
}

/// Whether `tags` mean HDR: PQ or HLG.
pub fn is_hdr(tags: &Colorimetry) -> bool {
    matches!(tags.transfer.as_deref(), Some("smpte2084" | "arib-std-b67"))
}
