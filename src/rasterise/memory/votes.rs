//! The median of a triangle's pixels.

use super::{signed, unsigned};
use crate::frame::Rgba;
use crate::vector::widest;

/// Pixels that are looked at side by side: 32 bytes.
const LANE: usize = 8;

/// Pixels that are copied at once, where there are as many; triangles are hardly wider.
const STRIDE: usize = 16;

/// The colours that the pixels of a triangle want it to have.
#[derive(Debug, Default)]
pub(super) struct Votes {
    /// Whole lanes; beyond `count` anything.
    pixels: Vec<Rgba>,
    count: usize,
}

impl Votes {
    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Adds the first `count` of `pixels`, each with what is `missed` there.
    #[inline]
    pub(super) fn add(&mut self, pixels: &[Rgba], missed: &[[i8; 4]], count: usize) {
        let end = self.count + count;
        if self.pixels.len() < end + STRIDE {
            self.pixels.resize((2 * end + STRIDE).next_multiple_of(LANE), [0; 4]);
        }
        let out = &mut self.pixels[self.count..];
        let whole = (
            pixels.first_chunk::<STRIDE>(),
            missed.first_chunk::<STRIDE>(),
            out.first_chunk_mut::<STRIDE>(),
        );
        match whole {
            // What is too much is written over.
            (Some(pixels), Some(missed), Some(out)) if count <= STRIDE => {
                wanted(out, pixels, missed)
            }
            _ => wanted(&mut out[..count], &pixels[..count], &missed[..count]),
        }
        self.count = end;
    }

    /// The lower median of each channel, as far as it is no more than `leeway` away from `mean`. The
    /// last channel stays.
    pub(super) fn median(&mut self, mean: Rgba, leeway: u8) -> Rgba {
        let whole = self.count.next_multiple_of(LANE);
        // The highest value counts below no bar but the highest, which more than half are below anyway.
        self.pixels[self.count..whole].fill([255; 4]);
        let (lanes, _) = self.pixels[..whole].as_chunks::<LANE>();
        widest(
            #[inline(always)]
            || search(lanes, self.count, mean, leeway),
        )
    }
}

#[inline(always)]
fn wanted(out: &mut [Rgba], pixels: &[Rgba], missed: &[[i8; 4]]) {
    let all = out.as_flattened_mut().iter_mut().zip(pixels.as_flattened());
    for ((out, &pixel), &missed) in all.zip(missed.as_flattened()) {
        *out = unsigned(signed(pixel).saturating_add(missed));
    }
}

/// Halves the range of each channel until one value is left: the least with half of the pixels at or
/// below it.
#[inline(always)]
fn search(lanes: &[[Rgba; LANE]], count: usize, mean: Rgba, leeway: u8) -> Rgba {
    let mut low = mean.map(|m| m.saturating_sub(leeway));
    let mut high = mean.map(|m| m.saturating_add(leeway));
    let mut width = 2 * u32::from(leeway) + 1;
    while width > 1 {
        let bar = [0, 1, 2, 3].map(|c| low[c].midpoint(high[c]));
        let below = count_below(lanes, bar);
        for c in 0..3 {
            if 2 * below[c] as usize >= count {
                high[c] = bar[c];
            } else {
                low[c] = bar[c].saturating_add(1).min(high[c]);
            }
        }
        width = width.div_ceil(2);
    }
    [low[0], low[1], low[2], mean[3]]
}

/// How many of each channel's values are at or below its bar.
///
/// Two channels at a time, 16 bits apart: 256 + bar - value has bit 8 if and only if value <= bar. Written
/// with bytes, this is not made into vector instructions.
#[inline(always)]
fn count_below(lanes: &[[Rgba; LANE]], bar: Rgba) -> [u32; 4] {
    const TWO: u32 = 0x00ff_00ff;
    let bar = u32::from_le_bytes(bar);
    let bars = [bar & TWO, bar >> 8 & TWO].map(|bars| bars | 0x0100_0100);
    let mut sums = [0u32; 4];
    // As many as 16 bits count.
    for lanes in lanes.chunks(usize::from(u16::MAX)) {
        let mut counts = [[0u32; LANE]; 2];
        for lane in lanes {
            for i in 0..LANE {
                let pixel = u32::from_le_bytes(lane[i]);
                counts[0][i] += (bars[0] - (pixel & TWO)) >> 8 & 0x0001_0001;
                counts[1][i] += (bars[1] - (pixel >> 8 & TWO)) >> 8 & 0x0001_0001;
            }
        }
        for (odd, counts) in counts.iter().enumerate() {
            sums[odd] += counts.iter().map(|n| n & 0xffff).sum::<u32>();
            sums[odd + 2] += counts.iter().map(|n| n >> 16).sum::<u32>();
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};

    #[test]
    fn the_median_is_that_of_the_sorted_values_kept_near_the_mean() {
        for count in [3usize, 8, 9, 60, 2500, 5000] {
            for (spread, mean, leeway) in [(256, 128, 3), (9, 4, 4), (12, 250, 10), (256, 3, 10)] {
                let value = |i: u32, c: u32| {
                    (i32::from(mean) - spread / 2
                        + (rank(3, Purpose::Noise, i, c) % spread as u64) as i32)
                        .clamp(0, 255) as u8
                };
                let pixels: Vec<Rgba> =
                    (0..count as u32).map(|i| [0, 1, 2, 3].map(|c| value(i, c))).collect();
                let mut votes = Votes::default();
                for part in pixels.chunks(11) {
                    votes.add(part, &vec![[0; 4]; part.len()], part.len());
                }
                let found = votes.median([mean, mean, mean, 77], leeway);
                for c in 0..3 {
                    let mut values: Vec<u8> = pixels.iter().map(|p| p[c]).collect();
                    values.sort_unstable();
                    let range = mean.saturating_sub(leeway)..=mean.saturating_add(leeway);
                    let right = values[(count - 1) / 2].clamp(*range.start(), *range.end());
                    assert_eq!(found[c], right, "{count} pixels, mean {mean}, leeway {leeway}");
                }
                assert_eq!(found[3], 77);
            }
        }
    }
}
