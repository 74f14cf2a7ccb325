//! SLIC superpixels and the corners where they meet (Achanta, Shaji, Smith, Lucchi, Fua and
//! Suesstrunk, "SLIC Superpixels Compared to State-of-the-art Superpixel Methods", IEEE PAMI 34(11),
//! 2012).

use rayon::prelude::*;

use super::lab::{Lab, STEPS};
use super::mask::Mask;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::geom::Size;
use crate::plane::Plane;

/// Rows that one task works through.
const BAND: usize = 16;

/// How to cut a frame into superpixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slic {
    /// Superpixels to aim at, at least 1; a frame is never cut finer than into
    /// squares of 4 pixels a side.
    pub count: u32,
    /// Weight of nearness against likeness of colour, above 0 to 100; large makes squares. Default 10
    /// (Achanta et al., section 3.2).
    pub compactness: f32,
    /// Rounds of assignment, 1 to 100. Default 10 (Achanta et al., section 3.1).
    pub iterations: u32,
}

impl Slic {
    /// `count` superpixels with the paper's parameters.
    pub const fn new(count: u32) -> Self {
        Self { count, compactness: 10.0, iterations: 10 }
    }

    /// The number of its superpixel for every pixel of `frame`, from 0 in the order in which rows
    /// meet them; each superpixel is one piece over its pixels' four neighbours.
    ///
    /// # Errors
    /// When a field is out of its range.
    pub fn segment(&self, frame: &Frame) -> Result<Plane<u32>> {
        let Self { count, compactness, iterations } = *self;
        if count == 0 {
            return Err(Error::usage("the number of superpixels is 0; it must be at least 1"));
        }
        if !(compactness > 0.0 && compactness <= 100.0) {
            return Err(Error::usage(format!(
                "slic compactness is {compactness}; it can be above 0 and at most 100"
            )));
        }
        if !(1..=100).contains(&iterations) {
            return Err(Error::usage(format!("slic iterations are {iterations}; 1 to 100")));
        }
        let lab = Lab::of(frame);
        let mut search = Search::new(frame.size(), &lab, self);
        for round in 0..iterations {
            search.assign();
            if round + 1 < iterations {
                search.update();
            }
        }
        Ok(join(&search.labels, (search.step * search.step / 4.0) as usize))
    }
}

/// The pixels at which three or more superpixels meet: those whose square with their neighbours to
/// the right, below and below to the right holds three labels.
pub fn corners(labels: &Plane<u32>) -> Mask {
    let Size { width, height } = labels.size();
    let mut mask = Mask::new(labels.size());
    for y in 1..height {
        let (above, below) = (labels.row(y - 1), labels.row(y));
        for x in 1..width {
            let i = x as usize;
            let square = [above[i - 1], above[i], below[i - 1], below[i]];
            let new = |n: usize| !square[..n].contains(&square[n]);
            if [1, 2, 3].into_iter().filter(|&n| new(n)).count() >= 2 {
                mask.insert(x - 1, y - 1);
            }
        }
    }
    mask
}

/// The centre of a superpixel: L*, a*, b* in steps, and its place in pixels.
#[derive(Clone, Copy, Debug)]
struct Centre {
    lab: [f32; 3],
    x: f32,
    y: f32,
}

/// Sums over the pixels of a superpixel: L*, a*, b* in steps, x, y, and how many.
type Sums = [i64; 6];

struct Search<'a> {
    size: Size,
    lab: &'a Lab,
    /// Side of the square that a superpixel would fill by itself.
    step: f32,
    /// Squared steps of colour that a squared pixel of distance is worth.
    nearness: f32,
    centres: Vec<Centre>,
    labels: Plane<u32>,
}

impl<'a> Search<'a> {
    /// Centres on a regular grid, each moved to the place of lowest gradient among its neighbours.
    fn new(size: Size, lab: &'a Lab, slic: &Slic) -> Self {
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
                search.calm(x, y)
            })
            .collect();
        search
    }

    fn colour(&self, x: u32, y: u32) -> [f32; 3] {
        let i = y as usize * self.size.width as usize + x as usize;
        [0, 1, 2].map(|c| f32::from(self.lab.channels[c][i]))
    }

    /// The pixel of lowest gradient among `(x, y)` and its eight neighbours, ties to the first.
    fn calm(&self, x: u32, y: u32) -> Centre {
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
    fn assign(&mut self) {
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
    fn update(&mut self) {
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
    /// Claims the pixels of a stretch of a row to which it is nearer than all before. `place` is the
    /// stretch's first x as seen from here, and the square of its y; `out` the distances so far, the
    /// labels, and the label of this centre.
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

/// Makes every superpixel one piece: pieces smaller than `least` pixels join the piece that was met
/// before them, to their left or above.
fn join(labels: &Plane<u32>, least: usize) -> Plane<u32> {
    const FREE: u32 = u32::MAX;
    let size = labels.size();
    let (width, old) = (size.width as usize, labels.values());
    let mut joined = Plane::filled(size, FREE);
    let new = joined.values_mut();
    let mut next = 0;
    let mut piece = Vec::new();
    for start in 0..old.len() {
        if new[start] != FREE {
            continue;
        }
        let left = (!start.is_multiple_of(width)).then(|| new[start - 1]);
        let before = left.or_else(|| start.checked_sub(width).map(|above| new[above]));
        piece.clear();
        piece.push(start);
        new[start] = next;
        let mut seen = 0;
        while let Some(&at) = piece.get(seen) {
            seen += 1;
            let x = at % width;
            let sides = [
                (x > 0).then(|| at - 1),
                (x + 1 < width).then_some(at + 1),
                at.checked_sub(width),
                (at + width < old.len()).then_some(at + width),
            ];
            for side in sides.into_iter().flatten() {
                if new[side] == FREE && old[side] == old[start] {
                    new[side] = next;
                    piece.push(side);
                }
            }
        }
        match before {
            Some(before) if piece.len() < least => piece.iter().for_each(|&at| new[at] = before),
            _ => next += 1,
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};
    use std::collections::BTreeMap;

    /// Four quarters of colour with noise in them.
    fn quarters() -> Frame {
        let size = Size::new(120, 90);
        let pixel = |i: u32| {
            let (x, y) = (i % 120, i / 120);
            let n = (rank(1, Purpose::Noise, x, y) % 12) as u8;
            match (x < 57, y < 43) {
                (true, true) => [200, 40 + n, 40, 255],
                (false, true) => [40, 180 + n, 60, 255],
                (true, false) => [50, 60, 190 + n, 255],
                (false, false) => [220, 210, 90 + n, 255],
            }
        };
        Frame::new(size, (0..120 * 90).map(pixel).collect()).expect("120 x 90")
    }

    fn pieces(labels: &Plane<u32>) -> usize {
        let whole = join(labels, 0);
        whole.values().iter().max().map_or(0, |&m| m as usize + 1)
    }

    #[test]
    fn superpixels_are_as_many_as_asked_and_each_in_one_piece() {
        let labels = Slic::new(100).segment(&quarters()).expect("fields in range");
        let count = *labels.values().iter().max().expect("pixels") as usize + 1;
        assert!((70..=140).contains(&count), "{count} superpixels");
        assert_eq!(pieces(&labels), count, "every superpixel is one piece");
    }

    #[test]
    fn superpixels_keep_to_edges() {
        let frame = quarters();
        let labels = Slic::new(100).segment(&frame).expect("fields in range");
        let mut quarters_of = BTreeMap::<u32, [usize; 4]>::new();
        for y in 0..90 {
            for x in 0..120 {
                let quarter = usize::from(x < 57) + 2 * usize::from(y < 43);
                quarters_of.entry(labels.at(x, y)).or_default()[quarter] += 1;
            }
        }
        let astray: usize = quarters_of
            .values()
            .map(|n| n.iter().sum::<usize>() - n.iter().max().unwrap_or(&0))
            .sum();
        assert!(astray < 20, "{astray} pixels lie beyond an edge (under-segmentation error)");
    }

    #[test]
    fn corners_are_where_three_meet() {
        let labels = Plane::new(Size::new(4, 3), vec![0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 2, 2]);
        let mask = corners(&labels.expect("4 x 3"));
        assert_eq!(mask.iter().collect::<Vec<_>>(), [(1, 1)]);
        let frame = quarters();
        let labels = Slic::new(100).segment(&frame).expect("fields in range");
        let found = corners(&labels).len();
        // In a planar map of n regions there are about 2n corners of three (Euler).
        assert!((120..300).contains(&found), "{found} corners");
    }

    #[test]
    fn the_same_on_any_number_of_threads() {
        let frame = quarters();
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let segment = || Slic::new(60).segment(&frame).expect("fields in range");
            pool.expect("a small pool").install(segment)
        };
        assert_eq!(with(1), with(3));
    }

    #[test]
    fn small_frames_and_large_counts() {
        for (width, height) in [(1, 1), (1, 7), (9, 1), (3, 3)] {
            let frame = Frame::filled(Size::new(width, height), [1, 2, 3, 255]).expect("sound");
            for count in [1, 5, u32::MAX] {
                let labels = Slic::new(count).segment(&frame).expect("fields in range");
                assert_eq!(labels.values().len(), (width * height) as usize);
            }
        }
    }

    #[test]
    fn fields_out_of_range_are_refused() {
        let frame = quarters();
        for slic in [
            Slic::new(0),
            Slic { compactness: 0.0, ..Slic::new(9) },
            Slic { compactness: f32::NAN, ..Slic::new(9) },
            Slic { iterations: 0, ..Slic::new(9) },
        ] {
            assert!(slic.segment(&frame).is_err(), "{slic:?}");
        }
    }
}
