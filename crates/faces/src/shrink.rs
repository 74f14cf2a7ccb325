//! The picture as the network takes it.

use crate::layers::Map;
use crate::net::STRIDES;

/// The longer side of the picture that the network gets.
const LONGER: usize = 640;

/// What shows through transparent pixels.
const GROUND: u32 = 128;

/// The picture reduced to at most [`LONGER`] pixels, as blue, green and red, with black at its right and bottom up to the
/// next multiple of the coarsest stride; and how many pixels one of its own is along each side.
pub(crate) fn shrink(pixels: &[[u8; 4]], width: usize, height: usize) -> (Map, [f32; 2]) {
    let longer = width.max(height).max(LONGER);
    let reduced = |side: usize| (side * LONGER).div_ceil(longer);
    let (columns, rows) = (reduced(width), reduced(height));
    let padded = |side: usize| side.next_multiple_of(STRIDES[2]);
    let mut map = Map::new(padded(columns), padded(rows), 3);
    let long = map.width;
    for (y, row) in map.values.chunks_exact_mut(3 * long).take(rows).enumerate() {
        let ys = y * height / rows..((y + 1) * height).div_ceil(rows);
        for (x, out) in row.as_chunks_mut::<3>().0.iter_mut().take(columns).enumerate() {
            let xs = x * width / columns..((x + 1) * width).div_ceil(columns);
            *out = mean(pixels, width, xs, ys.clone());
        }
    }
    (map, [width as f32 / columns as f32, height as f32 / rows as f32])
}

/// The mean of the pixels in a part of the picture: blue, green and red.
fn mean(
    pixels: &[[u8; 4]],
    width: usize,
    xs: std::ops::Range<usize>,
    ys: std::ops::Range<usize>,
) -> [f32; 3] {
    let count = (xs.len() * ys.len()) as f32;
    let mut sums = [0u32; 3];
    for y in ys {
        for [red, green, blue, alpha] in &pixels[y * width..][xs.clone()] {
            let over = |v: u8| match alpha {
                255 => u32::from(v),
                _ => {
                    (u32::from(v) * u32::from(*alpha) + GROUND * u32::from(255 - alpha) + 127) / 255
                }
            };
            let seen = [over(*blue), over(*green), over(*red)];
            for (sum, seen) in sums.iter_mut().zip(seen) {
                *sum += seen;
            }
        }
    }
    sums.map(|sum| sum as f32 / count)
}
