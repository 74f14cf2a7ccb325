//! Lines on a picture, by coverage: a pixel that a line covers in part is mixed.

use crate::parallel::prelude::*;

use crate::frame::{Fill, Rgba};
use crate::geom::{Point, SUBPIXEL, Size};

/// Rows that are one piece of work.
const BAND: usize = 32;

/// A line between two points, round at its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stroke {
    pub(super) ends: (Point, Point),
    /// Its colour, and the opacity of what it runs along.
    pub(super) paint: Rgba,
    /// How much of it there is, of 255.
    pub(super) strength: u8,
    /// The mean colour of what it runs along.
    pub(super) ground: Rgba,
}

/// Draws `strokes`, `width` pixels wide, on `pixels` of `size`. Where several cover a pixel, the one that covers most of
/// it is drawn, the first of equals, so that nothing is mixed twice where they meet. With `hard` edges a pixel
/// is covered or not.
pub(super) fn draw(pixels: &mut [Rgba], size: Size, width: f64, strokes: &[Stroke], hard: bool) {
    let brush = Brush::new(width, hard);
    let row = size.width as usize;
    let mut bands: Vec<Vec<u32>> = vec![Vec::new(); (size.height as usize).div_ceil(BAND)];
    for (i, stroke) in (0u32..).zip(strokes) {
        let (a, b) = (place(stroke.ends.0)[1], place(stroke.ends.1)[1]);
        // Casts of negative numbers give 0.
        let first = (a.min(b) - brush.reach) as usize / BAND;
        let last = (a.max(b) + brush.reach) as usize / BAND;
        bands.iter_mut().take(last + 1).skip(first).for_each(|band| band.push(i));
    }
    let parts = pixels.par_chunks_mut(row * BAND).zip(bands.par_chunks(1)).enumerate();
    parts.for_each(|(number, (pixels, band))| {
        let mut covered = vec![(0u8, 0u32); pixels.len()];
        for &i in band.iter().flatten() {
            brush.cover(&mut covered, (number * BAND, row), i, &strokes[i as usize]);
        }
        for (pixel, &(share, i)) in pixels.iter_mut().zip(&covered).filter(|(_, c)| c.0 > 0) {
            *pixel = mixed(*pixel, strokes[i as usize].paint, share);
        }
    });
}

/// The colours of `strokes` where they cover all of a pixel, with their areas in pixels.
pub(super) fn fills(strokes: &[Stroke], width: f64) -> Vec<Fill> {
    let mut fills: Vec<Fill> = strokes
        .iter()
        .map(|stroke| {
            let [a, b] = [stroke.ends.0, stroke.ends.1].map(place);
            let area = (a[0] - b[0]).hypot(a[1] - b[1]) * width as f32;
            let colour = mixed(stroke.ground, stroke.paint, stroke.strength);
            Fill { colour, area: area as u32 + 1 }
        })
        .collect();
    fills.sort_unstable_by_key(|fill| fill.colour);
    fills.dedup_by(|next, kept| {
        let same = next.colour == kept.colour;
        if same {
            kept.area = kept.area.saturating_add(next.area);
        }
        same
    });
    fills
}

fn place(point: Point) -> [f32; 2] {
    [point.x, point.y].map(|v| v as f32 / SUBPIXEL as f32)
}

/// `share` of 255 of `paint` and the rest of `ground`, weighted by alpha.
pub(super) fn mixed(ground: Rgba, paint: Rgba, share: u8) -> Rgba {
    let (new, old) = (u32::from(share), 255 - u32::from(share));
    let (new, old) = (new * u32::from(paint[3]), old * u32::from(ground[3]));
    let all = new + old;
    if all == 0 {
        return [0; 4];
    }
    let channel = |c: usize| {
        let sum = new * u32::from(paint[c]) + old * u32::from(ground[c]);
        ((sum + all / 2) / all) as u8
    };
    [channel(0), channel(1), channel(2), ((all + 127) / 255) as u8]
}

/// The width of lines.
#[derive(Clone, Copy, Debug)]
struct Brush {
    /// Half the width, of one pixel at least.
    half: f32,
    /// How much of a line of one pixel is left.
    thin: f32,
    /// How far from its middle a line covers pixels.
    reach: f32,
    hard: bool,
}

impl Brush {
    fn new(width: f64, hard: bool) -> Self {
        let half = (width.max(1.0) / 2.0) as f32;
        let thin = if hard { 1.0 } else { width.min(1.0) as f32 };
        Self { half, thin, reach: half + 0.5, hard }
    }

    /// How much of a pixel is covered whose centre is so far away.
    fn share(&self, squared: f32) -> f32 {
        if squared >= self.reach * self.reach {
            return 0.0;
        }
        let inside = self.half - squared.sqrt();
        if self.hard {
            return f32::from(inside >= 0.0);
        }
        (inside + 0.5).clamp(0.0, 1.0) * self.thin
    }

    /// Notes in `covered`, whose first row has this number, the pixels that `stroke`, number `i`, covers.
    fn cover(
        &self,
        covered: &mut [(u8, u32)],
        (first, row): (usize, usize),
        i: u32,
        stroke: &Stroke,
    ) {
        let ([ax, ay], [bx, by]) = (place(stroke.ends.0), place(stroke.ends.1));
        let (dx, dy) = (bx - ax, by - ay);
        let per_length = 1.0 / (dx * dx + dy * dy).max(1e-9);
        for (number, pixels) in covered.chunks_exact_mut(row).enumerate() {
            let y = (first + number) as f32 + 0.5 - ay;
            let Some((left, right)) = self.columns((ax, y), (dx, dy), row) else { continue };
            for (x, pixel) in (left..).zip(&mut pixels[left..right]) {
                let x = x as f32 + 0.5 - ax;
                let along = ((x * dx + y * dy) * per_length).clamp(0.0, 1.0);
                let (x, y) = (x - along * dx, y - along * dy);
                let share = self.share(x * x + y * y) * f32::from(stroke.strength);
                // At most 255.
                let share = (share + 0.5) as u8;
                if share > pixel.0 {
                    *pixel = (share, i);
                }
            }
        }
    }

    /// The columns of a row that a line may cover; `y` is how far the row is below its start.
    fn columns(
        &self,
        (ax, y): (f32, f32),
        (dx, dy): (f32, f32),
        row: usize,
    ) -> Option<(usize, usize)> {
        let (mut from, mut to) = (0.0f32, 1.0f32);
        if dy.abs() > 1e-6 {
            let (one, other) = ((y - self.reach) / dy, (y + self.reach) / dy);
            (from, to) = (one.min(other).max(0.0), one.max(other).min(1.0));
        } else if y.abs() > self.reach {
            return None;
        }
        if from > to {
            return None;
        }
        let (one, other) = (ax + from * dx, ax + to * dx);
        // Casts of negative numbers give 0.
        let left = (one.min(other) - self.reach) as usize;
        let right = ((one.max(other) + self.reach).ceil() as usize).min(row);
        (left < right).then_some((left, right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Rgba = [255; 4];

    fn stroke(from: (f64, f64), to: (f64, f64)) -> Stroke {
        let point = |(x, y): (f64, f64)| Point::new((x * 256.0) as i32, (y * 256.0) as i32);
        let ends = (point(from), point(to));
        Stroke { ends, paint: WHITE, strength: 255, ground: [0, 0, 0, 255] }
    }

    fn drawn(strokes: &[Stroke], width: f64, hard: bool) -> Vec<Rgba> {
        let size = Size::new(60, 50);
        let mut pixels = vec![[0, 0, 0, 255]; size.pixels()];
        draw(&mut pixels, size, width, strokes, hard);
        pixels
    }

    #[test]
    fn a_line_covers_its_width_in_any_direction() {
        for width in [0.5, 1.0, 2.5, 6.0] {
            for (x, y) in [(40.0, 10.0), (40.0, 24.3), (10.0, 40.0), (31.7, 40.0)] {
                let line = stroke((10.3, 9.8), (x, y));
                let sum: f64 =
                    drawn(&[line], width, false).iter().map(|p| f64::from(p[0]) / 255.0).sum();
                let length = (x - 10.3f64).hypot(y - 9.8);
                // Half a disc at each end.
                let half = width.max(1.0) / 2.0;
                let area =
                    width.min(1.0) * (2.0 * half * length + std::f64::consts::PI * half * half);
                assert!(
                    (sum / area - 1.0).abs() < 0.12,
                    "{width} to ({x}, {y}): {sum}, not {area}"
                );
            }
        }
    }

    #[test]
    fn hard_lines_are_of_one_colour_and_have_no_gaps() {
        let pixels = drawn(&[stroke((5.0, 7.3), (50.0, 31.9))], 1.0, true);
        assert!(pixels.iter().all(|p| p[0] == 0 || p[0] == 255));
        for x in 6..50 {
            assert!((0..50).any(|y| pixels[y * 60 + x][0] == 255), "column {x}");
        }
    }

    #[test]
    fn lines_join_without_holes_and_are_not_mixed_twice() {
        let mut strokes = [stroke((10.0, 10.0), (30.0, 25.0)), stroke((30.0, 25.0), (12.0, 40.0))];
        strokes.iter_mut().for_each(|stroke| stroke.strength = 128);
        let pixels = drawn(&strokes, 5.0, false);
        assert!(pixels.iter().all(|p| p[0] <= 128));
        assert_eq!(pixels[25 * 60 + 30][0], 128, "at the joint");
    }

    #[test]
    fn what_is_drawn_on_glass_is_as_opaque_as_its_paint() {
        assert_eq!(mixed([0; 4], [9, 8, 7, 100], 255), [9, 8, 7, 100]);
        assert_eq!(mixed([9, 9, 9, 100], [50, 50, 50, 100], 0), [9, 9, 9, 100]);
        assert_eq!(mixed([0; 4], [200, 0, 0, 255], 51), [200, 0, 0, 51]);
        assert_eq!(mixed([0, 0, 0, 255], [255; 4], 128), [128, 128, 128, 255]);
    }
}
