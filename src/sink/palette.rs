//! Colour quantization: the palette of a GIF, from the colours and areas of a picture's triangles, not from pixels.
//!
//! A new palette is found by splitting the set of colours where that lowers the squared error most (X. Wu, "Color
//! quantization by dynamic programming and principal analysis", 1992, along the axes), followed by rounds of k-means
//! (Lloyd). The last palette is kept while its error is small, so that colours do not flicker.

mod divide;
mod nearest;

use crate::frame::{Fill, Rgba};
use divide::divide;
use nearest::nearest;
pub(crate) use nearest::{Lookup, Match};

/// The most colours of a palette. The last of a GIF's 256 indices means "transparent".
pub(crate) const MOST: usize = 255;

/// Rounds of k-means after splitting, and when starting from the last palette. Measured on 5000 colours: the third
/// round after a split gains 0.1 dB, the fifth nothing (`cargo test rounds_of_k_means -- --ignored --nocapture`).
const ROUNDS: usize = 3;
const WARM_ROUNDS: usize = 2;

/// A palette is kept while its mean squared error is at most `TOLERANCE` times that of the last new one, plus `SLACK`.
/// The factor 2 is a loss of 3 dB of more than 40. With a smaller one, palettes would be replaced for any change of
/// colours, and each new palette makes the picture flicker.
const TOLERANCE: f64 = 2.0;
const SLACK: f64 = 1.0;

/// A colour without alpha.
pub(crate) type Rgb = [u8; 3];

/// A colour and the number of pixels that have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Weighted {
    pub(crate) colour: Rgb,
    pub(crate) weight: u64,
}

/// The distinct colours of fills with an alpha of at least `threshold`, in ascending order.
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
    /// Mean squared error for each pixel, summed over the channels, on the picture that the last new palette was made
    /// for.
    error: f64,
}

impl Palette {
    /// The palette for a picture of `colours`: the `last` one while its error is small, else a better one. Returns it
    /// with a table of the nearest entry of each colour.
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
            // The picture is transparent. A palette must have a colour.
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

    /// The palette `start` after `rounds` of k-means, and the nearest entries of its colours. `matches` are the
    /// nearest entries of `start`. An entry that is nearest to no colour stays as it is.
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

/// The mean squared error for each pixel.
fn error(colours: &[Weighted], matches: &[Match]) -> f64 {
    let (mut sum, mut pixels) = (0u64, 0u64);
    for (w, m) in colours.iter().zip(matches) {
        sum += w.weight * u64::from(m.distance);
        pixels += w.weight;
    }
    sum as f64 / pixels.max(1) as f64
}

/// Adds a colour to weighted sums of the channels and to the sum of the weights.
fn add(sums: &mut [u64; 4], w: &Weighted) {
    for (s, c) in sums.iter_mut().zip(w.colour) {
        *s += w.weight * u64::from(c);
    }
    sums[3] += w.weight;
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
    #[ignore = "prints the gain of rounds, for the comment of ROUNDS"]
    fn rounds_of_k_means() {
        let colours = many(5000, 2);
        let start = divide(&colours);
        for rounds in 0..6 {
            let matches = nearest(&colours, &start);
            let error = Palette::refined(&colours, start.clone(), matches, rounds).0.error;
            println!("{rounds} rounds: {:.2} dB", 10.0 * (255.0 * 255.0 * 3.0 / error).log10());
        }
    }

    #[test]
    fn a_palette_with_a_small_error_is_kept() {
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
    fn lookups_give_the_nearest_entry_however_the_palette_was_made() {
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
            // Colours of the picture, and others.
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
