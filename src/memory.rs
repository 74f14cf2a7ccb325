//! Whether there is memory enough, found out before work is begun.

use std::hint::black_box;

use crate::error::{Error, Result};
use crate::geom::Size;

/// Bytes a pixel of decoded frames.
const DECODED: u64 = 4;

/// Bytes a pixel that a still takes at least beside that: with its maps and the picture that is painted.
/// Measured: 17 in all for 4000x4000.
const STILL: u64 = 12;

/// The same of a stream, of which several frames are worked on at a time. Measured: 60 in all for 2000x2000.
const STREAM: u64 = 36;

/// Checks that frames that are decoded at `from` and rendered at `to` can be worked on. Nothing is kept: the
/// memory may be gone when it is needed. But what a process may not have at all (`ulimit -v`) is known at
/// once, in place of an abort in the middle.
///
/// # Errors
/// [`Error::Memory`] when there is not so much memory.
pub(crate) fn check(from: Size, to: Size, still: bool) -> Result<()> {
    let each = if still { STILL } else { STREAM };
    let bytes =
        (from.pixels() as u64).saturating_mul(DECODED).saturating_add(to.pixels() as u64 * each);
    let mut room: Vec<u8> = Vec::new();
    let reserved = room.try_reserve_exact(usize::try_from(bytes).unwrap_or(usize::MAX));
    // Memory that nobody looks at would not be asked for.
    black_box(&room);
    reserved.map_err(|_| Error::Memory { what: format!("frames of {to}"), bytes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_cannot_be_had_is_an_error() {
        check(Size::new(64, 64), Size::new(64, 64), false).expect("some kilobytes");
        let vast = Size::new(u32::MAX, 1 << 30);
        let error = check(vast, Size::new(8, 8), true).expect_err("more than there is");
        assert!(error.to_string().contains("8x8") && !error.is_usage(), "{error}");
    }
}
