//! BLAKE3 hashes of frames and files.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use blake3::Hasher;

use crate::error::{Error, Result};
use crate::frame::Rational;
use crate::source::Decoded;

/// The hash of one frame.
pub type Hash = [u8; 32];

/// The hash of a frame's picture, its form and its time.
pub fn of_frame(decoded: &Decoded) -> Hash {
    let Decoded { frame, span, .. } = decoded;
    let mut hasher = Hasher::new();
    let mut number = |n: i64| {
        hasher.update(&n.to_le_bytes());
    };
    // No length is that of no time.
    let length = span.length.unwrap_or(Rational { num: 0, den: 0 });
    [span.start.num, span.start.den, length.num, length.den].into_iter().for_each(&mut number);
    [frame.size().width, frame.size().height].into_iter().for_each(|n| number(n.into()));
    match frame.planes() {
        // Pixels of planes are made only where somebody asks for them.
        Some(planes) => {
            hasher.update(format!("{:?}", planes.form).as_bytes());
            hasher.update(&planes.data);
        }
        None => {
            hasher.update(frame.pixels().as_flattened());
        }
    }
    *hasher.finalize().as_bytes()
}

/// Collects the hashes of a shot's frames.
#[derive(Clone, Debug, Default)]
pub struct ShotHasher(Hasher);

impl ShotHasher {
    /// Adds the next frame's.
    pub fn add(&mut self, frame: &Hash) {
        self.0.update(frame);
    }

    /// That of the shot; the next one begins.
    pub fn take(&mut self) -> String {
        let hash = text(&self.0);
        self.0.reset();
        hash
    }
}

/// The hash of `text`.
pub fn of_text(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex().to_string()
}

/// The hash of what is in `paths`, in their order, and how many bytes that is.
///
/// # Errors
/// When one cannot be read.
pub fn of_files(paths: &[PathBuf]) -> Result<(String, u64)> {
    let mut hasher = Hasher::new();
    let mut bytes = 0;
    for path in paths {
        let length = add_file(&mut hasher, path).map_err(|error| {
            Error::input(path, format!("cannot be read: {error}")).caused_by(error)
        })?;
        // Where one ends and the next begins.
        hasher.update(&length.to_le_bytes());
        bytes += length;
    }
    Ok((text(&hasher), bytes))
}

/// The hash of the file `path`, as `b3sum` has it.
///
/// # Errors
/// When it cannot be read.
pub fn of_file(path: &Path) -> io::Result<String> {
    let mut hasher = Hasher::new();
    add_file(&mut hasher, path)?;
    Ok(text(&hasher))
}

fn add_file(hasher: &mut Hasher, path: &Path) -> io::Result<u64> {
    let before = hasher.count();
    hasher.update_reader(File::open(path)?)?;
    Ok(hasher.count() - before)
}

fn text(hasher: &Hasher) -> String {
    hasher.finalize().to_hex().to_string()
}
