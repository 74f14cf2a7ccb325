//! polyreel turns pictures, GIFs and video into low-poly art, frame by frame.
//!
//! [`run`] takes frames from a [`Source`] to a [`Sink`], each stage of the work on a thread of its own:
//!
//! ```text
//! decode -> features -> mesh (sample, triangulate, refine) -> rasterise -> encode
//! ```
//!
//! [`open`] makes a source of files, [`create`] a sink of a file's name. A [`Renderer`] is the same chain
//! without files, on the caller's thread:
//!
//! ```
//! use polyreel::{Frame, Options, Points, Renderer, Size};
//!
//! # fn main() -> polyreel::Result<()> {
//! let mut options = Options::default();
//! options.points = Points::Count(40);
//! let mut renderer = Renderer::new(&options)?;
//! let frame = Frame::filled(Size::new(64, 48), [90, 120, 60, 255])?;
//! let first = renderer.render(&frame)?;
//! let second = renderer.render(&frame)?;
//! assert_eq!(first.picture, second.picture);
//! assert_eq!(second.life.kept, 40);
//! # Ok(())
//! # }
//! ```
//!
//! The engine alone is the crate `polyreel-core`, whose names are all here.
//!
//! # Features
//!
//! - `cli` (default): the program.
//! - `preview` (default): its live window.
//! - `unstable`: the modules behind these names, without any promise.
//!
//! # Layers
//!
//! Modules, lowest first; each uses only those before it, and the engine (checked by a test):
//! `error`, `memory`, `stream`, `pattern`, `ffmpeg`, `preset`, `source`, `sink`, `pipeline`, `film`, `program`

// Without `unstable` parts that only the program uses have no user here.
#![cfg_attr(not(feature = "unstable"), allow(dead_code, unreachable_pub, unused_imports))]

// The program, which calls the library by its name as others do.
#[cfg(feature = "cli")]
extern crate self as polyreel;

mod memory;
pub mod preset;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod program;

/// The modules of the library and of the engine.
#[path = ""]
mod modules {
    pub use polyreel_core::unstable::*;

    pub mod error;
    pub mod ffmpeg;
    #[cfg(feature = "cli")]
    pub mod film;
    pub mod pattern;
    pub mod pipeline;
    pub mod sink;
    pub mod source;
    pub mod stream;
}

#[cfg(not(feature = "unstable"))]
use modules::*;
#[cfg(feature = "unstable")]
#[doc(hidden)]
pub use modules::*;

pub use error::{Cause, Error, Result};
#[cfg(feature = "ffmpeg")]
pub use ffmpeg::FfmpegError;
pub use ffmpeg::{Ffmpeg, Processes};
pub use pipeline::{
    BudgetReport, Controls, DetailPolicy, Ending, FrameReport, Observer, Settings, StageTimes,
    Stop, Summary, run,
};
pub use polyreel_core::unstable::frame::{Buffers, Colorimetry, Rational};
pub use polyreel_core::unstable::stage::{Percentiles, Stage};
pub use polyreel_core::{
    CellPercentiles, Colour, Edges, Fill, Frame, FrontEnd, Life, MAX_SIDE, Mesh, Method, Options,
    PRESETS, Point, Points, Preset, Quality, Rendered, Renderer, Rgba, SUBPIXEL, Size, Target,
    Thresholds,
};
pub use sink::Sound;
pub use sink::ffmpeg::VideoOptions;
pub use sink::{Needs, Origin, Picture, Sink, SinkOptions, Unfinished, create};
pub use source::{Decoded, Input, Source, SourceOptions, open};
pub use stream::{Loops, Span, StreamInfo};

/// The README's example, compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
