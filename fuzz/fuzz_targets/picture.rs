//! Tags and headers of pictures: TIFF, BMP and PNM, by their own magic bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use polyreel_fuzz::read_as_input;

fuzz_target!(|bytes: &[u8]| read_as_input(bytes));
