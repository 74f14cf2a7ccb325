//! A short memory of the picture, so that it changes as its source does: flat areas do not shimmer, and
//! grain does not show.

mod votes;

use rayon::prelude::*;

use super::PACK;
use crate::frame::{Fill, Frame, Rgba};
use crate::mesh::Mesh;
use crate::scan;
use votes::Votes;

/// Largest distance of a channel from the mean colour, in 8-bit steps at coherence 1. Measured on four
/// clips, in steps at the default coherence: 2 has four fifths of the gain in flicker of 4, and 8 has no
/// more, at a tenth more squared error (`docs/video.md`).
const LEEWAY: f64 = 8.0;

/// Larger triangles are asked in every second, fourth ... row, so that about as many pixels answer.
const PLENTY: u32 = 64;

/// Pixels from which a middle colour is taken at least.
const ENOUGH: usize = 3;

/// What was painted for the last frame less the frame itself, within -128..127; empty where there is
/// none.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    missed: Vec<[i8; 4]>,
}

impl Memory {
    /// Chooses the colours of `fills` so that the picture changes as its source does: each channel of a
    /// triangle takes the median, over its pixels (of large ones some rows', and at most every `rows`-th row's), of what was painted there plus
    /// the source's change since, as far as that lies within the leeway around the mean colour, which
    /// `fills` has. Of all colours within the leeway it is the one with the least flicker, the sum of
    /// |change of the output - change of the source|: grain, and what passes through a corner of the
    /// triangle, do not touch it. `coherence` 0 changes nothing.
    pub fn steady(
        &self,
        mesh: &Mesh,
        frame: &Frame,
        fills: &mut [Fill],
        coherence: f64,
        rows: u32,
    ) {
        let leeway = (LEEWAY * coherence).round() as u8;
        if leeway == 0 || self.missed.len() != frame.size().pixels() || !frame.is_opaque() {
            return;
        }
        let width = frame.size().width as usize;
        fills.par_chunks_mut(PACK).enumerate().for_each(|(pack, fills)| {
            let mut votes = Votes::default();
            for (i, fill) in fills.iter_mut().enumerate() {
                votes.clear();
                let passed_over = rows.max(fill.area / PLENTY).next_power_of_two() - 1;
                scan::spans(
                    mesh.triangle(pack * PACK + i),
                    0..frame.size().height,
                    |y, columns| {
                        if y & passed_over == 0 {
                            let at = y as usize * width + columns.start;
                            votes.add(&frame.pixels()[at..], &self.missed[at..], columns.len());
                        }
                    },
                );
                if votes.count() >= ENOUGH {
                    fill.colour = votes.median(fill.colour, leeway);
                }
            }
        });
    }

    /// Takes up a frame and what was painted for it, colours as they were found. Frames that are not
    /// opaque are not remembered.
    pub fn remember(&mut self, frame: &Frame, painted: &[Rgba]) {
        self.forget();
        if !frame.is_opaque() || painted.len() != frame.size().pixels() {
            return;
        }
        self.missed.resize(painted.len(), [0; 4]);
        let parts = self.missed.par_chunks_mut(PART).zip(painted.par_chunks(PART));
        parts.zip(frame.pixels().par_chunks(PART)).for_each(|((missed, painted), source)| {
            let (painted, source) = (painted.as_flattened(), source.as_flattened());
            let all = missed.as_flattened_mut().iter_mut().zip(painted).zip(source);
            all.for_each(|((missed, &painted), &source)| {
                *missed = signed(painted).saturating_sub(signed(source));
            });
        });
    }

    /// Forgets everything: a new shot begins.
    pub fn forget(&mut self) {
        self.missed.clear();
    }
}

/// Pixels that are worked on as one piece.
const PART: usize = 1 << 14;

/// 0..255 as -128..127: differences stay the same, and one instruction of the machine adds sixteen of
/// them without running over.
#[inline(always)]
fn signed(value: u8) -> i8 {
    (value ^ 0x80) as i8
}

/// What [`signed`] made signed.
#[inline(always)]
fn unsigned(value: i8) -> u8 {
    value as u8 ^ 0x80
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use crate::rasterise::{Painter, means};
    use crate::triangulate::triangulate;

    const SIZE: Size = Size::new(24, 16);

    /// Paints frames whose left part is of one grey and whose right part of another, on two triangles;
    /// returns the colours of the first.
    fn colours(steps: &[(u8, u8)], leeway: f64) -> Vec<u8> {
        let mesh = triangulate(SIZE, &[]).expect("corners");
        let mut memory = Memory::default();
        let paint = |&(left, right): &(u8, u8)| {
            let grey = |i: usize| if i % 24 < 18 { left } else { right };
            let pixels = (0..SIZE.pixels()).map(|i| [grey(i), grey(i), grey(i), 255]).collect();
            let frame = Frame::new(SIZE, pixels).expect("a small frame");
            let mut fills = means(&mesh, &frame);
            memory.steady(&mesh, &frame, &mut fills, leeway / LEEWAY, 1);
            let mut painted = vec![[0; 4]; SIZE.pixels()];
            crate::rasterise::fill(&mesh, &fills, &mut painted);
            memory.remember(&frame, &painted);
            fills[0].colour[0]
        };
        steps.iter().map(paint).collect()
    }

    #[test]
    fn what_passes_through_a_corner_is_not_seen() {
        let steps = [(100, 100), (100, 108), (100, 92), (100, 100)];
        assert_eq!(colours(&steps, 3.0), [100; 4]);
        assert_ne!(colours(&steps, 0.0), [100; 4], "the means do not change: this proves nothing");
    }

    #[test]
    fn what_changes_as_a_whole_is_followed_at_once() {
        assert_eq!(colours(&[(100, 100), (103, 103), (90, 90)], 3.0), [100, 103, 90]);
    }

    #[test]
    fn the_mean_is_never_further_than_the_leeway() {
        let seen = colours(&[(100, 100), (100, 220), (100, 220)], 3.0);
        let mean = colours(&[(100, 220)], 0.0)[0];
        assert!(mean > 106 && seen[1] == mean - 3 && seen[2] == mean - 3, "{seen:?}, mean {mean}");
    }

    #[test]
    fn lines_and_grades_are_not_remembered() {
        use crate::options::{Colour, Options};
        let outlined = Options { outline: Some(Colour([0, 0, 0, 255])), ..Options::default() };
        let grey = |level: u8| Frame::filled(SIZE, [level, level, level, 255]).expect("grey");
        let mesh = triangulate(SIZE, &[]).expect("corners");
        let mut painter = Painter::new(&outlined);
        for level in [100, 103] {
            let painting = painter.paint(&mesh, &grey(level), false, 1, Vec::new());
            assert_eq!(painting.fills[0].colour, [level, level, level, 255]);
        }
    }
}
