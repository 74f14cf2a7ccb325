//! Preset files. What is read can be written, and is then the same.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let Ok(options) = polyreel::preset::from_toml(text) else { return };
    options.validate().expect("what is read is sound");
    let Ok(written) = polyreel::preset::to_toml(&options) else { return };
    polyreel::preset::from_toml(&written).expect("what is written can be read");
});
