//! Limits the memory of decoding. Sizes are checked before memory is allocated. Allocated memory is zeroed by the
//! system, so that it is used only when data arrives.

use std::path::Path;

use super::SourceOptions;
use crate::error::{Error, Result};
use crate::geom::Size;

/// Bytes that decoding may take by default: 1 GiB.
const MAX_MEMORY: u64 = 1 << 30;

/// Bytes that the metadata of a file may take: profiles, EXIF.
pub(crate) const METADATA: u64 = 8 << 20;

/// The most bytes that a decoder may take at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Limit(pub(crate) u64);

impl Limit {
    /// The limit that `options` set.
    pub(crate) fn of(options: &SourceOptions) -> Self {
        Self(options.max_memory.unwrap_or(MAX_MEMORY))
    }

    /// Checks that a picture of `size` can be decoded with `bytes` bytes of memory for each pixel.
    ///
    /// # Errors
    /// When it would take more than the limit.
    pub(crate) fn check(self, path: &Path, size: Size, bytes: u64) -> Result<()> {
        self.check_bytes(path, u64::from(size.width) * u64::from(size.height) * bytes, || {
            format!("{size} pixels")
        })
    }

    /// Checks that `bytes` bytes may be allocated for `name`.
    ///
    /// # Errors
    /// When they are more than the limit.
    pub(crate) fn check_bytes(
        self,
        path: &Path,
        bytes: u64,
        name: impl FnOnce() -> String,
    ) -> Result<()> {
        if bytes <= self.0 {
            return Ok(());
        }
        let mib = |bytes: u64| bytes.div_ceil(1 << 20);
        Err(Error::input(
            path,
            format!(
                "decoding {} takes {} MiB of memory, more than the limit of {} MiB; raise it with \
                 --max-memory {}M, or make the picture smaller first",
                name(),
                mib(bytes),
                mib(self.0),
                mib(bytes),
            ),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_takes_too_much_is_refused_with_the_way_out() {
        let (limit, size) = (Limit(100 << 20), Size::new(4096, 4096));
        assert!(limit.check(Path::new("a.png"), size, 6).is_ok());
        let error = limit.check(Path::new("a.png"), size, 8).expect_err("too large").to_string();
        assert!(error.contains("4096x4096") && error.contains("--max-memory 128M"), "{error}");
    }
}
