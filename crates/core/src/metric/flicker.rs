//! Flicker of a rendered clip: its changes beyond those of the source.

use crate::parallel::prelude::*;

use super::same_size;
use crate::error::Result;
use crate::frame::Frame;
use crate::geom::Size;

/// FDB, the difference of frame differences: the mean over pixel, channel (R, G, B) and pair of
/// successive frames of |(`O_t` - `O_t-1`) - (`I_t` - `I_t-1`)|, 0..510, with I the source and O the
/// rendering. Fed frame by frame; keeps the memory of one frame.
#[derive(Clone, Debug, Default)]
pub struct Flicker {
    last: Option<(Size, Vec<[i16; 3]>)>,
    sum: u128,
    samples: u128,
}

impl Flicker {
    /// A clip of which nothing was seen yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The next frame of the source and its rendering.
    ///
    /// # Errors
    /// When the two differ in size, or from the frames before.
    pub fn push(&mut self, input: &Frame, output: &Frame) -> Result<()> {
        same_size(input.size(), output.size())?;
        if let Some((size, _)) = self.last {
            same_size(size, output.size())?;
        }
        // (O_t - O_t-1) - (I_t - I_t-1) = (O_t - I_t) - (O_t-1 - I_t-1).
        let pairs = input.pixels().par_iter().zip(output.pixels()).with_min_len(1 << 14);
        let error: Vec<[i16; 3]> = pairs
            .map(|(i, o)| std::array::from_fn(|c| i16::from(o[c]) - i16::from(i[c])))
            .collect();
        if let Some((_, last)) = &self.last {
            let change = |(now, last): (&[i16; 3], &[i16; 3])| {
                (0..3).map(|c| u64::from(now[c].abs_diff(last[c]))).sum::<u64>()
            };
            let pairs = error.par_iter().zip(last).with_min_len(1 << 14);
            self.sum += u128::from(pairs.map(change).sum::<u64>());
            self.samples += 3 * error.len() as u128;
        }
        self.last = Some((input.size(), error));
        Ok(())
    }

    /// The mean so far, 0..510; `None` before the second frame.
    pub fn value(&self) -> Option<f64> {
        (self.samples > 0).then(|| self.sum as f64 / self.samples as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(v: u8) -> Frame {
        Frame::filled(Size::new(5, 4), [v, v, 0, 255]).expect("a sound size")
    }

    #[test]
    fn a_rendering_that_follows_its_source_does_not_flicker() {
        let mut flicker = Flicker::new();
        for v in [10, 60, 30, 200] {
            flicker.push(&frame(v), &frame(v + 7)).expect("one size");
        }
        assert_eq!(flicker.value(), Some(0.0));
    }

    #[test]
    fn the_mean_is_over_pixels_channels_and_pairs() {
        let mut flicker = Flicker::new();
        assert_eq!(flicker.value(), None);
        // Changes of the output 250 and -250, of the input 0 and -3, in two channels of three.
        for (input, output) in [(5, 0), (5, 250), (2, 0)] {
            flicker.push(&frame(input), &frame(output)).expect("one size");
        }
        let mean = flicker.value().expect("two pairs");
        assert!((mean - (250.0 + 247.0) / 2.0 * 2.0 / 3.0).abs() < 1e-12, "{mean}");
    }

    #[test]
    fn sizes_must_agree() {
        let other = Frame::filled(Size::new(4, 5), [0; 4]).expect("a sound size");
        let mut flicker = Flicker::new();
        assert!(flicker.push(&frame(0), &other).is_err());
        flicker.push(&other, &other).expect("one size");
        assert!(flicker.push(&frame(0), &frame(0)).is_err());
    }
}
