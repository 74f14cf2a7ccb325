//! Draws a row of a picture in the colours of a palette, compared with what the viewer shows already.

use super::THRESHOLD;
use crate::frame::Rgba;
use crate::sink::palette::{Lookup, Palette, distance, rgb};

/// Draws a row: updates the canvas and writes the `indices` for the file. Returns the range of changed pixels.
pub(super) fn draw_row(
    pixels: &[Rgba],
    canvas: &mut [Rgba],
    indices: &mut [u8],
    palette: &Palette,
    lookup: &Lookup,
) -> Option<(usize, usize)> {
    let transparent = palette.colours().len() as u8;
    indices.fill(transparent);
    let (mut first, mut end, mut x) = (usize::MAX, 0, 0);
    for run in pixels.chunk_by(|a, b| a == b) {
        let places = x..x + run.len();
        x = places.end;
        // Pixels that become transparent were cleared already.
        if run[0][3] < THRESHOLD {
            continue;
        }
        let colour = rgb(run[0]);
        let best = lookup.get(colour);
        let [r, g, b] = palette.colours()[best.index as usize];
        let best_colour = [r, g, b, 255];
        let mut start = places.start;
        for seen in canvas[places].chunk_by_mut(|a, b| a == b) {
            let here = start..start + seen.len();
            start = here.end;
            let before = seen[0];
            if before == best_colour {
                // Repeating the last colour compresses better than a change to the transparent index.
                if here.start > 0 && indices[here.start - 1] == best.index {
                    indices[here].fill(best.index);
                }
            } else if before[3] == 0 || distance(rgb(before), colour) > best.distance {
                first = first.min(here.start);
                end = here.end;
                seen.fill(best_colour);
                indices[here].fill(best.index);
            }
        }
    }
    (end > 0).then_some((first, end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};
    use crate::frame::Fill;
    use crate::sink::palette::{Match, distinct};

    /// As [`draw_row`], pixel by pixel.
    fn draw_slowly(
        pixels: &[Rgba],
        canvas: &mut [Rgba],
        indices: &mut [u8],
        palette: &Palette,
    ) -> Option<(usize, usize)> {
        indices.fill(palette.colours().len() as u8);
        let mut range = None;
        for (i, pixel) in pixels.iter().enumerate().filter(|(_, p)| p[3] >= THRESHOLD) {
            let far = |(i, &c): (usize, _)| (distance(c, rgb(*pixel)), i as u8);
            let found = palette.colours().iter().enumerate().map(far).min();
            let (distance_of, index) = found.expect("a palette is never empty");
            let best = Match { index, distance: distance_of };
            let [r, g, b] = palette.colours()[best.index as usize];
            if canvas[i] == [r, g, b, 255] {
                if i > 0 && indices[i - 1] == best.index {
                    indices[i] = best.index;
                }
            } else if canvas[i][3] == 0 || distance(rgb(canvas[i]), rgb(*pixel)) > best.distance {
                canvas[i] = [r, g, b, 255];
                indices[i] = best.index;
                range = Some((range.map_or(i, |(first, _)| first), i + 1));
            }
        }
        range
    }

    #[test]
    fn a_row_is_drawn_as_pixel_by_pixel() {
        // Few colours in short runs, some of them transparent, over what earlier rows have left.
        let colour = |row: u32, x: u32| {
            let at = (x * (1 + row % 3) / 5).wrapping_add(row % 7);
            let [shade, alpha, ..] = rank(3, Purpose::Noise, at, 0).to_le_bytes();
            [shade, shade / 2, 255 - shade, if alpha < 40 { 60 } else { 255 }]
        };
        let rows: Vec<Vec<Rgba>> =
            (0..60).map(|row| (0..97).map(|x| colour(row, x)).collect()).collect();
        let fills: Vec<_> =
            rows.concat().into_iter().step_by(3).map(|colour| Fill { colour, area: 1 }).collect();
        for known in [fills.len(), 12] {
            let colours = distinct(&fills[..known], THRESHOLD);
            let (palette, lookup) = Palette::next(&colours, None);
            let (mut canvas, mut indices) = (vec![[0; 4]; 97], vec![0; 97]);
            let (mut slow_canvas, mut slow_indices) = (canvas.clone(), indices.clone());
            for row in &rows {
                let range = draw_row(row, &mut canvas, &mut indices, &palette, &lookup);
                let slowly = draw_slowly(row, &mut slow_canvas, &mut slow_indices, &palette);
                assert_eq!((range, &canvas, &indices), (slowly, &slow_canvas, &slow_indices));
            }
        }
    }
}
