//! The rounds of SLIC: k-means in which a centre only looks at the pixels near it (Achanta et al.,
//! section 3.1).

use crate::parallel::prelude::*;

use super::Slic;
use crate::feature::lab::{Lab, STEPS};
use crate::geom::Size;
use crate::plane::Plane;

/// Rows that one task works through.
const BAND: usize = 16;

/// The centre of a superpixel: L*, a*, b* in steps, and its place in pixels.
#[derive(Clone, Copy, Debug)]
struct Centre {
    lab: [f32; 3],
    x: f32,
    y: f32,
}

/// Sums over the pixels of a superpixel: L*, a*, b* in steps, x, y, and how many.
type Sums = [i64; 6];

/// The superpixels so far, and what they are found by.
pub(super) struct Search<'a> {
    size: Size,
    lab: &'a Lab,
    /// Side of the square that a superpixel would fill by itself.
    pub(super) step: f32,
    /// Squared steps of colour that count as much as a squared pixel of distance.
    nearness: f32,
    centres: Vec<Centre>,
    /// The superpixel of every pixel.
    pub(super) labels: Plane<u32>,
}

impl<'a> Search<'a> {
    /// Centres on a regular grid, each moved to the place of lowest gradient among its neighbours.
    pub(super) fn new(size: Size, lab: &'a Lab, slic: &Slic) -> Self {
        let step = (size.pixels() as f32 / slic.count as f32).sqrt().max(4.0);
        let cells = |side: u32| ((side as f32 / step).round() as u32).max(1);
        let (columns, rows) = (cells(size.width), cells(size.height));
        let mut labels = Plane::filled(size, 0);
        let width = size.width as usize;
        for (i, label) in labels.values_mut().iter_mut().enumerate() {
            let (x, y) = ((i % width) as u64, (i / width) as u64);
            let cell =
                |at: u64, cells: u32, side: u32| (at * u64::from(cells) / u64::from(side)) as u32;
            *label = cell(y, rows, size.height) * columns + cell(x, columns, size.width);
        }
        let middle = |i: u32, cells: u32, side: u32| {
            ((2 * u64::from(i) + 1) * u64::from(side) / (2 * u64::from(cells))) as u32
        };
        let mut search = Self {
            size,
            lab,
            step,
            nearness: (slic.compactness * STEPS / step).powi(2),
            centres: Vec::new(),
            labels,
        };
        search.centres = (0..columns * rows)
            .map(|i| {
                let x = middle(i % columns, columns, size.width);
                let y = middle(i / columns, rows, size.height);
                search.lowest_gradient(x, y)
            })
            .collect();
        search
    }

    fn colour(&self, x: u32, y: u32) -> [f32; 3] {
        let i = y as usize * self.size.width as usize + x as usize;
        [0, 1, 2].map(|c| f32::from(self.lab.channels[c][i]))
    }

    /// The pixel of lowest gradient among `(x, y)` and its eight neighbours, ties to the first.
    fn lowest_gradient(&self, x: u32, y: u32) -> Centre {
        let distance =
            |a: [f32; 3], b: [f32; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>();
        let Size { width, height } = self.size;
        let gradient = |x: u32, y: u32| {
            let (left, right) = (x.saturating_sub(1), (x + 1).min(width - 1));
            let (up, down) = (y.saturating_sub(1), (y + 1).min(height - 1));
            distance(self.colour(left, y), self.colour(right, y))
                + distance(self.colour(x, up), self.colour(x, down))
        };
        let mut best = (f32::INFINITY, x, y);
        for v in y.saturating_sub(1)..=(y + 1).min(height - 1) {
            for u in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                let slope = gradient(u, v);
                if slope < best.0 {
                    best = (slope, u, v);
                }
            }
        }
        let (_, x, y) = best;
        Centre { lab: self.colour(x, y), x: x as f32, y: y as f32 }
    }

    /// Gives every pixel to the nearest centre within `step` of it in x and in y, ties to the first;
    /// one that no centre reaches stays where it was.
    pub(super) fn assign(&mut self) {
        let width = self.size.width as usize;
        let (centres, lab, step, nearness) = (&self.centres, self.lab, self.step, self.nearness);
        let bands = self.labels.values_mut().par_chunks_mut(width * BAND).enumerate();
        bands.for_each(|(band, labels)| {
            let rows = labels.len() / width;
            let (first, last) = ((band * BAND) as f32, (band * BAND + rows - 1) as f32);
            let mut distances = vec![f32::INFINITY; labels.len()];
            for (label, centre) in (0_u32..).zip(centres) {
                if centre.y + step < first || centre.y - step > last {
                    continue;
                }
                let left = (centre.x - step).ceil().max(0.0) as usize;
                let right = ((centre.x + step) as usize + 1).min(width);
                let top = ((centre.y - step).ceil().max(first) - first) as usize;
                let bottom = ((centre.y + step).min(last) - first) as usize;
                for y in top..=bottom {
                    let dy = (band * BAND + y) as f32 - centre.y;
                    let at = (band * BAND + y) * width;
                    let channel = |c: usize| &lab.channels[c][at + left..at + right];
                    let out = y * width + left..y * width + right;
                    centre.claim(
                        [channel(0), channel(1), channel(2)],
                        (left as f32 - centre.x, dy * dy),
                        nearness,
                        (&mut distances[out.clone()], &mut labels[out], label),
                    );
                }
            }
        });
    }

    /// Moves every centre to the mean of its pixels. Sums are whole numbers: in any order the same.
    pub(super) fn update(&mut self) {
        let width = self.size.width as usize;
        let (lab, count) = (self.lab, self.centres.len());
        let bands = self.labels.values().par_chunks(width * BAND).enumerate();
        let blank = || vec![[0; 6]; count];
        let sums: Vec<Sums> = bands
            .with_min_len(8)
            .fold(blank, |mut sums, (band, labels)| {
                for (i, &label) in labels.iter().enumerate() {
                    let at = band * BAND * width + i;
                    let [l, a, b] = [0, 1, 2].map(|c| i64::from(lab.channels[c][at]));
                    let place = [(at % width) as i64, (at / width) as i64];
                    let sum = &mut sums[label as usize];
                    for (sum, v) in sum.iter_mut().zip([l, a, b, place[0], place[1], 1]) {
                        *sum += v;
                    }
                }
                sums
            })
            .reduce(blank, |mut a, b| {
                a.iter_mut().flatten().zip(b.iter().flatten()).for_each(|(a, b)| *a += b);
                a
            });
        for (centre, sum) in self.centres.iter_mut().zip(&sums) {
            if sum[5] > 0 {
                let [l, a, b, x, y] =
                    [0, 1, 2, 3, 4].map(|i| (sum[i] as f64 / sum[5] as f64) as f32);
                *centre = Centre { lab: [l, a, b], x, y };
            }
        }
    }
}

impl Centre {
    /// Assigns pixels of a stretch of a row to this centre if it is nearer than all before. `place` is the stretch's
    /// first x relative to the centre, and its squared y; `out` has the distances so far, the labels, and the label
    /// of this centre.
    fn claim(
        &self,
        [l, a, b]: [&[i16]; 3],
        place: (f32, f32),
        nearness: f32,
        (distances, labels, label): (&mut [f32], &mut [u32], u32),
    ) {
        let colours = l.iter().zip(a).zip(b);
        let targets = distances.iter_mut().zip(labels);
        for (i, (((l, a), b), (distance, owner))) in (0_i32..).zip(colours.zip(targets)) {
            let (dl, da, db) = (
                f32::from(*l) - self.lab[0],
                f32::from(*a) - self.lab[1],
                f32::from(*b) - self.lab[2],
            );
            let dx = i as f32 + place.0;
            let d = dl * dl + da * da + db * db + nearness * (dx * dx + place.1);
            let nearer = d < *distance;
            *distance = if nearer { d } else { *distance };
            *owner = if nearer { label } else { *owner };
        }
    }
}
