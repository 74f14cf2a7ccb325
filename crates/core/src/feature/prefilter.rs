//! Filters a frame before features are looked for.

use super::bilateral::Bilateral;
use super::smooth::smooth;
use crate::frame::Frame;
use crate::options::Prefilter;
use crate::parallel::prelude::*;

/// `frame` under the filter that the options name.
pub(super) fn filtered(frame: &Frame, filter: Prefilter) -> Frame {
    match filter {
        // Twice 1 2 1 is 1 4 6 4 1.
        Prefilter::Blur => smooth(&smooth(frame)),
        Prefilter::Sharpen => sharpened(frame),
        Prefilter::Bilateral => {
            Bilateral::default().smooth(frame).expect("the defaults are in range")
        }
    }
}

/// `frame` under the kernel 0 -1 0, -1 5 -1, 0 -1 0: less its Laplacian; the border repeats itself outwards.
pub fn sharpened(frame: &Frame) -> Frame {
    let size = frame.size();
    let mut pixels = vec![[0; 4]; size.pixels()];
    let rows = pixels.par_chunks_mut(size.width.max(1) as usize).enumerate();
    rows.for_each(|(y, out)| {
        let y = y as u32;
        let (above, here) = (frame.row(y.saturating_sub(1)), frame.row(y));
        let below = frame.row((y + 1).min(size.height - 1));
        let last = here.len() - 1;
        for (x, pixel) in out.iter_mut().enumerate() {
            let sides = [here[x.saturating_sub(1)], here[(x + 1).min(last)], above[x], below[x]];
            let channel = |c: usize| {
                let sum: i32 = sides.iter().map(|side| i32::from(side[c])).sum();
                (5 * i32::from(here[x][c]) - sum).clamp(0, 255) as u8
            };
            *pixel = [channel(0), channel(1), channel(2), here[x][3]];
        }
    });
    Frame::known(size, pixels, frame.is_opaque()).expect("as many pixels as before")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;

    #[test]
    fn a_step_is_steeper_after_sharpening() {
        let pixel = |i: usize| if i % 6 < 3 { [100, 100, 100, 255] } else { [120, 120, 120, 255] };
        let step = Frame::new(Size::new(6, 3), (0..18).map(pixel).collect()).expect("small");
        let row: Vec<u8> = sharpened(&step).row(1).iter().map(|p| p[0]).collect();
        assert_eq!(row, [100, 100, 80, 140, 120, 120]);
    }

    #[test]
    fn filters_leave_flat_frames_of_any_size() {
        for size in [Size::new(1, 1), Size::new(1, 4), Size::new(9, 2)] {
            let flat = Frame::filled(size, [10, 200, 90, 120]).expect("flat");
            for filter in Prefilter::ALL {
                assert_eq!(filtered(&flat, filter), flat, "{filter:?}");
            }
        }
    }
}
