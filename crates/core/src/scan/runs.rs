//! Fills many triangles at once: marks the first pixel of each of their rows, then extends the marks along each row
//! of the picture.

use super::{rows, spans};
use crate::frame::Rgba;
use crate::geom::Point;

/// A pixel at which no triangle begins.
const UNMARKED: Rgba = [0; 4];

/// A mark for alpha 0, which must not be [`UNMARKED`], until the pixel becomes transparent black.
const CLEAR: Rgba = [1, 0, 0, 0];

/// Rows in one parallel piece of work.
pub(crate) const BAND: u32 = 64;

/// Triangles, each with its colour or another value, by the bands of [`BAND`] rows that they overlap.
#[derive(Debug, Default)]
pub(crate) struct Bands<T = Rgba>(Vec<Vec<([Point; 3], T)>>);

impl<T: Copy> Bands<T> {
    /// Sorts the `triangles` of a picture of `height` rows into bands; reuses the memory.
    pub(crate) fn sort(&mut self, height: u32, triangles: impl Iterator<Item = ([Point; 3], T)>) {
        self.0.iter_mut().for_each(Vec::clear);
        self.0.resize_with(height.div_ceil(BAND) as usize, Vec::new);
        for (triangle, colour) in triangles {
            let rows = rows(triangle);
            if rows.is_empty() {
                continue;
            }
            for band in rows.start / BAND..=(rows.end - 1) / BAND {
                self.0[band as usize].push((triangle, colour));
            }
        }
    }

    /// The triangles of the `number`-th band.
    pub(crate) fn of(&self, number: usize) -> &[([Point; 3], T)] {
        &self.0[number]
    }
}

impl Bands {
    /// Fills `pixels`, the rows of the `number`-th band, each `width` long: see [`fill`].
    pub(crate) fn fill(&self, number: usize, width: usize, pixels: &mut [Rgba]) {
        fill(self.0[number].iter().copied(), number as u32 * BAND, width, pixels);
    }
}

/// Fills `pixels`, whole rows of `width` from row `first` on, with the colours of `triangles`, which
/// cover them without gap or overlap. What has alpha 0 becomes transparent black.
///
/// The rows of triangles are short and many: writing one pixel for each and extending all of them in one pass is
/// faster than filling them one by one.
fn fill(
    triangles: impl Iterator<Item = ([Point; 3], Rgba)>,
    first: u32,
    width: usize,
    pixels: &mut [Rgba],
) {
    pixels.fill(UNMARKED);
    let rows = first..first + (pixels.len() / width) as u32;
    let mut clear = false;
    for (triangle, colour) in triangles {
        let mark = if colour[3] == 0 { CLEAR } else { colour };
        clear |= mark == CLEAR;
        spans(triangle, rows.clone(), |y, columns| {
            pixels[(y - first) as usize * width + columns.start] = mark;
        });
    }
    for rows in pixels.chunks_mut(TOGETHER * width) {
        run_along(rows, width);
    }
    if clear {
        pixels.iter_mut().filter(|pixel| **pixel == CLEAR).for_each(|pixel| *pixel = [0; 4]);
    }
}

/// Rows that are extended at once, so that none waits for the pixel before.
const TOGETHER: usize = 4;

/// Gives each unmarked pixel of up to [`TOGETHER`] rows the colour of the marked one before it.
fn run_along(rows: &mut [Rgba], width: usize) {
    if rows.len() == TOGETHER * width {
        let (a, rest) = rows.split_at_mut(width);
        let (b, rest) = rest.split_at_mut(width);
        let (c, d) = rest.split_at_mut(width);
        let mut colours = [u32::from_le_bytes(UNMARKED); TOGETHER];
        for (((a, b), c), d) in a.iter_mut().zip(b).zip(c).zip(d) {
            for (colour, pixel) in colours.iter_mut().zip([a, b, c, d]) {
                go_on(colour, pixel);
            }
        }
        return;
    }
    for row in rows.chunks_mut(width) {
        let mut colour = u32::from_le_bytes(UNMARKED);
        row.iter_mut().for_each(|pixel| go_on(&mut colour, pixel));
    }
}

#[inline(always)]
fn go_on(colour: &mut u32, pixel: &mut Rgba) {
    let mark = u32::from_le_bytes(*pixel);
    *colour = if mark == u32::from_le_bytes(UNMARKED) { *colour } else { mark };
    *pixel = colour.to_le_bytes();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_has_the_colour_of_its_triangle() {
        let p = |x, y| Point::new(x * 256, y * 256);
        let square = [
            ([p(0, 0), p(6, 0), p(0, 6)], [9, 8, 7, 255]),
            ([p(6, 0), p(6, 6), p(0, 6)], [200, 100, 50, 0]),
        ];
        let mut slow = vec![[3; 4]; 36];
        for (triangle, colour) in square {
            let colour = if colour[3] == 0 { [0; 4] } else { colour };
            spans(triangle, 0..6, |y, columns| slow[y as usize * 6..][columns].fill(colour));
        }
        let mut pixels = vec![[77; 4]; 36];
        fill(square.into_iter(), 0, 6, &mut pixels);
        assert_eq!(pixels, slow);
        let mut lower = vec![[77; 4]; 18];
        fill(square.into_iter(), 3, 6, &mut lower);
        assert_eq!(lower, slow[18..]);
    }
}
