//! The pixels of the window, and letters on them.

use crate::program::letters::Letters;

/// A rectangle of a canvas, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Area {
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Area {
    /// Whether a place in pixels lies in it.
    pub(super) fn contains(&self, (x, y): (f64, f64)) -> bool {
        let inside =
            |v: f64, start: usize, length: usize| v >= start as f64 && v < (start + length) as f64;
        inside(x, self.x, self.width) && inside(y, self.y, self.height)
    }
}

/// Pixels as the window takes them: `0RGB`, row by row.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) pixels: Vec<u32>,
}

impl Canvas {
    /// A black one.
    pub(super) fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![0; width * height] }
    }

    /// All of it.
    #[cfg(test)]
    pub(super) fn area(&self) -> Area {
        Area { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// The columns `columns` of row `y`, as far as they are there.
    fn row(&mut self, y: usize, columns: std::ops::Range<usize>) -> &mut [u32] {
        let columns = columns.start.min(self.width)..columns.end.min(self.width);
        let start = y * self.width;
        self.pixels.get_mut(start + columns.start..start + columns.end).unwrap_or_default()
    }

    /// Fills `area` with `colour`.
    pub(super) fn fill(&mut self, area: Area, colour: u32) {
        for y in area.y..(area.y + area.height).min(self.height) {
            self.row(y, area.x..area.x + area.width).fill(colour);
        }
    }

    /// Darkens `area` to a quarter, so that letters can be read on it.
    pub(super) fn darken(&mut self, area: Area) {
        for y in area.y..(area.y + area.height).min(self.height) {
            for pixel in self.row(y, area.x..area.x + area.width) {
                *pixel = *pixel >> 2 & 0x3f_3f3f;
            }
        }
    }

    /// Writes `text` in `colour` with its top left corner at `(x, y)`. What does not fit is cut off.
    pub(super) fn write(
        &mut self,
        text: &str,
        (x, y): (usize, usize),
        letters: &Letters,
        colour: u32,
    ) {
        letters.draw(text, (x as u32, y as u32), |(x, y), coverage| {
            let weight = (coverage.clamp(0.0, 1.0) * 256.0).round() as u32;
            let x = x as usize;
            let pixels = self.row(y as usize, x..x + 1).iter_mut();
            pixels.for_each(|pixel| *pixel = mixed(*pixel, colour, weight));
        });
    }

    /// Draws a line between two places in pixels, half `colour` and half what is there, as far as it lies
    /// in `area`.
    pub(super) fn line(&mut self, from: (f64, f64), to: (f64, f64), area: Area, colour: u32) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        // One pixel for every column or row, whichever there are more of.
        let steps = dx.abs().max(dy.abs()).ceil().max(1.0);
        for i in 0..=steps as u32 {
            let t = f64::from(i) / steps;
            self.dot((from.0 + t * dx, from.1 + t * dy), area, |pixel| halved(pixel, colour));
        }
    }

    /// Changes the pixel at a place, if it lies in `area`.
    fn dot(&mut self, (x, y): (f64, f64), area: Area, change: impl Fn(u32) -> u32) {
        if area.contains((x, y)) {
            let (x, y) = (x as usize, y as usize);
            self.row(y, x..x + 1).iter_mut().for_each(|pixel| *pixel = change(*pixel));
        }
    }

    /// A square of `2 * reach + 1` pixels around a place, as far as it lies in `area`.
    pub(super) fn square(&mut self, (x, y): (f64, f64), reach: i32, area: Area, colour: u32) {
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                self.dot((x + f64::from(dx), y + f64::from(dy)), area, |_| colour);
            }
        }
    }
}

/// The middle between two colours.
fn halved(a: u32, b: u32) -> u32 {
    (a >> 1 & 0x7f_7f7f) + (b >> 1 & 0x7f_7f7f)
}

/// `a` and `b` mixed, with `weight` of 256 parts for `b`. Two channels at a time.
pub(super) fn mixed(a: u32, b: u32, weight: u32) -> u32 {
    let both = |mask: u32| ((a & mask) * (256 - weight) + (b & mask) * weight) >> 8 & mask;
    both(0xff_00ff) | both(0x00_ff00)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_as_large_as_they_say() {
        for height in [14, 40] {
            let letters = Letters::new(height);
            let mut canvas = Canvas::new(100, 60);
            canvas.write("M", (10, 5), &letters, 0xff_ffff);
            let lit: Vec<_> = (0..canvas.pixels.len())
                .filter(|&i| canvas.pixels[i] != 0)
                .map(|i| (i % 100, i / 100))
                .collect();
            assert!(lit.len() > 10, "a letter is seen");
            let (width, height) = (letters.width("M") as usize, height as usize);
            assert!(
                lit.iter()
                    .all(|&(x, y)| (10..10 + width).contains(&x) && (5..5 + height).contains(&y))
            );
        }
    }

    #[test]
    fn what_does_not_fit_is_cut_off() {
        let mut canvas = Canvas::new(20, 10);
        canvas.write("too long for it", (15, 4), &Letters::new(20), 0xff_ffff);
        canvas.fill(Area { x: 18, y: 8, width: 9, height: 9 }, 7);
        canvas.darken(Area { x: 19, y: 0, width: 50, height: 50 });
        assert_eq!(canvas.pixels.len(), 200);
        assert_eq!(canvas.pixels[9 * 20 + 18], 7);
    }

    #[test]
    fn lines_stay_in_their_area() {
        let mut canvas = Canvas::new(40, 30);
        let area = Area { x: 10, y: 10, width: 20, height: 10 };
        canvas.line((-50.0, 15.0), (90.0, 15.0), area, 0x12_1212);
        canvas.square((10.0, 10.0), 2, area, 9);
        for (i, &pixel) in canvas.pixels.iter().enumerate() {
            let (x, y) = (i % 40, i / 40);
            assert!(pixel == 0 || (10..30).contains(&x) && (10..20).contains(&y), "({x}, {y})");
        }
        assert_eq!(canvas.pixels.iter().filter(|&&p| p == 9).count(), 9);
        assert_eq!(canvas.pixels.iter().filter(|&&p| p == 0x09_0909).count(), 20);
    }
}
