//! Colour regions by k-means, their boundaries and a few points inside them (paper, HRLP level one).
//!
//! Colours are clustered as cells of a coarse cube, not pixel by pixel: a picture has millions of pixels, but only a
//! few thousand occupied cells. A table of the cube then gives the label of each pixel.

use crate::parallel::prelude::*;

use crate::chance::{Purpose, rank};
use crate::feature::mask::Mask;
use crate::frame::{Frame, Rgba};
use crate::geom::Size;
use crate::simd::dispatch;

/// Bits of a channel in the colour cube: 32 levels a channel, 32768 cells.
const CUBE_BITS: u32 = 5;
const CUBE_CELLS: usize = 1 << (3 * CUBE_BITS);

/// Approximate number of pixels for the palette; of larger frames every n-th row is read.
const LEARNING_PIXELS: usize = 1 << 18;

/// The most rounds of Lloyd's algorithm: after about ten the palette moves by less than a cell.
const ROUNDS: usize = 12;

/// The label of pixels with an alpha below one half.
pub const TRANSPARENT: u8 = u8::MAX;

/// The colour regions of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    /// The frame's size.
    pub size: Size,
    /// For each pixel, row by row, the number of its cluster in `palette`, or [`TRANSPARENT`].
    pub labels: Vec<u8>,
    /// Mean colours of the clusters; red, green, blue, 0..255.
    pub palette: Vec<[f32; 3]>,
}

/// Divides `frame` into regions of `clusters` colours (fewer where it has fewer).
///
/// K-means (Lloyd) on the occupied cells of a 32x32x32 colour cube, each with its mean colour and
/// weighted by its pixels. It starts from `palette`, where one is given, else from the most common
/// colour and, one after the other, the cell with the largest weight x squared distance to those there
/// are (k-means++, Arthur and Vassilvitskii 2007, without its chance). Ties go to the cell that comes
/// first in the cube.
pub fn segment(frame: &Frame, clusters: usize, palette: Option<&[[f32; 3]]>) -> Regions {
    let cells = occupied_cells(frame);
    let mut palette = match palette {
        Some(palette) if !palette.is_empty() => palette.to_vec(),
        _ => spread_palette(&cells, clusters),
    };
    for _ in 0..ROUNDS {
        if !improve(&mut palette, &cells) {
            break;
        }
    }
    let labels = label_pixels(frame, &label_cube(&palette));
    Regions { size: frame.size(), labels, palette }
}

/// A cell of the colour cube that pixels fall in.
#[derive(Clone, Copy, Debug)]
struct Cell {
    mean: [f32; 3],
    weight: f32,
}

fn cube_index([r, g, b, _]: Rgba) -> usize {
    const DROP: u32 = 8 - CUBE_BITS;
    (usize::from(r >> DROP) << (2 * CUBE_BITS))
        | (usize::from(g >> DROP) << CUBE_BITS)
        | usize::from(b >> DROP)
}

fn occupied_cells(frame: &Frame) -> Vec<Cell> {
    let every = (frame.size().pixels() / LEARNING_PIXELS).max(1) as u32;
    // Count and channel sums: 32 bits hold those of 2^24 pixels, many more than are read.
    let mut sums = vec![[0u32; 4]; CUBE_CELLS];
    for y in (0..frame.size().height).step_by(every as usize) {
        for &pixel in frame.row(y).iter().filter(|pixel| pixel[3] >= 128) {
            let sum = &mut sums[cube_index(pixel)];
            sum[0] += 1;
            sum[1] += u32::from(pixel[0]);
            sum[2] += u32::from(pixel[1]);
            sum[3] += u32::from(pixel[2]);
        }
    }
    let occupied = sums.iter().filter(|sum| sum[0] > 0);
    occupied
        .map(|&[n, r, g, b]| Cell {
            mean: [r, g, b].map(|sum| (f64::from(sum) / f64::from(n)) as f32),
            weight: n as f32,
        })
        .collect()
}

#[inline(always)]
fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}

fn spread_palette(cells: &[Cell], clusters: usize) -> Vec<[f32; 3]> {
    let mut palette = Vec::with_capacity(clusters);
    let mut gap = vec![f32::MAX; cells.len()];
    let mut priority: Vec<f32> = cells.iter().map(|cell| cell.weight).collect();
    while palette.len() < clusters {
        let first_best =
            (0..cells.len()).reduce(|a, b| if priority[b] > priority[a] { b } else { a });
        let Some(best) = first_best.filter(|&best| priority[best] > 0.0) else { break };
        palette.push(cells[best].mean);
        for (i, cell) in cells.iter().enumerate() {
            gap[i] = gap[i].min(distance(cell.mean, cells[best].mean));
            priority[i] = gap[i] * cell.weight;
        }
    }
    palette
}

/// Colours that are compared with the palette at once.
const LANES: usize = 32;

/// For each of `count` colours, which `colour` returns, the index of the nearest entry of a palette of at most 256;
/// of equally near ones the first.
fn nearest(palette: &[[f32; 3]], count: usize, colour: impl Fn(usize) -> [f32; 3]) -> Vec<u8> {
    let mut labels = vec![0; count];
    dispatch(
        #[inline(always)]
        || {
            for (labels, first) in labels.chunks_mut(LANES).zip((0..).step_by(LANES)) {
                let mut channels = [[0.0; LANES]; 3];
                for (lane, i) in (first..first + labels.len()).enumerate() {
                    let colour = colour(i);
                    (0..3).for_each(|c| channels[c][lane] = colour[c]);
                }
                let found = nearest_of_lanes(palette, &channels);
                labels.copy_from_slice(&found[..labels.len()]);
            }
        },
    );
    labels
}

/// The same for colours given as reds, greens and blues.
#[inline(always)]
fn nearest_of_lanes(
    palette: &[[f32; 3]],
    [reds, greens, blues]: &[[f32; LANES]; 3],
) -> [u8; LANES] {
    let (mut least, mut best) = ([f32::MAX; LANES], [0u32; LANES]);
    for (number, &entry) in (0..).zip(palette) {
        for i in 0..LANES {
            let d = distance(entry, [reds[i], greens[i], blues[i]]);
            // No branch, so that the loop is vectorised.
            let is_nearer = d < least[i];
            least[i] = if is_nearer { d } else { least[i] };
            best[i] = if is_nearer { number } else { best[i] };
        }
    }
    best.map(|number| number as u8)
}

/// One of Lloyd's rounds. A cluster without cells stays where it is. Whether anything moved by more
/// than a quarter of a level.
fn improve(palette: &mut [[f32; 3]], cells: &[Cell]) -> bool {
    let mut sums = vec![[0f64; 4]; palette.len()];
    for (cell, label) in cells.iter().zip(nearest(palette, cells.len(), |i| cells[i].mean)) {
        let sum = &mut sums[usize::from(label)];
        let weight = f64::from(cell.weight);
        for (sum, mean) in sum.iter_mut().zip(cell.mean) {
            *sum += weight * f64::from(mean);
        }
        sum[3] += weight;
    }
    let mut moved = false;
    for (entry, sum) in palette.iter_mut().zip(sums).filter(|(_, sum)| sum[3] > 0.0) {
        let mean = [0, 1, 2].map(|c| (sum[c] / sum[3]) as f32);
        moved |= distance(*entry, mean) > 1.0 / 16.0;
        *entry = mean;
    }
    moved
}

/// The nearest palette colour of each cell's middle.
fn label_cube(palette: &[[f32; 3]]) -> Vec<u8> {
    let level = |index: usize, shift: u32| {
        let step = (256 >> CUBE_BITS) as f32;
        ((index >> shift) & ((1 << CUBE_BITS) - 1)) as f32 * step + (step - 1.0) / 2.0
    };
    let middle = |i: usize| [level(i, 2 * CUBE_BITS), level(i, CUBE_BITS), level(i, 0)];
    nearest(palette, CUBE_CELLS, middle)
}

fn label_pixels(frame: &Frame, cube: &[u8]) -> Vec<u8> {
    let mut labels = vec![0; frame.size().pixels()];
    let opaque = frame.is_opaque();
    labels.par_chunks_mut(1 << 16).zip(frame.pixels().par_chunks(1 << 16)).for_each(
        |(labels, pixels)| {
            for (label, &pixel) in labels.iter_mut().zip(pixels) {
                let seen = opaque || pixel[3] >= 128;
                *label = if seen { cube[cube_index(pixel)] } else { TRANSPARENT };
            }
        },
    );
    labels
}

/// The choice of candidates among the points of regions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picks {
    /// The seed of random numbers.
    pub seed: u64,
    /// On average every `interval`-th boundary pixel is taken, at random: counting along a contour would take other
    /// pixels in every frame.
    pub interval: u32,
    /// The share of the pixels inside a region that is taken, 0..1.
    pub interior: f64,
}

/// Boundary and interior points of `regions`: a boundary pixel is one whose right or lower neighbour
/// has another label. Transparent regions have no interior points.
pub fn pick_points(regions: &Regions, picks: Picks) -> Mask {
    let mut mask = Mask::new(regions.size);
    let width = regions.size.width as usize;
    let boundary_below = share_of_ranks(1.0 / f64::from(picks.interval));
    let interior_below = share_of_ranks(picks.interior);
    let stride = mask.stride();
    mask.words_mut().par_chunks_mut(stride).enumerate().for_each(|(y, words)| {
        let row = &regions.labels[y * width..][..width];
        // The last row is its own lower neighbour: no boundary.
        let below = regions.labels.get((y + 1) * width..(y + 2) * width).unwrap_or(row);
        dispatch(
            #[inline(always)]
            || {
                let limit = |x: usize| {
                    let label = row[x];
                    if label != row[(x + 1).min(width - 1)] || label != below[x] {
                        boundary_below
                    } else if label != TRANSPARENT {
                        interior_below
                    } else {
                        0
                    }
                };
                draw(picks.seed, y as u32, width, words, limit);
            },
        );
    });
    mask
}

/// Chooses pixels of row `y` at random, each with the probability that `limit` gives it, 64 for a word.
#[inline(always)]
fn draw(seed: u64, y: u32, width: usize, words: &mut [u64], limit: impl Fn(usize) -> u64) {
    for (word, first) in words.iter_mut().zip((0..width).step_by(64)) {
        let mut limits = [0; 64];
        for (limits, x) in limits.iter_mut().zip(first..width) {
            *limits = limit(x);
        }
        let mut taken = [false; 64];
        for (i, taken) in taken.iter_mut().enumerate() {
            *taken = rank(seed, Purpose::Interior, (first + i) as u32, y) < limits[i];
        }
        *word = taken.iter().enumerate().fold(0, |word, (i, &taken)| word | u64::from(taken) << i);
    }
}

/// The rank below which this share of all ranks lies.
fn share_of_ranks(share: f64) -> u64 {
    // The cast saturates: a share of 1 takes every rank but the highest.
    (share * u64::MAX as f64) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As [`nearest`], of one colour.
    fn nearest_alone(palette: &[[f32; 3]], colour: [f32; 3]) -> usize {
        let mut best = (f32::MAX, 0);
        for (i, &entry) in palette.iter().enumerate() {
            let d = distance(entry, colour);
            if d < best.0 {
                best = (d, i);
            }
        }
        best.1
    }

    fn two_halves(size: Size) -> Frame {
        let pixel = |x| if x < size.width / 2 { [200, 30, 30, 255] } else { [20, 40, 180, 255] };
        let pixels = (0..size.height).flat_map(|_| (0..size.width).map(pixel));
        Frame::new(size, pixels.collect()).expect("a small frame")
    }

    #[test]
    fn two_colours_are_two_regions_with_one_boundary() {
        let size = Size::new(20, 6);
        let regions = segment(&two_halves(size), 8, None);
        assert_eq!(regions.palette, [[20.0, 40.0, 180.0], [200.0, 30.0, 30.0]]);
        let mask = pick_points(&regions, Picks { seed: 1, interval: 1, interior: 0.0 });
        let expected: Vec<_> = (0..6).map(|y| (9, y)).collect();
        assert_eq!(mask.iter().collect::<Vec<_>>(), expected);
    }

    #[test]
    fn side_by_side_or_alone_the_same_colours_are_nearest() {
        let colour = |i: u32, purpose| rank(3, purpose, i, 0).to_le_bytes().map(f32::from);
        let three = |c: [f32; 8]| [c[0], c[1], c[2]];
        // A colour that comes twice is the first one's.
        let mut palette: Vec<_> = (0..16).map(|i| three(colour(i, Purpose::Noise))).collect();
        palette[9] = palette[4];
        let colours = (0..1000).map(|i| three(colour(i, Purpose::Keep)));
        let colours: Vec<_> = colours.chain(palette.iter().copied()).collect();
        let alone: Vec<_> = colours.iter().map(|&c| nearest_alone(&palette, c) as u8).collect();
        assert_eq!(nearest(&palette, colours.len(), |i| colours[i]), alone);
        assert_eq!(alone[1009], 4);
    }

    #[test]
    fn pixels_are_picked_as_each_one_alone() {
        for size in [Size::new(1, 1), Size::new(64, 3), Size::new(131, 40)] {
            let throw = |i: usize| rank(9, Purpose::Noise, i as u32, 0);
            let labels = (0..size.pixels()).map(|i| {
                if throw(i / 5) % 4 == 0 { TRANSPARENT } else { (throw(i / 7) % 3) as u8 }
            });
            let regions = Regions { size, labels: labels.collect(), palette: vec![[0.0; 3]; 3] };
            let picks = Picks { seed: 5, interval: 3, interior: 0.1 };
            let label = |x: u32, y: u32| {
                regions.labels
                    [(y.min(size.height - 1) * size.width + x.min(size.width - 1)) as usize]
            };
            let is_picked = |&(x, y): &(u32, u32)| {
                let here = label(x, y);
                let boundary = here != label(x + 1, y) || here != label(x, y + 1);
                let share = if boundary { 1.0 / 3.0 } else { 0.1 };
                (boundary || here != TRANSPARENT)
                    && rank(5, Purpose::Interior, x, y) < share_of_ranks(share)
            };
            let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
            let alone: Vec<_> = pixels.filter(is_picked).collect();
            assert_eq!(pick_points(&regions, picks).iter().collect::<Vec<_>>(), alone);
        }
    }

    #[test]
    fn larger_regions_have_more_interior_points() {
        let size = Size::new(200, 200);
        let regions = segment(&Frame::filled(size, [9, 9, 9, 255]).expect("grey"), 4, None);
        let mask = pick_points(&regions, Picks { seed: 3, interval: 2, interior: 0.01 });
        // Binomial: mean 400, standard deviation 20.
        assert!((320..480).contains(&mask.len()), "{}", mask.len());
    }

    #[test]
    fn transparent_pixels_are_a_region_without_interior() {
        let size = Size::new(16, 16);
        let frame = Frame::filled(size, [255, 255, 255, 0]).expect("glass");
        let regions = segment(&frame, 4, None);
        assert!(regions.palette.is_empty());
        assert!(regions.labels.iter().all(|&l| l == TRANSPARENT));
        assert!(pick_points(&regions, Picks { seed: 0, interval: 1, interior: 1.0 }).is_empty());
    }

    #[test]
    fn a_palette_that_fits_is_kept() {
        let frame = two_halves(Size::new(20, 6));
        let first = segment(&frame, 2, None);
        assert_eq!(segment(&frame, 2, Some(&first.palette)), first);
    }

    /// k-means on these four clouds of known centres: the optimum is the clouds' own means.
    #[test]
    fn clouds_are_told_apart() {
        let centres = [[40u8, 40, 40], [200, 60, 60], [60, 200, 90], [220, 220, 230]];
        let size = Size::new(64, 64);
        let pixel = |i: usize| {
            let noise = rank(5, Purpose::Noise, i as u32, 0).to_le_bytes();
            let [r, g, b] = [0, 1, 2].map(|c| centres[i % 4][c] + noise[c] % 16);
            [r, g, b, 255]
        };
        let frame = Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("clouds");
        let regions = segment(&frame, 4, None);
        for centre in centres {
            let middle = centre.map(|c| f32::from(c) + 7.5);
            let nearest = &regions.palette[nearest_alone(&regions.palette, middle)];
            assert!(distance(*nearest, middle) < 1.0, "{centre:?} {:?}", regions.palette);
        }
    }
}
