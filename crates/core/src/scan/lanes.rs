//! Sums over the pixels of a triangle's row: short rows, many of them.

use crate::frame::Rgba;

/// Pixels that are looked at together.
pub(crate) const LANES: usize = 16;

/// Calls `visit` with the first `count` pixels of `row`, which may go on, [`LANES`] at a time and in
/// little-endian order, 0 after the last.
#[inline(always)]
fn each(row: &[Rgba], count: usize, mut visit: impl FnMut([u32; LANES])) {
    let mut done = 0;
    // Nearly always one iteration.
    while done < count {
        let mask = &MASKS[LANES.min(count - done)];
        // Two calls: with one the lanes would no longer become vectors.
        if let Some(lanes) = row[done..].first_chunk::<LANES>() {
            visit(masked(lanes, mask));
        } else {
            // The right border of the frame.
            let mut lanes = [[0; 4]; LANES];
            lanes[..count - done].copy_from_slice(&row[done..count]);
            visit(masked(&lanes, mask));
        }
        done += LANES;
    }
}

#[inline(always)]
fn masked(pixels: &[Rgba; LANES], mask: &[u32; LANES]) -> [u32; LANES] {
    std::array::from_fn(
        #[inline(always)]
        |lane| u32::from_le_bytes(pixels[lane]) & mask[lane],
    )
}

/// Sums of opaque pixels, [`LANES`] at a time.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LaneSums {
    /// Red in the lower and blue in the upper half of each number.
    red_blue: [u32; LANES],
    green: [u32; LANES],
    /// Number of additions to each lane.
    added: u32,
}

/// Additions to a lane that stay below 2^16 in each half.
pub(crate) const MOST_ADDED: u32 = 65535 / 255;

/// The first `n` of [`LANES`] pixels.
const MASKS: [[u32; LANES]; LANES + 1] = {
    let mut masks = [[0; LANES]; LANES + 1];
    let mut count = 0;
    while count <= LANES {
        let mut lane = 0;
        while lane < count {
            masks[count][lane] = u32::MAX;
            lane += 1;
        }
        count += 1;
    }
    masks
};

#[expect(clippy::needless_range_loop, reason = "indices become vector code, iterators less so")]
impl LaneSums {
    /// Whether [`LaneSums::take`] has to come first: this many more `pixels` of a row may overflow the sums.
    #[inline(always)]
    pub(crate) fn is_full_with(&self, pixels: usize) -> bool {
        self.added as usize + pixels.div_ceil(LANES) > MOST_ADDED as usize
    }

    /// Adds the first `count` pixels of `row`, which may go on: at most [`LANES`] x [`MOST_ADDED`].
    #[inline(always)]
    pub(crate) fn add(&mut self, row: &[Rgba], count: usize) {
        each(
            row,
            count,
            #[inline(always)]
            |pixels| {
                for lane in 0..LANES {
                    self.red_blue[lane] += pixels[lane] & 0x00ff_00ff;
                    self.green[lane] += pixels[lane] >> 8 & 0xff;
                }
                self.added += 1;
            },
        );
    }

    /// The sums of red, green and blue, which begin anew.
    #[inline(always)]
    pub(crate) fn take(&mut self) -> [u64; 3] {
        let mut sums = [0u64; 3];
        for lane in 0..LANES {
            sums[0] += u64::from(self.red_blue[lane] & 0xffff);
            sums[1] += u64::from(self.green[lane]);
            sums[2] += u64::from(self.red_blue[lane] >> 16);
        }
        *self = Self::default();
        sums
    }
}

/// The squares of red, green and blue of a pixel in little-endian order, together.
#[inline(always)]
pub(crate) const fn square(pixel: u32) -> u32 {
    let (r, g, b) = (pixel & 0xff, pixel >> 8 & 0xff, pixel >> 16 & 0xff);
    r * r + g * g + b * b
}

/// Sums of the squares of red, green and blue, [`LANES`] pixels at a time. A lane holds those of 22,000
/// pixels: 2^32 / (3 x 255^2).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LaneSquares([u32; LANES]);

impl LaneSquares {
    /// Adds the first `count` pixels of `row`, which may go on.
    #[inline(always)]
    pub(crate) fn add(&mut self, row: &[Rgba], count: usize) {
        each(
            row,
            count,
            #[inline(always)]
            |pixels| {
                for (sum, pixel) in self.0.iter_mut().zip(pixels) {
                    *sum += square(pixel);
                }
            },
        );
    }

    /// The sum of all.
    #[inline(always)]
    pub(crate) fn total(self) -> u64 {
        self.0.iter().map(|&v| u64::from(v)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(length: usize) -> Vec<Rgba> {
        (0..length).map(|x| [x as u8, (x * 7) as u8, 255, 255]).collect()
    }

    #[test]
    fn sums_are_those_of_the_pixels_up_to_the_end_of_the_row() {
        let pixels = row(300);
        for first in [0, 3, 250, 293, 299] {
            for count in 0..=300 - first {
                let mut sums = LaneSums::default();
                sums.add(&pixels[first..], count);
                let mut slow = [0; 3];
                for pixel in &pixels[first..first + count] {
                    for (sum, &v) in slow.iter_mut().zip(pixel) {
                        *sum += u64::from(v);
                    }
                }
                assert_eq!(sums.take(), slow, "{count} from {first}");
            }
        }
    }

    #[test]
    fn squares_are_those_of_the_pixels() {
        let pixels = row(40);
        for (first, count) in [(0, 0), (3, 5), (0, 16), (2, 38), (30, 10), (39, 1)] {
            let mut squares = LaneSquares::default();
            squares.add(&pixels[first..], count);
            let square = |&v: &u8| u64::from(v) * u64::from(v);
            let slow = pixels[first..first + count].iter().flat_map(|p| p[..3].iter().map(square));
            assert_eq!(squares.total(), slow.sum::<u64>(), "{count} from {first}");
        }
    }

    #[test]
    fn as_many_white_pixels_as_are_allowed_do_not_overflow() {
        let white = vec![[255; 4]; LANES * MOST_ADDED as usize];
        let mut sums = LaneSums::default();
        assert!(!sums.is_full_with(white.len()));
        sums.add(&white, white.len());
        assert!(sums.is_full_with(1));
        assert_eq!(sums.take(), [255 * white.len() as u64; 3]);
        assert!(!sums.is_full_with(1));
    }
}
