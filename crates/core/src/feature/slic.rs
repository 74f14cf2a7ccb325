//! SLIC superpixels and the corners where they meet (Achanta, Shaji, Smith, Lucchi, Fua and
//! Suesstrunk, "SLIC Superpixels Compared to State-of-the-art Superpixel Methods", IEEE PAMI 34(11),
//! 2012).

mod cluster;

use super::lab::Lab;
use super::mask::Mask;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::geom::Size;
use crate::plane::Plane;
use cluster::Search;

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
            return Err(Error::out_of_range("superpixels", count, "at least 1"));
        }
        if !(compactness > 0.0 && compactness <= 100.0) {
            return Err(Error::out_of_range(
                "slic-compactness",
                compactness,
                "above 0 and at most 100",
            ));
        }
        if !(1..=100).contains(&iterations) {
            return Err(Error::out_of_range("slic-iterations", iterations, "1 to 100"));
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

    #[cfg(feature = "parallel")]
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
