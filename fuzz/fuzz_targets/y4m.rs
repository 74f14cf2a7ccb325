//! Raw video as text and planes.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use polyreel::Source;
use polyreel::source::y4m::Y4mSource;

fuzz_target!(|bytes: &[u8]| {
    let Ok(mut source) = Y4mSource::new(bytes, Path::new("fuzz.y4m")) else { return };
    if source.info().size.pixels() > 1 << 18 {
        return;
    }
    while let Ok(Some(_)) = source.next() {}
});
