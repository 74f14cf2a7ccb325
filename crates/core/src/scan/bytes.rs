//! Sums over the bytes of a triangle's row in a plane: short rows, many of them.

use super::lanes::LANES;

/// The first `n` of [`LANES`] bytes.
const MASKS: [[u8; LANES]; LANES + 1] = {
    let mut masks = [[0; LANES]; LANES + 1];
    let mut count = 0;
    while count <= LANES {
        let mut lane = 0;
        while lane < count {
            masks[count][lane] = u8::MAX;
            lane += 1;
        }
        count += 1;
    }
    masks
};

/// The sum of bytes of at most [`MOST_ROWS`] rows, [`LANES`] at a time.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ByteSums {
    lanes: [u16; LANES],
    /// Sum of rows that are too long for the lanes, or too close to the plane's end.
    rest: u64,
}

/// Bytes that a lane of 16 bits holds.
pub(crate) const MOST_ROWS: usize = (u16::MAX / u8::MAX as u16) as usize;

impl ByteSums {
    /// Adds a row: `count` bytes of `plane` from `first` on.
    #[inline(always)]
    pub(crate) fn add(&mut self, plane: &[u8], first: usize, count: usize) {
        // Nearly all of them are short: no loop, no branch on how short.
        if let (Some(mask), Some(bytes)) = (MASKS.get(count), plane[first..].first_chunk::<LANES>())
        {
            for (sum, (byte, mask)) in self.lanes.iter_mut().zip(bytes.iter().zip(mask)) {
                *sum += u16::from(byte & mask);
            }
        } else {
            self.rest += long_sum(&plane[first..first + count]);
        }
    }

    /// The sum.
    #[inline(always)]
    pub(crate) fn total(self) -> u64 {
        self.rest + u64::from(self.lanes.iter().map(|&lane| u32::from(lane)).sum::<u32>())
    }
}

#[cold]
fn long_sum(bytes: &[u8]) -> u64 {
    bytes.iter().map(|&byte| u64::from(byte)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_bytes() {
        let plane: Vec<u8> = (0..300).map(|i| (i * 7) as u8).collect();
        for first in [0, 3, 250, 293, 299] {
            for count in 0..=300 - first {
                let mut sums = ByteSums::default();
                sums.add(&plane, first, count);
                let slow: u64 =
                    plane[first..first + count].iter().map(|&byte| u64::from(byte)).sum();
                assert_eq!(sums.total(), slow, "{count} from {first}");
            }
        }
    }

    #[test]
    fn as_many_white_rows_as_are_allowed_do_not_overflow() {
        let white = [255; LANES];
        let mut sums = ByteSums::default();
        (0..MOST_ROWS).for_each(|_| sums.add(&white, 0, LANES));
        assert_eq!(sums.total(), 255 * (LANES * MOST_ROWS) as u64);
    }
}
