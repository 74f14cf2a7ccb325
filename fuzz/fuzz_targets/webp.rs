//! Chunks, markers and blocks of a file of this format, and the frames that it holds.
#![no_main]

use libfuzzer_sys::fuzz_target;
use polyreel_fuzz::{read_as_input, with_magic};

fuzz_target!(|bytes: &[u8]| {
    let mut file = with_magic(b"RIFF", bytes);
    // Behind the length.
    let Some(name) = file.get_mut(8..12) else { return };
    name.copy_from_slice(b"WEBP");
    read_as_input(&file);
});
