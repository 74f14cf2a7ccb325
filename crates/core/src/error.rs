//! The errors of the engine.

use crate::geom::Size;

/// Result with the engine's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of the engine. No variant concerns a file: those are the caller's.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An option is out of its range.
    #[error("{name} is {value}; it can be {range}")]
    OutOfRange {
        /// The option's name, as on the command line but without dashes in front.
        name: String,
        /// Its value.
        value: String,
        /// Its range, in words.
        range: String,
    },
    /// Options that cannot be parsed, or exclude each other.
    #[error("{0}")]
    Options(String),
    /// A frame of this size is not possible, or not with these pixels.
    #[error("a frame of {size} {what}")]
    FrameSize {
        /// Width and height.
        size: Size,
        /// What is wrong with it, in words.
        what: String,
    },
    /// Two pictures that must have the same size differ in it.
    #[error("a picture of {0} cannot be compared with one of {1}")]
    SizeMismatch(Size, Size),
    /// A picture is too small for the measure.
    #[error("a picture of {size} is smaller than the {window}x{window} window of SSIM")]
    TooSmall {
        /// Width and height of the picture.
        size: Size,
        /// Side of the window in pixels.
        window: usize,
    },
    /// No number of points reaches the requested likeness.
    #[error(
        "{target} cannot be reached: {most} points, one for {pixels_a_point} pixels, come to {likeness}; \
         lower --error"
    )]
    Unreachable {
        /// The requested likeness.
        target: String,
        /// The largest number of points that was tried.
        most: usize,
        /// Pixels for each of these points.
        pixels_a_point: usize,
        /// The likeness that they reach.
        likeness: String,
    },
    /// Two seeds lie in the same place, so that they have no triangulation.
    #[error("two seeds lie in the same place")]
    DuplicateSeeds,
}

impl Error {
    /// Whether the request is wrong for any picture.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::OutOfRange { .. } | Self::Options(_))
    }

    pub(crate) fn options(what: impl Into<String>) -> Self {
        Self::Options(what.into())
    }

    pub(crate) fn out_of_range(
        name: &str,
        value: impl std::fmt::Display,
        range: impl std::fmt::Display,
    ) -> Self {
        Self::OutOfRange { name: name.into(), value: value.to_string(), range: range.to_string() }
    }
}
