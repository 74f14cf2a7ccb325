//! All tests that need neither ffmpeg nor a display, in one program: the library on inputs made here,
//! and the program itself (`cli`).
//!
//! `cargo test --test it golden` runs one module.

mod cli;
mod colours;
mod dependencies;
#[cfg(feature = "faces")]
mod faces;
mod facets;
mod files;
mod golden;
mod layers;
mod looks;
mod looped;
mod maps;
mod methods;
mod mutations;
mod orders;
mod outline;
mod pipeline;
mod planes;
mod studies;
mod temporal;
#[path = "../support/wait.rs"]
mod wait;
mod watched;
