//! Video in and out through a real ffmpeg, and through stand-ins that misbehave.
//!
//! Needs ffmpeg and ffprobe: without them tests are skipped, loudly, or fail if `REQUIRE_FFMPEG=1`.

#![cfg(unix)]

mod broken;
mod cases;
mod faults;
mod films;
mod given;
mod live;
mod mutations;
mod outputs;
mod pixels;
mod program;
mod seek;
mod sound;
mod stand_in;
mod time;
#[path = "../support/wait.rs"]
mod wait;
