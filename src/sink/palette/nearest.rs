//! The nearest entry of a palette: by comparison with all entries, and by a table of a picture's colours.

use rayon::prelude::*;

use super::{MOST, Palette, Rgb, Weighted};
use crate::simd::dispatch;

/// The nearest entry of a palette.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Match {
    /// Its index in the palette.
    pub(crate) index: u8,
    /// Its squared distance.
    pub(crate) distance: u32,
}

/// Colours in one parallel piece of work.
const PART: usize = 1024;

/// The nearest entry of the palette for each colour.
pub(super) fn nearest(colours: &[Weighted], palette: &[Rgb]) -> Vec<Match> {
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

/// The channels of a palette as arrays of floats, for vector instructions. Squared distances are below 2^18 and thus
/// exact.
#[derive(Debug)]
struct Planes {
    channels: [[f32; MOST + 1]; 3],
}

impl Planes {
    fn new(palette: &[Rgb]) -> Self {
        // Unused entries are farther away than any colour.
        let mut channels = [[1e4; MOST + 1]; 3];
        for (i, colour) in palette.iter().enumerate().take(MOST + 1) {
            for (channel, &c) in channels.iter_mut().zip(colour) {
                channel[i] = f32::from(c);
            }
        }
        Self { channels }
    }

    /// The nearest entry; of equally near ones the first.
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

/// A hash table with open addressing from a picture's colours to their nearest entries; and the palette, for other
/// colours.
#[derive(Debug)]
pub(crate) struct Lookup {
    slots: Vec<(u32, Match)>,
    shift: u32,
    palette: Planes,
}

/// The key of an empty slot: colours have 24 bits.
const EMPTY: u32 = u32::MAX;

impl Lookup {
    pub(super) fn new(colours: &[Weighted], matches: &[Match], palette: &Palette) -> Self {
        // At most half full, so that probing is short.
        let bits = (2 * colours.len()).next_power_of_two().trailing_zeros().max(4);
        let slots = vec![(EMPTY, Match::default()); 1 << bits];
        let mut table = Self { slots, shift: 32 - bits, palette: Planes::new(&palette.colours) };
        for (w, &m) in colours.iter().zip(matches) {
            let slot = table.slot(key(w.colour));
            table.slots[slot] = (key(w.colour), m);
        }
        table
    }

    /// The nearest entry of `colour`. The picture's own colours are looked up; colours that are mixed where edges are
    /// smooth are compared with all entries.
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

    /// The slot that holds `key`, or the empty slot for it.
    fn slot(&self, key: u32) -> usize {
        // Fibonacci hashing (Knuth, TAOCP 3, 6.4): 2^32 / golden ratio.
        let mut slot = (key.wrapping_mul(0x9e37_79b9) >> self.shift) as usize;
        while self.slots[slot].0 != key && self.slots[slot].0 != EMPTY {
            slot = (slot + 1) & (self.slots.len() - 1);
        }
        slot
    }
}

/// The key of a colour in the table.
fn key([r, g, b]: Rgb) -> u32 {
    u32::from_be_bytes([0, r, g, b])
}
