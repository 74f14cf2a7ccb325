//! Few colours that stand for many: the palette of a GIF, from the colours of a picture's triangles
//! and their areas, never from its pixels.
//!
//! A new palette comes from splitting the set of colours where that lowers the squared error most
//! (X. Wu, "Color quantization by dynamic programming and principal analysis", 1992, on the axes),
//! followed by rounds of k-means (Lloyd). The last palette is kept as long as it fits, so that colours do not
//! flicker from frame to frame.

mod divide;

use rayon::prelude::*;

use crate::frame::{Fill, Rgba};
use crate::simd::dispatch;

use divide::divide;

/// Most colours in a palette: one of the 256 of a GIF stands for "transparent".
pub(crate) const MOST: usize = 255;

/// Rounds of k-means after splitting, and when starting from the last palette. Measured on flat
/// pictures of 5000 colours: the third round after a split gains 0.1 dB, the fifth nothing.
const ROUNDS: usize = 3;
const WARM_ROUNDS: usize = 2;

/// A palette is kept, or accepted, while its mean squared error is at most this factor and this much
/// above that of the last one that was made anew: 2 is 3 dB, of the more than 40 that it begins with.
/// Less than that is what every palette loses on colours that it was not made for, and each new one
/// makes the picture flicker.
const TOLERANCE: f64 = 2.0;
const SLACK: f64 = 1.0;

/// A colour without alpha.
pub(crate) type Rgb = [u8; 3];

/// A colour and the pixels that have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Weighted {
    pub(crate) colour: Rgb,
    pub(crate) weight: u64,
}

/// The distinct colours among the fills that are not transparent (`threshold` and above), in
/// ascending order.
pub(crate) fn distinct(fills: &[Fill], threshold: u8) -> Vec<Weighted> {
    let mut all: Vec<Weighted> = fills
        .iter()
        .filter(|f| f.colour[3] >= threshold && f.area > 0)
        .map(|f| Weighted { colour: rgb(f.colour), weight: f.area.into() })
        .collect();
    all.sort_unstable_by_key(|w| w.colour);
    all.dedup_by(|next, kept| {
        let same = next.colour == kept.colour;
        if same {
            kept.weight += next.weight;
        }
        same
    });
    all
}

/// A colour without its alpha.
pub(crate) const fn rgb([r, g, b, _]: Rgba) -> Rgb {
    [r, g, b]
}

/// Squared distance of two colours, at most 3 x 255^2.
pub(crate) fn distance(a: Rgb, b: Rgb) -> u32 {
    let d = |i: usize| i32::from(a[i]) - i32::from(b[i]);
    (d(0) * d(0) + d(1) * d(1) + d(2) * d(2)) as u32
}

/// At most [`MOST`] colours.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Palette {
    colours: Vec<Rgb>,
    /// Mean squared error, per pixel, all channels, over the picture for which it, or the one from
    /// which it has grown, was made anew.
    error: f64,
}

impl Palette {
    /// The palette for a picture of `colours`, `last` while it fits, else a better one; and what of it
    /// stands for each of the colours, ready to be looked up.
    pub(crate) fn next(colours: &[Weighted], last: Option<&Self>) -> (Self, Lookup) {
        let (palette, matches) = Self::fitted(colours, last);
        let lookup = Lookup::new(colours, &matches, &palette);
        (palette, lookup)
    }

    fn fitted(colours: &[Weighted], last: Option<&Self>) -> (Self, Vec<Match>) {
        let Some(last) = last else { return Self::new(colours) };
        let good = last.error * TOLERANCE + SLACK;
        let matches = nearest(colours, &last.colours);
        if error(colours, &matches) <= good {
            return (last.clone(), matches);
        }
        if colours.len() > MOST {
            let (warm, matches) =
                Self::refined(colours, last.colours.clone(), matches, WARM_ROUNDS);
            if warm.error <= good {
                return (Self { error: last.error, ..warm }, matches);
            }
        }
        Self::new(colours)
    }

    fn new(colours: &[Weighted]) -> (Self, Vec<Match>) {
        if colours.is_empty() {
            // A wholly transparent picture; a palette is never empty.
            return (Self { colours: vec![[0; 3]], error: 0.0 }, Vec::new());
        }
        if colours.len() <= MOST {
            let palette: Vec<_> = colours.iter().map(|w| w.colour).collect();
            let matches = (0..palette.len()).map(|i| Match { index: i as u8, distance: 0 });
            let matches = matches.collect();
            return (Self { colours: palette, error: 0.0 }, matches);
        }
        let start = divide(colours);
        let matches = nearest(colours, &start);
        Self::refined(colours, start, matches, ROUNDS)
    }

    /// `start`, of which `matches` are the nearest, after rounds of k-means, and the nearest of what
    /// comes out. A colour that stands for nothing stays where it is.
    fn refined(
        colours: &[Weighted],
        start: Vec<Rgb>,
        mut matches: Vec<Match>,
        rounds: usize,
    ) -> (Self, Vec<Match>) {
        let mut palette = start;
        for _ in 0..rounds {
            let mut sums = vec![[0u64; 4]; palette.len()];
            for (w, m) in colours.iter().zip(&matches) {
                add(&mut sums[m.index as usize], w);
            }
            for (colour, [r, g, b, n]) in palette.iter_mut().zip(sums) {
                if n > 0 {
                    *colour = [r, g, b].map(|s| ((s + n / 2) / n) as u8);
                }
            }
            matches = nearest(colours, &palette);
        }
        (Self { error: error(colours, &matches), colours: palette }, matches)
    }

    /// The colours, by index.
    pub(crate) fn colours(&self) -> &[Rgb] {
        &self.colours
    }
}

/// The colour of a palette that stands for another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Match {
    /// Its place in the palette.
    pub(crate) index: u8,
    /// Its squared distance.
    pub(crate) distance: u32,
}

/// Colours that a thread takes at a time.
const PART: usize = 1024;

fn nearest(colours: &[Weighted], palette: &[Rgb]) -> Vec<Match> {
    let planes = Planes::new(palette);
    let mut matches = vec![Match::default(); colours.len()];
    let parts = matches.par_chunks_mut(PART).zip(colours.par_chunks(PART));
    parts.for_each(|(matches, colours)| {
        dispatch(
            #[inline(always)]
            || {
                for (m, w) in matches.iter_mut().zip(colours) {
                    *m = planes.nearest(w.colour);
                }
            },
        );
    });
    matches
}

/// A palette channel by channel, in numbers that processors compare many at a time. Squared
/// distances are below 2^18, so that they are exact.
#[derive(Debug)]
struct Planes {
    channels: [[f32; MOST + 1]; 3],
}

impl Planes {
    fn new(palette: &[Rgb]) -> Self {
        // Places beyond the palette are farther than any colour.
        let mut channels = [[1e4; MOST + 1]; 3];
        for (i, colour) in palette.iter().enumerate().take(MOST + 1) {
            for (channel, &c) in channels.iter_mut().zip(colour) {
                channel[i] = f32::from(c);
            }
        }
        Self { channels }
    }

    /// The first of the nearest.
    #[inline(always)]
    fn nearest(&self, colour: Rgb) -> Match {
        let [red, green, blue] = &self.channels;
        let [r, g, b] = colour.map(f32::from);
        let mut distances = [0f32; MOST + 1];
        for (i, distance) in distances.iter_mut().enumerate() {
            let (dr, dg, db) = (red[i] - r, green[i] - g, blue[i] - b);
            *distance = dr * dr + dg * dg + db * db;
        }
        let mut lanes = [f32::MAX; 8];
        for chunk in distances.as_chunks::<8>().0 {
            for (lane, &d) in lanes.iter_mut().zip(chunk) {
                *lane = if d < *lane { d } else { *lane };
            }
        }
        let least = lanes.into_iter().fold(f32::MAX, f32::min);
        let index = distances.iter().position(|&d| d == least).unwrap_or(0);
        Match { index: index as u8, distance: least as u32 }
    }
}

fn error(colours: &[Weighted], matches: &[Match]) -> f64 {
    let (mut sum, mut pixels) = (0u64, 0u64);
    for (w, m) in colours.iter().zip(matches) {
        sum += w.weight * u64::from(m.distance);
        pixels += w.weight;
    }
    sum as f64 / pixels.max(1) as f64
}

/// Adds a colour to sums of channels and weights.
fn add(sums: &mut [u64; 4], w: &Weighted) {
    for (s, c) in sums.iter_mut().zip(w.colour) {
        *s += w.weight * u64::from(c);
    }
    sums[3] += w.weight;
}

/// A picture's colours and what stands for each: a table with open addressing; and the palette, for others.
#[derive(Debug)]
pub(crate) struct Lookup {
    slots: Vec<(u32, Match)>,
    shift: u32,
    palette: Planes,
}

/// No colour: colours have 24 bits.
const EMPTY: u32 = u32::MAX;

impl Lookup {
    fn new(colours: &[Weighted], matches: &[Match], palette: &Palette) -> Self {
        // At most half full, so that runs of taken slots stay short.
        let bits = (2 * colours.len()).next_power_of_two().trailing_zeros().max(4);
        let slots = vec![(EMPTY, Match::default()); 1 << bits];
        let mut table = Self { slots, shift: 32 - bits, palette: Planes::new(&palette.colours) };
        for (w, &m) in colours.iter().zip(matches) {
            let slot = table.slot(key(w.colour));
            table.slots[slot] = (key(w.colour), m);
        }
        table
    }

    /// What stands for `colour`, quickly if it is one of the picture's; a mixed one it may be where edges are smooth.
    pub(crate) fn get(&self, colour: Rgb) -> Match {
        let (found, m) = self.slots[self.slot(key(colour))];
        if found != EMPTY {
            return m;
        }
        dispatch(
            #[inline(always)]
            || self.palette.nearest(colour),
        )
    }

    /// The slot that holds `key`, or the empty one where it belongs.
    fn slot(&self, key: u32) -> usize {
        // Fibonacci hashing (Knuth, TAOCP 3, 6.4): 2^32 / golden ratio.
        let mut slot = (key.wrapping_mul(0x9e37_79b9) >> self.shift) as usize;
        while self.slots[slot].0 != key && self.slots[slot].0 != EMPTY {
            slot = (slot + 1) & (self.slots.len() - 1);
        }
        slot
    }
}

fn key([r, g, b]: Rgb) -> u32 {
    u32::from_be_bytes([0, r, g, b])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};

    fn many(count: u32, seed: u64) -> Vec<Weighted> {
        let fills: Vec<Fill> = (0..count)
            .map(|i| {
                let [r, g, b, n, ..] = rank(seed, Purpose::Noise, i, 0).to_le_bytes();
                // A cloud along the grays, as pictures have it.
                let mix = |v: u8| ((u16::from(v) + 7 * u16::from(r)) / 8) as u8;
                Fill { colour: [r, mix(g), mix(b), 255], area: u32::from(n) + 1 }
            })
            .collect();
        distinct(&fills, 128)
    }

    fn mse(colours: &[Weighted], palette: &Palette) -> f64 {
        error(colours, &nearest(colours, palette.colours()))
    }

    #[test]
    fn few_colours_are_kept_exactly() {
        let colours = many(255, 1);
        let (palette, lookup) = Palette::next(&colours, None);
        for w in &colours {
            let m = lookup.get(w.colour);
            assert_eq!((palette.colours()[m.index as usize], m.distance), (w.colour, 0));
        }
    }

    #[test]
    fn equal_fills_add_up_and_transparent_ones_are_left_out() {
        let fill = |colour, area| Fill { colour, area };
        let fills = [
            fill([9, 9, 9, 255], 2),
            fill([1, 2, 3, 255], 5),
            fill([9, 9, 9, 128], 3),
            fill([7, 7, 7, 127], 50),
            fill([8, 8, 8, 255], 0),
        ];
        let expected =
            [Weighted { colour: [1, 2, 3], weight: 5 }, Weighted { colour: [9, 9, 9], weight: 5 }];
        assert_eq!(distinct(&fills, 128), expected);
    }

    #[test]
    fn many_colours_come_within_38_db() {
        let colours = many(5000, 2);
        let (palette, _) = Palette::next(&colours, None);
        assert_eq!(palette.colours().len(), MOST);
        let psnr = 10.0 * (255.0 * 255.0 * 3.0 / mse(&colours, &palette)).log10();
        assert!(psnr > 38.0, "{psnr} dB");
        assert_eq!(Palette::next(&colours, None).0, palette, "the same on every run");
    }

    #[test]
    fn a_palette_that_fits_is_kept_to_the_last_bit() {
        let colours = many(5000, 3);
        let (palette, _) = Palette::next(&colours, None);
        let mut moved = colours.clone();
        moved.iter_mut().for_each(|w| w.colour[2] = w.colour[2].saturating_add(1));
        assert_eq!(Palette::next(&moved, Some(&palette)).0, palette);
    }

    #[test]
    fn after_a_cut_the_palette_is_as_good_as_a_new_one() {
        let (before, _) = Palette::next(&many(5000, 4), None);
        let mut after = many(5000, 5);
        after.iter_mut().for_each(|w| w.colour = w.colour.map(|c| c / 3));
        after.sort_unstable_by_key(|w| w.colour);
        after.dedup_by_key(|w| w.colour);
        let (new, next) = (Palette::new(&after).0, Palette::next(&after, Some(&before)).0);
        let bound = mse(&after, &new).max(before.error * TOLERANCE + SLACK);
        assert!(mse(&after, &next) <= bound, "{} > {bound}", mse(&after, &next));
    }

    #[test]
    fn what_stands_for_a_colour_is_the_nearest_however_the_palette_came_to_be() {
        let first = Palette::next(&many(5000, 6), None).0;
        let mut shifted = many(5000, 6);
        shifted.iter_mut().for_each(|w| w.colour[0] /= 2);
        shifted.dedup_by_key(|w| w.colour);
        for (colours, last) in [
            (many(200, 7), None),
            (many(5000, 6), None),
            (many(5000, 6), Some(&first)),
            (shifted, Some(&first)),
        ] {
            let (palette, lookup) = Palette::next(&colours, last);
            // Of the picture, and of none.
            for w in colours.iter().chain(&many(50, 9)) {
                let far = |p: &Rgb| distance(*p, w.colour);
                let (index, best) =
                    palette.colours().iter().enumerate().min_by_key(|(_, p)| far(p)).expect("some");
                let expected = Match { index: index as u8, distance: far(best) };
                assert_eq!(lookup.get(w.colour), expected);
            }
        }
    }
}
