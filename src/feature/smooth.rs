//! A small blur before colours are clustered, so that grain draws no regions.

use rayon::prelude::*;

use crate::frame::{Frame, Rgba};

/// Rows that are smoothed as one piece of work.
const BAND: usize = 32;

/// `frame` under the 3x3 binomial filter (1 2 1 by 1 2 1, sixteenths, rounded); the border repeats.
pub fn smooth(frame: &Frame) -> Frame {
    let size = frame.size();
    let width = size.width as usize;
    let mut pixels = vec![[0; 4]; size.pixels()];
    pixels.par_chunks_mut(width * BAND).enumerate().for_each(|(band, out)| {
        let mut column = vec![[0u16; 4]; width];
        for (i, out) in out.chunks_mut(width).enumerate() {
            let y = (band * BAND + i) as u32;
            let above = frame.row(y.saturating_sub(1));
            let below = frame.row((y + 1).min(size.height - 1));
            for (((sum, a), m), b) in column.iter_mut().zip(above).zip(frame.row(y)).zip(below) {
                *sum =
                    [0, 1, 2, 3].map(|c| u16::from(a[c]) + 2 * u16::from(m[c]) + u16::from(b[c]));
            }
            smooth_row(&column, out);
        }
    });
    Frame::new(size, pixels).expect("as many pixels as before")
}

fn smooth_row(column: &[[u16; 4]], out: &mut [Rgba]) {
    let last = column.len() - 1;
    let weigh = |l: [u16; 4], m: [u16; 4], r: [u16; 4]| {
        [0, 1, 2, 3].map(|c| ((l[c] + 2 * m[c] + r[c] + 8) >> 4) as u8)
    };
    out[0] = weigh(column[0], column[0], column[last.min(1)]);
    out[last] = weigh(column[last.saturating_sub(1)], column[last], column[last]);
    for (out, around) in out[1..].iter_mut().zip(column.windows(3)) {
        *out = weigh(around[0], around[1], around[2]);
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
