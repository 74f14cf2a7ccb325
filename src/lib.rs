//! polyreel turns pictures, GIFs and video into low-poly art, frame by frame.
//!
//! A [`frame::Frame`] goes through three levels: [`feature`] finds the pixels that matter, [`sample`]
//! thins them on a hexagonal grid to seeds, which [`triangulate`] makes a mesh of, and [`refine`] lets
//! the mesh learn where the edges are; [`rasterise`] fills each triangle with the mean colour of its
//! pixels. [`render::Renderer`] is that chain on one thread, [`pipeline::run`] on a thread a stage,
//! from a [`source`] to a [`sink`].
//!
//! ```text
//! decode -> features -> sample, triangulate, refine -> rasterise -> encode
//! ```
//!
//! The mesh lives on from frame to frame, carried along with the picture:
//!
//! ```
//! use polyreel::{frame::Frame, geom::Size, options::{Options, Points}, render::Renderer};
//!
//! # fn main() -> polyreel::error::Result<()> {
//! let options = Options { points: Points::Count(40), ..Options::default() };
//! let mut renderer = Renderer::new(&options)?;
//! let frame = Frame::filled(Size::new(64, 48), [90, 120, 60, 255])?;
//! let first = renderer.render(&frame)?;
//! let second = renderer.render(&frame)?;
//! assert_eq!(first.painting.frame, second.painting.frame);
//! assert_eq!(second.life.kept, 40);
//! # Ok(())
//! # }
//! ```
//!
//! Layers, lowest first; a module uses only what stands above it: [`geom`], [`stage`], [`error`],
//! [`colour`], [`frame`], [`chance`]; [`options`], [`mesh`], [`hex`], [`echo`], [`scan`], [`draw`],
//! [`plane`], [`flow`], [`feature`]; [`sample`], [`triangulate`], [`refine`], [`rasterise`], [`governor`];
//! [`metric`], [`render`], [`ffmpeg`], [`source`], [`sink`], [`evaluate`]; [`pipeline`].

pub use polyreel_core::{
    chance, colour, draw, echo, feature, flow, frame, geom, governor, hex, mesh, metric, options,
    plane, rasterise, refine, render, sample, scan, stage, triangulate,
};

pub mod error;
pub mod ffmpeg;
pub mod pattern;
pub mod pipeline;
pub mod preset;
pub mod sink;
pub mod source;
pub mod stream;
pub(crate) use polyreel_core::vector;

/// The README's example, compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
