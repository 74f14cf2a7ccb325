//! Checks that there is enough memory, before work begins.

use std::hint::black_box;

use crate::error::{Error, Result};
use crate::geom::Size;

/// Bytes for a pixel of a decoded frame.
const DECODED: u64 = 4;

/// Bytes for a pixel that a still takes at least in addition: its maps and the painted picture. Measured: 17 with the
/// decoded frame, for 4000x4000 (`/usr/bin/time -v polyreel render STILL -o out.png`).
const STILL: u64 = 12;

/// The same for a stream, several frames of which are in the pipeline at a time. Measured: 60 with the decoded frames,
/// for 2000x2000 (the same command with a video).
const STREAM: u64 = 36;

/// Checks that there is memory for frames that are decoded at size `from` and rendered at size `to`. The memory is
/// not kept, and may be taken by others meanwhile. But a limit of the process (`ulimit -v`) is found at once, not by
/// an abort in the middle.
///
/// # Errors
/// [`Error::Memory`] when the memory cannot be allocated.
pub(crate) fn check(from: Size, to: Size, still: bool) -> Result<()> {
    let bytes_per_pixel = if still { STILL } else { STREAM };
    let bytes = (from.pixels() as u64)
        .saturating_mul(DECODED)
        .saturating_add(to.pixels() as u64 * bytes_per_pixel);
    let mut buffer: Vec<u8> = Vec::new();
    let reserved = buffer.try_reserve_exact(usize::try_from(bytes).unwrap_or(usize::MAX));
    // Without this the compiler removes an allocation that is never used.
    black_box(&buffer);
    reserved.map_err(|_| Error::Memory { what: format!("frames of {to}"), bytes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_cannot_be_had_is_an_error() {
        check(Size::new(64, 64), Size::new(64, 64), false).expect("some kilobytes");
        let too_large = Size::new(u32::MAX, 1 << 30);
        let error = check(too_large, Size::new(8, 8), true).expect_err("more than there is");
        assert!(error.to_string().contains("8x8") && !error.is_usage(), "{error}");
    }
}
