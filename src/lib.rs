//! polyreel turns pictures, GIFs and video into low-poly art.

pub mod chance;
pub mod colour;
pub mod error;
pub mod feature;
pub mod frame;
pub mod geom;
pub mod hex;
pub mod mesh;
pub mod options;
pub mod rasterise;
pub mod render;
pub mod sample;
pub mod sink;
pub mod source;
pub mod stage;
pub mod triangulate;
