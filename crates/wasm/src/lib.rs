//! The engine of polyreel for the browser.
//!
//! A [`Look`] holds options under the names of the command line and of preset files. An [`Engine`] renders one frame
//! after another with it, an [`Enlarger`] at a multiple of its size. [`PngFile`](png_file), [`Gif`], [`Apng`] and [`MeshStream`] make files. Pixels are RGBA of
//! 8 bits, row by row, alpha not premultiplied. Everything runs on the caller's thread.

mod apng;
mod area;
mod command;
mod described;
mod engine;
mod enlarger;
mod error;
mod faces;
mod frame;
mod gif;
mod look;
mod mesh_stream;
mod preset_file;
mod still;

pub use apng::Apng;
pub use described::described;
pub use engine::Engine;
pub use enlarger::Enlarger;
pub use faces::find_faces;
pub use gif::Gif;
pub use look::Look;
pub use mesh_stream::MeshStream;
pub use still::{png_file, svg_file};
