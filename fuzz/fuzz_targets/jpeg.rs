//! Chunks, markers and blocks of a file of this format, and the frames that it holds.
#![no_main]

use libfuzzer_sys::fuzz_target;
use polyreel_fuzz::{read_as_input, with_magic};

fuzz_target!(|bytes: &[u8]| read_as_input(&with_magic(b"\xff\xd8\xff", bytes)));
