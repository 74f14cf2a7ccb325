//! The live window: the real program on a real display, pressed and looked at through X.
//!
//! Needs an X display: without one the tests are skipped, loudly, or fail if `REQUIRE_DISPLAY=1`.

#[cfg(all(target_os = "linux", feature = "preview"))]
mod display;
#[cfg(all(target_os = "linux", feature = "preview"))]
mod given;
mod none;
#[cfg(all(target_os = "linux", feature = "preview"))]
mod window;
