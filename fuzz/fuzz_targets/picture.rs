//! Tags and headers of TIFF, BMP and PNM.
#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};
use polyreel_fuzz::read_as_input;

/// What files of these formats begin with. All others would be given to ffmpeg.
const MAGIC: [&[u8]; 9] =
    [b"II*\0", b"MM\0*", b"BM", b"P1\n", b"P2\n", b"P4\n", b"P5\n", b"P6\n", b"P7\n"];

fuzz_target!(|bytes: &[u8]| -> Corpus {
    if !MAGIC.iter().any(|magic| bytes.starts_with(magic)) {
        return Corpus::Reject;
    }
    read_as_input(bytes);
    Corpus::Keep
});
