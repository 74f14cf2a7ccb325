//! ffmpeg and ffprobe as child processes: finding, starting, watching and ending them, and the streams to and from
//! them.

mod address;
#[cfg(feature = "ffmpeg")]
pub(crate) mod child;
#[cfg(feature = "ffmpeg")]
pub(crate) mod command;
#[cfg(feature = "ffmpeg")]
mod failure;
#[cfg(feature = "ffmpeg")]
pub(crate) mod feed;
#[cfg(feature = "ffmpeg")]
mod fields;
#[cfg(feature = "ffmpeg")]
pub(crate) mod formats;
#[cfg(feature = "ffmpeg")]
mod heif;
#[cfg(feature = "ffmpeg")]
pub mod nut;
#[cfg(feature = "ffmpeg")]
mod pipe;
#[cfg(feature = "ffmpeg")]
mod pixels;
#[cfg(feature = "ffmpeg")]
pub(crate) mod probe;
mod processes;
mod programs;
#[cfg(feature = "ffmpeg")]
mod shape;
#[cfg(feature = "ffmpeg")]
pub(crate) mod side;
#[cfg(feature = "ffmpeg")]
mod times;
#[cfg(feature = "ffmpeg")]
pub(crate) mod tracks;
#[cfg(feature = "ffmpeg")]
mod watch;

pub(crate) use address::{is_camera, is_url};
#[cfg(feature = "ffmpeg")]
pub use failure::FfmpegError;
#[cfg(feature = "ffmpeg")]
pub(crate) use pipe::Pipe;
pub use processes::Processes;
pub use programs::Ffmpeg;
