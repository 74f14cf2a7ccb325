//! The engine of polyreel: turns one frame after another into low-poly art.
//!
//! No module reads a file, starts a process, asks a clock or looks at the environment.

pub mod chance;
pub mod colour;
pub mod draw;
pub mod echo;
pub mod error;
pub mod feature;
pub mod flow;
pub mod frame;
pub mod geom;
pub mod governor;
pub mod hex;
pub mod mesh;
pub mod metric;
pub mod options;
mod parallel;
pub mod plane;
pub mod rasterise;
pub mod refine;
pub mod render;
pub mod sample;
pub mod scan;
pub mod stage;
pub mod triangulate;
#[doc(hidden)]
pub mod vector;
