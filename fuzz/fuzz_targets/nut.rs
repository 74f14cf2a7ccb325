//! The container in which frames come from ffmpeg.
#![no_main]

use libfuzzer_sys::fuzz_target;
use polyreel::ffmpeg::nut::NutReader;

fuzz_target!(|bytes: &[u8]| {
    // As many bytes a frame as the first byte says.
    let Some((&each, stream)) = bytes.split_first() else { return };
    let Ok(mut reader) = NutReader::new(stream, usize::from(each)) else { return };
    let mut frame = Vec::new();
    while let Ok(Some(_)) = reader.next(&mut frame) {}
});
