//! The engine of polyreel: turns one frame after another into low-poly art.
//!
//! A [`Renderer`] takes [`Frame`]s and gives [`Rendered`] pictures, each with the [`Mesh`] behind it.
//! [`Options`] say how. Nothing here reads a file, starts a process, asks a clock or looks at the environment;
//! files, video and threads between stages are in the crate `polyreel`.
//!
//! ```
//! use polyreel_core::{Frame, Options, Points, Renderer, Size};
//!
//! # fn main() -> polyreel_core::Result<()> {
//! let size = Size::new(64, 48);
//! let gradient = (0..size.pixels()).map(|i| [(i % 64 * 4) as u8, (i / 64 * 5) as u8, 90, 255]);
//! let frame = Frame::new(size, gradient.collect())?;
//!
//! let mut options = Options::default();
//! options.points = Points::Count(60);
//! let mut renderer = Renderer::new(&options)?;
//! let rendered = renderer.render(&frame)?;
//! assert_eq!(rendered.picture.size(), size);
//! assert_eq!(rendered.mesh.seeds().len(), 60);
//!
//! // The mesh is carried from frame to frame: where nothing moves, all seeds stay.
//! let again = renderer.render(&frame)?;
//! assert_eq!(again.mesh.ids, rendered.mesh.ids);
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//!
//! - `parallel` (default): all processors work on a frame. Without it the same bytes come from one thread.
//! - `faces`: [`Focus::Faces`], by the crate `polyreel-faces`.
//! - `image`: frames from and to images of the `image` crate.
//! - `serde`: options and reports as data.
//! - `unstable`: the modules behind these types, without any promise. The crate `polyreel` uses it.
//! - `literals`: [`Options`] is not `non_exhaustive`. Only for tests.
//!
//! # Layers
//!
//! Modules, lowest first; each uses only those before it (checked by a test of the crate `polyreel`):
//!
//! 1. `geom`, `stage`, `error`, `simd`, `parallel`, `colour`, `frame`, `chance`
//! 2. `plane`, `options`, `mesh`, `hex`, `residual`, `scan`, `moments`, `draw`, `flow`, `feature`, `focus`
//! 3. `triangulate`, `voronoi`, `refine`, `sample`, `rasterise`, `governor`, `metric`, `chain`, `render`, `svg`, `mesh_stream`,
//!    `model`, `usd`

// Without `unstable` parts that only other crates use, such as the governor, have no user here.
#![cfg_attr(not(feature = "unstable"), allow(dead_code, unreachable_pub, unused_imports))]

mod chain;
mod chance;
mod colour;
mod draw;
mod error;
mod feature;
mod flow;
mod focus;
mod frame;
mod geom;
mod governor;
mod hex;
mod mesh;
pub mod mesh_stream;
mod metric;
pub mod model;
mod moments;
mod options;
mod parallel;
mod plane;
mod rasterise;
mod refine;
mod render;
mod residual;
mod sample;
mod scan;
mod simd;
mod stage;
pub mod svg;
mod triangulate;
mod usd;
mod voronoi;

pub use error::{Error, Result};
pub use frame::{Fill, Frame, Rgba};
pub use geom::{MAX_SIDE, Point, SUBPIXEL, Size};
pub use mesh::Mesh;
pub use options::{
    CellPercentiles, Colour, Duotone, Edges, FillMode, Focus, FocusMask, FrontEnd, Length, Method,
    Options, PRESETS, Palette, Points, Prefilter, Preset, Quality, STUDIES, Shape, Spot, Target,
    Thresholds,
};
pub use render::{Rendered, Renderer};
pub use sample::Life;

/// The modules of the engine, for the crate `polyreel`, its benches and its tests. Anything here may change
/// in any release.
#[cfg(feature = "unstable")]
#[doc(hidden)]
pub mod unstable {
    macro_rules! modules {
        ($($name:ident)*) => {
            $(pub mod $name { pub use crate::$name::*; })*
        };
    }
    modules! {
        chain chance colour draw error feature flow frame geom governor hex mesh mesh_stream metric model options plane
        rasterise refine render residual sample scan simd stage svg triangulate usd
    }
}

/// The README's example, compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
