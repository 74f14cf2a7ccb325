//! Finds motion and changes from frame to frame, on small luma pictures, block by block.

use crate::parallel::prelude::*;

use super::patch::{PATCH, Patch, Window, dot, sum};
use super::small::Small;
use super::starts;
use crate::geom::Size;
use crate::plane::Plane;
use crate::simd::dispatch;

/// Descents of a patch on one level; more than about six move it by less than a tenth of a pixel.
const DESCENTS: usize = 6;

/// The motion of blocks: the picture at a block's centre in one frame has moved by a vector in the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Centres of the columns of blocks, in pixels of the frame.
    columns: Vec<f32>,
    rows: Vec<f32>,
    /// Row by row, in pixels of the frame.
    vectors: Vec<[f32; 2]>,
}

impl Motion {
    /// No motion, for a picture like `small`.
    pub fn zero(small: &Small) -> Self {
        let (columns, rows) = blocks(small);
        let centre = |start: &usize| (*start as f32 + PATCH as f32 / 2.0) * small.factor as f32;
        Self {
            columns: columns.iter().map(centre).collect(),
            rows: rows.iter().map(centre).collect(),
            vectors: vec![[0.0; 2]; columns.len() * rows.len()],
        }
    }

    /// The motion from `from` to `to` in the blocks that `changed` marks (by column and row of blocks, see
    /// [`blocks`]); all others do not move, nor do pictures of different sizes.
    ///
    /// Each block, and each coarser one that contains it, searches for its match by inverse search on a pyramid, then
    /// takes the component-wise median of its neighbours' vectors.
    pub fn between(from: &Small, to: &Small, changed: &[bool]) -> Self {
        let mut motion = Self::zero(from);
        if from.size != to.size || !changed.contains(&true) {
            return motion;
        }
        let scale = from.factor as f32;
        let mut wanted = vec![changed.to_vec()];
        for (level, pair) in from.levels.windows(2).enumerate() {
            wanted.push(halved(&wanted[level], [pair[0].size(), pair[1].size()]));
        }
        let mut coarse: Option<Grid> = None;
        for ((a, b), wanted) in from.levels.iter().zip(&to.levels).zip(&wanted).rev() {
            coarse = Some(Grid::search(a, b, coarse.as_ref(), wanted));
        }
        if let Some(found) = coarse {
            let scaled = |(i, &changed): (usize, &bool)| {
                if changed { found.median(i).map(|v| v * scale) } else { [0.0; 2] }
            };
            motion.vectors = changed.iter().enumerate().map(scaled).collect();
        }
        motion
    }

    /// The vector at `(x, y)` in pixels of the frame, in pixels: bilinear between blocks.
    pub fn at(&self, x: f32, y: f32) -> [f32; 2] {
        let place = |centres: &[f32], at: f32| {
            let after = centres.partition_point(|&c| c <= at).clamp(1, centres.len().max(2) - 1);
            let before = after - 1;
            let after = after.min(centres.len() - 1);
            let span = centres[after] - centres[before];
            let share = if span > 0.0 { (at - centres[before]) / span } else { 0.0 };
            (before, after, share.clamp(0.0, 1.0))
        };
        let (left, right, fx) = place(&self.columns, x);
        let (top, bottom, fy) = place(&self.rows, y);
        let vector = |row: usize, column: usize| self.vectors[row * self.columns.len() + column];
        let mix = |a: [f32; 2], b: [f32; 2], t: f32| [0, 1].map(|i| a[i] + (b[i] - a[i]) * t);
        mix(
            mix(vector(top, left), vector(top, right), fx),
            mix(vector(bottom, left), vector(bottom, right), fx),
            fy,
        )
    }

    /// Whether nothing moves at all.
    pub fn is_zero(&self) -> bool {
        self.vectors.iter().all(|v| *v == [0.0; 2])
    }
}

/// The positions of the columns and rows of blocks, in small pixels.
pub fn blocks(small: &Small) -> (Vec<usize>, Vec<usize>) {
    blocks_of(small.plane().size())
}

/// Side of a block in small pixels.
pub const BLOCK: usize = PATCH;

/// Marks the blocks of a picture of half the size, the second of `sizes`, that contain any of the `wanted` ones.
fn halved(wanted: &[bool], sizes: [Size; 2]) -> Vec<bool> {
    let [finer, coarser] = sizes.map(counts);
    let mut halved = vec![false; coarser.0 * coarser.1];
    for (i, _) in wanted.iter().enumerate().filter(|(_, wanted)| **wanted) {
        let (column, row) = (i % finer.0 / 2, i / finer.0 / 2);
        halved[row.min(coarser.1 - 1) * coarser.0 + column.min(coarser.0 - 1)] = true;
    }
    halved
}

/// The number of columns and rows of blocks.
fn counts(size: Size) -> (usize, usize) {
    let (columns, rows) = blocks_of(size);
    (columns.len(), rows.len())
}

/// The positions of the columns and rows of blocks of a picture.
fn blocks_of(size: Size) -> (Vec<usize>, Vec<usize>) {
    (starts(size.width, PATCH), starts(size.height, PATCH))
}

/// Vectors of the blocks of one level.
struct Grid {
    columns: usize,
    vectors: Vec<[f32; 2]>,
}

impl Grid {
    fn search(a: &Plane<f32>, b: &Plane<f32>, before: Option<&Self>, wanted: &[bool]) -> Self {
        let (columns, rows) = blocks_of(a.size());
        let count = columns.len() * rows.len();
        let vector = |i: usize| {
            if !wanted[i] {
                return [0.0; 2];
            }
            let (column, row) = (i % columns.len(), i / columns.len());
            let patch = Patch::new(a, (columns[column], rows[row]));
            let mut tries = [[0.0; 2]; 6];
            if let Some(before) = before {
                let rows = before.vectors.len() / before.columns;
                let near = |dx: usize, dy: usize| {
                    let x = (column / 2 + dx).saturating_sub(1).min(before.columns - 1);
                    let y = (row / 2 + dy).saturating_sub(1).min(rows - 1);
                    before.vectors[y * before.columns + x].map(|v| 2.0 * v)
                };
                tries = [[0.0; 2], near(1, 1), near(0, 1), near(2, 1), near(1, 0), near(1, 2)];
            }
            let found = patch.search(b, &tries, DESCENTS);
            // A motion must match clearly better than zero, not only fit the grain.
            if found.squares < 0.5 * found.first { found.vector } else { [0.0; 2] }
        };
        let vectors = (0..count).into_par_iter().with_min_len(32).map(vector).collect();
        Self { columns: columns.len(), vectors }
    }

    /// Each component's median over the 3x3 blocks around block `i`, those beyond the border left out.
    fn median(&self, i: usize) -> [f32; 2] {
        let rows = self.vectors.len() / self.columns;
        let (x, y) = (i % self.columns, i / self.columns);
        let (mut around, mut count) = ([[0.0; 9]; 2], 0);
        for v in y.saturating_sub(1)..(y + 2).min(rows) {
            for u in x.saturating_sub(1)..(x + 2).min(self.columns) {
                let [right, down] = self.vectors[v * self.columns + u];
                (around[0][count], around[1][count]) = (right, down);
                count += 1;
            }
        }
        around.map(|mut around| {
            if count == around.len() {
                return median_of_9(around);
            }
            let around = &mut around[..count];
            around.sort_unstable_by(f32::total_cmp);
            around[count / 2]
        })
    }
}

/// The median, without a branch: Paeth, "Median Finding on a 3x3 Grid", Graphics Gems, 1990, in Smith's order of
/// 19 exchanges ("Implementing median filters in XC4000E FPGAs", XCell 23, 1996).
fn median_of_9(mut p: [f32; 9]) -> f32 {
    const EXCHANGES: [[usize; 2]; 19] = [
        [1, 2],
        [4, 5],
        [7, 8],
        [0, 1],
        [3, 4],
        [6, 7],
        [1, 2],
        [4, 5],
        [7, 8],
        [0, 3],
        [5, 8],
        [4, 7],
        [3, 6],
        [1, 4],
        [2, 5],
        [4, 7],
        [4, 2],
        [6, 4],
        [4, 2],
    ];
    for [i, j] in EXCHANGES {
        (p[i], p[j]) = (p[i].min(p[j]), p[i].max(p[j]));
    }
    p[4]
}

/// The mean absolute difference of each block between two small pictures, 0..255, row by row.
pub fn block_differences(a: &Small, b: &Small) -> Vec<f32> {
    let Size { width, height } = a.plane().size();
    let (w, h) = (PATCH.min(width as usize), PATCH.min(height as usize));
    places(a)
        .map(|(x, y)| {
            let mut sum = 0.0;
            for v in y..y + h {
                let (a, b) =
                    (&a.plane().row(v as u32)[x..x + w], &b.plane().row(v as u32)[x..x + w]);
                sum += a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>();
            }
            sum / (w * h) as f32
        })
        .collect()
}

/// The mean of each block of a small picture, 0..255, row by row.
pub fn block_means(small: &Small) -> Vec<f32> {
    let mean = |place| {
        let window = Window::new(small.plane().size(), place);
        sum(&window.look(small.plane(), [0.0; 2])) / window.count() as f32
    };
    places(small).map(mean).collect()
}

/// How well `motion` predicts `to`: for each block the correlation, -1..1, of the block in `from` with its moved
/// position; `None` for blocks without texture in either, or nearly white in one.
pub fn block_correlations(from: &Small, to: &Small, motion: &Motion) -> Vec<Option<f32>> {
    let known = places(from).zip(&motion.vectors).map(|(place, vector)| {
        let window = Window::new(from.plane().size(), place);
        let vector = vector.map(|v| v / from.factor as f32);
        dispatch(
            #[inline(always)]
            || correlation(window, from.plane(), to.plane(), vector),
        )
    });
    known.collect()
}

/// The correlation of one block, at `window` in `from` and moved by the vector in `to`.
#[inline(always)]
fn correlation(
    window: Window,
    from: &Plane<f32>,
    to: &Plane<f32>,
    vector: [f32; 2],
) -> Option<f32> {
    let count = window.count() as f32;
    let (a, b) = (window.look(from, [0.0; 2]), window.look(to, vector));
    if sum(&a).max(sum(&b)) > BURNT * count {
        return None;
    }
    let (a, b) = (centred(window, a), centred(window, b));
    let (aa, bb, ab) = (dot(&a, &a), dot(&b, &b), dot(&a, &b));
    let grain = GRAIN * count;
    (aa.max(bb) > grain).then_some(ab / (aa.max(grain) * bb.max(grain)).sqrt())
}

/// Whether there are `least` blocks with texture.
pub fn has_textured(small: &Small, least: usize) -> bool {
    let is_textured = |&place: &(usize, usize)| {
        dispatch(
            #[inline(always)]
            || {
                let window = Window::new(small.plane().size(), place);
                let values = centred(window, window.look(small.plane(), [0.0; 2]));
                dot(&values, &values) > GRAIN * window.count() as f32
            },
        )
    };
    least == 0 || places(small).filter(is_textured).nth(least - 1).is_some()
}

/// Variance, in squared levels, below which a block has grain, not texture.
const GRAIN: f32 = 4.0;

/// Mean luma above which a block is overexposed, for instance by a flash, and cannot be compared.
const BURNT: f32 = 250.0;

/// The positions of the blocks, row by row.
fn places(small: &Small) -> impl Iterator<Item = (usize, usize)> {
    let (columns, rows) = blocks(small);
    rows.into_iter().flat_map(move |y| columns.clone().into_iter().map(move |x| (x, y)))
}

/// The `values` in the `window`, less their mean.
#[inline(always)]
fn centred(window: Window, mut values: [f32; PATCH * PATCH]) -> [f32; PATCH * PATCH] {
    let mean = sum(&values) / window.count() as f32;
    values[..window.count()].iter_mut().for_each(|v| *v -= mean);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use proptest::prelude::*;

    fn waves(size: Size, u: f64, v: f64) -> Frame {
        let value = |i: u32| {
            let (x, y) = (f64::from(i % size.width) - u, f64::from(i / size.width) - v);
            let wave = (x * 0.071).sin() * (y * 0.053).cos() + (x * 0.031 + y * 0.047).sin();
            let g = (128.0 + 50.0 * wave).round() as u8;
            [g, g, g, 255]
        };
        let pixels = (0..size.pixels() as u32).map(value).collect();
        Frame::new(size, pixels).expect("a small frame")
    }

    fn motion(a: &Frame, b: &Frame) -> Motion {
        let (a, b) = (Small::new(a), Small::new(b));
        let (columns, rows) = blocks(&a);
        Motion::between(&a, &b, &vec![true; columns.len() * rows.len()])
    }

    proptest! {
        #[test]
        fn the_median_of_nine_is_the_fifth_in_order(values in proptest::array::uniform9(-3i8..3)) {
            let values = values.map(f32::from);
            let mut sorted = values;
            sorted.sort_unstable_by(f32::total_cmp);
            prop_assert_eq!(median_of_9(values), sorted[4]);
        }

        /// Also where the last column or row of blocks overlaps the one before.
        #[test]
        fn blocks_of_half_the_size_stand_for_all_that_are_wanted(
            (width, height) in (8u32..200, 8u32..200),
            seed in any::<u64>(),
        ) {
            let sizes = [Size::new(width, height), Size::new(width.div_ceil(2), height.div_ceil(2))];
            let [(columns, rows), (half_columns, half_rows)] = sizes.map(counts);
            let wanted: Vec<_> = (0..columns * rows).map(|i| seed >> (i % 64) & 1 == 1).collect();
            let halved = halved(&wanted, sizes);
            prop_assert_eq!(halved.len(), half_columns * half_rows);
            for row in 0..half_rows {
                for column in 0..half_columns {
                    let stands_for = |i: &usize| {
                        let (x, y) = (i % columns / 2, i / columns / 2);
                        x.min(half_columns - 1) == column && y.min(half_rows - 1) == row
                    };
                    let any = (0..wanted.len()).filter(stands_for).any(|i| wanted[i]);
                    prop_assert_eq!(halved[row * half_columns + column], any);
                }
            }
        }
    }

    #[test]
    fn a_moved_picture_is_followed() {
        for size in [Size::new(400, 300), Size::new(1000, 700)] {
            for (u, v) in [(1.0, 0.0), (6.0, -3.0), (-12.0, 9.0)] {
                let found = motion(&waves(size, 0.0, 0.0), &waves(size, u, v));
                let mut off: Vec<f32> = Vec::new();
                for y in (60..size.height - 60).step_by(20) {
                    for x in (60..size.width - 60).step_by(20) {
                        let [fu, fv] = found.at(x as f32, y as f32);
                        off.push((fu - u as f32).hypot(fv - v as f32));
                    }
                }
                off.sort_unstable_by(f32::total_cmp);
                let typical = off[off.len() / 2];
                assert!(typical < 0.5, "{size}, moved by ({u}, {v}): {typical} pixels off");
            }
        }
    }

    #[test]
    fn equal_pictures_rest_and_so_do_the_smallest() {
        let frame = waves(Size::new(300, 200), 0.0, 0.0);
        assert!(motion(&frame, &frame).is_zero());
        for size in [Size::new(1, 1), Size::new(3, 2), Size::new(1, 900), Size::new(9, 9)] {
            let found = motion(&waves(size, 0.0, 0.0), &waves(size, 1.0, 0.0));
            assert!(found.at(0.0, 0.0).iter().all(|v| v.is_finite()));
            assert!(
                block_differences(
                    &Small::new(&waves(size, 0.0, 0.0)),
                    &Small::new(&waves(size, 0.0, 0.0))
                )
                .iter()
                .all(|&d| d == 0.0)
            );
        }
    }
}
