//! Blurs a frame a little before its colours are clustered, so that grain makes no regions.

use crate::parallel::prelude::*;

use crate::frame::Frame;

/// Rows in one parallel piece of work.
const BAND: usize = 32;

/// `frame` under the 3x3 binomial filter (1 2 1 by 1 2 1, sixteenths, rounded); the border repeats.
pub fn smooth(frame: &Frame) -> Frame {
    let size = frame.size();
    let width = size.width as usize;
    let mut pixels = vec![[0; 4]; size.pixels()];
    pixels.par_chunks_mut(width * BAND).enumerate().for_each(|(band, out)| {
        // The column sums of a row, with one pixel more on either side.
        let mut sums = vec![0u16; (width + 2) * 4];
        for (i, out) in out.chunks_mut(width).enumerate() {
            let y = (band * BAND + i) as u32;
            let above = frame.row(y.saturating_sub(1)).as_flattened();
            let below = frame.row((y + 1).min(size.height - 1)).as_flattened();
            let here = frame.row(y).as_flattened();
            sum_columns(above, here, below, &mut sums[4..][..width * 4]);
            sums.copy_within(4..8, 0);
            sums.copy_within(width * 4..(width + 1) * 4, (width + 1) * 4);
            weigh_row(&sums, out.as_flattened_mut());
        }
    });
    Frame::known(size, pixels, frame.is_opaque()).expect("as many pixels as before")
}

// Plain loops over bytes: the compiler turns them into vector code.

fn sum_columns(above: &[u8], here: &[u8], below: &[u8], sums: &mut [u16]) {
    for (((sum, &a), &h), &b) in sums.iter_mut().zip(above).zip(here).zip(below) {
        *sum = u16::from(a) + 2 * u16::from(h) + u16::from(b);
    }
}

fn weigh_row(sums: &[u16], out: &mut [u8]) {
    let (left, middle, right) = (sums, &sums[4..], &sums[8..]);
    for (((out, &l), &m), &r) in out.iter_mut().zip(left).zip(middle).zip(right) {
        *out = ((l + 2 * m + r + 8) >> 4) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;

    #[test]
    fn a_dot_becomes_the_kernel_and_flat_stays_flat() {
        let size = Size::new(5, 5);
        let mut pixels = vec![[0, 0, 0, 255]; 25];
        pixels[12] = [160, 16, 0, 255];
        let out = smooth(&Frame::new(size, pixels).expect("a dot"));
        assert_eq!(out.at(2, 2), [40, 4, 0, 255]);
        assert_eq!(out.at(1, 2), [20, 2, 0, 255]);
        assert_eq!(out.at(3, 3), [10, 1, 0, 255]);
        assert_eq!(out.at(0, 0), [0, 0, 0, 255]);
        for size in [Size::new(1, 1), Size::new(2, 1), Size::new(1, 3), Size::new(9, 40)] {
            let flat = Frame::filled(size, [1, 2, 3, 200]).expect("flat");
            assert_eq!(smooth(&flat), flat);
        }
    }
}
