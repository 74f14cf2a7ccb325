//! What the fuzz targets share: reading bytes as a file.

use std::cell::RefCell;
use std::io::{Seek, Write};

use polyreel::{Source, SourceOptions};

/// The most pixels of a picture that is decoded.
const MAX_PIXELS: usize = 1 << 18;

/// Frames that are read of a stream.
const FRAMES: usize = 6;

thread_local! {
    static FILE: RefCell<Option<tempfile::NamedTempFile>> = const { RefCell::new(None) };
}

/// Reads `bytes` as an input file, and some of its frames if they are small. An error is fine.
pub fn read_as_input(bytes: &[u8]) {
    FILE.with_borrow_mut(|file| {
        let file = file.get_or_insert_with(|| tempfile::NamedTempFile::new().expect("a file"));
        file.as_file().set_len(0).expect("an empty file");
        file.rewind().expect("a file");
        file.write_all(bytes).expect("a file");
        let options = SourceOptions {
            ffmpeg: std::path::PathBuf::from("/nonexistent/ffmpeg").into(),
            ..SourceOptions::default()
        };
        let Ok(input) = polyreel::open(&[file.path()], &options) else { return };
        if input.info().size.pixels() <= MAX_PIXELS
            && let Ok(source) = input.start()
        {
            read_frames(source);
        }
    });
}

/// Reads some frames of `source`. An error is fine.
pub fn read_frames(mut source: Box<dyn Source>) {
    for _ in 0..FRAMES {
        if !matches!(source.next(), Ok(Some(_))) {
            return;
        }
    }
}

/// `bytes` behind the `magic` that makes them be taken for a format, unless they have it.
pub fn with_magic(magic: &[u8], bytes: &[u8]) -> Vec<u8> {
    if bytes.starts_with(magic) { bytes.to_vec() } else { [magic, bytes].concat() }
}
