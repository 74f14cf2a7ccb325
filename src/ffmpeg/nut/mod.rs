//! Raw video in NUT, the container for frames with exact times from and to ffmpeg.
//!
//! Follows the specification (<https://ffmpeg.org/~michael/nut.txt>, versions 3 and 4) for one stream
//! that is read from front to back: no index, no seeking, no resynchronisation.

mod packet;
mod read;
mod write;

pub use read::NutReader;
pub use write::NutWriter;
