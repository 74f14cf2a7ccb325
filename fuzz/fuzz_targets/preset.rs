//! Preset files. What is read can be written, and is then the same.
#![no_main]

use libfuzzer_sys::fuzz_target;
use polyreel::preset::{from_toml, to_toml};

fuzz_target!(|text: &str| {
    let Ok(options) = from_toml(text) else { return };
    options.validate().expect("what is read is sound");
    let Ok(written) = to_toml(&options) else { return };
    assert_eq!(from_toml(&written).expect("what is written can be read"), options);
});
