//! The ffmpeg and ffprobe of the machine: how they are found, asked, started, watched and ended, and the
//! streams that go to them and come from them.

pub(crate) mod child;
pub(crate) mod command;
mod fields;
pub mod nut;
mod pipe;
pub(crate) mod probe;
pub(crate) mod watch;

pub(crate) use pipe::Pipe;
pub use watch::hang_up;
