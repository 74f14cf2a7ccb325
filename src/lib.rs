//! polyreel turns pictures, GIFs and video into low-poly art.

pub mod chance;
pub mod colour;
pub mod draw;
pub mod error;
pub mod evaluate;
pub mod feature;
pub mod flow;
pub mod frame;
pub mod geom;
pub mod hex;
pub mod mesh;
pub mod metric;
pub mod options;
pub mod pattern;
pub mod pipeline;
pub mod rasterise;
pub mod refine;
pub mod render;
pub mod sample;
pub mod scan;
pub mod sink;
pub mod source;
pub mod stage;
pub mod triangulate;
