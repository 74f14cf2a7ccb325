//! Reports that are replayed.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use polyreel::pipeline::Script;

fuzz_target!(|bytes: &[u8]| {
    let Ok(script) = Script::parse(Path::new("fuzz.json"), bytes) else { return };
    let _ = script.check(&polyreel::Options::default());
});
