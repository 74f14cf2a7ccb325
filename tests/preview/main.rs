//! The live window: the real program on a real display, pressed and looked at through X.
//!
//! Needs an X display: without one the tests are skipped, loudly, or fail if `REQUIRE_DISPLAY=1`.

#![cfg(all(target_os = "linux", feature = "preview"))]

mod display;
mod given;
#[path = "../support/wait.rs"]
mod wait;
mod window;
