//! Sums over pixels with their places, and the plane of colour that is nearest to them (least squares).

use crate::frame::{Frame, Rgba};
use crate::geom::Point;
use crate::scan;

/// What the slopes of a plane cost, as that many square pixels of spread: with it a triangle of few pixels has nearly
/// its mean colour, not a slope that is made of noise.
const RIDGE: f64 = 1.0;

/// Sums over pixels, each as often as it weighs: once in opaque frames, else its alpha. Places are counted from an
/// origin. All are whole numbers: the same in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Moments {
    pub(crate) weight: i64,
    /// x and y.
    pub(crate) at: [i64; 2],
    /// xx, xy and yy.
    pub(crate) spread: [i64; 3],
    /// Red, green and blue.
    pub(crate) colour: [i64; 3],
    /// Those times x, and times y.
    pub(crate) turned: [[i64; 3]; 2],
}

impl Moments {
    /// The sums over `triangle` in `frame`, from the pixel `origin` on.
    pub(crate) fn of(frame: &Frame, triangle: [Point; 3], origin: [i64; 2]) -> Self {
        let mut all = Self::default();
        let opaque = frame.is_opaque();
        scan::spans(triangle, 0..frame.size().height, |y, columns| {
            let x = columns.start as i64 - origin[0];
            let y_from = i64::from(y) - origin[1];
            let row = &frame.row(y)[columns];
            if opaque { all.add_row(row, x, y_from) } else { all.add_weighted(row, x, y_from) }
        });
        all
    }

    fn add_row(&mut self, row: &[Rgba], x: i64, y: i64) {
        let mut sums = [0u32; 3];
        let mut turned = [0u64; 3];
        for (i, pixel) in row.iter().enumerate() {
            (0..3).for_each(|c| {
                sums[c] += u32::from(pixel[c]);
                turned[c] += i as u64 * u64::from(pixel[c]);
            });
        }
        self.add_run(x, y, row.len() as i64, sums.map(i64::from), turned.map(|sum| sum as i64));
    }

    /// Adds `n` pixels of a row from `x` on that weigh 1 each: the `sums` of their colours, and of colours times the
    /// distance from the first.
    #[inline]
    pub(crate) fn add_run(&mut self, x: i64, y: i64, n: i64, sums: [i64; 3], turned: [i64; 3]) {
        let (first, second) = (n * (n - 1) / 2, (n - 1) * n * (2 * n - 1) / 6);
        let sum_x = n * x + first;
        self.weight += n;
        self.at[0] += sum_x;
        self.at[1] += n * y;
        self.spread[0] += n * x * x + 2 * x * first + second;
        self.spread[1] += sum_x * y;
        self.spread[2] += n * y * y;
        (0..3).for_each(|c| {
            self.colour[c] += sums[c];
            self.turned[0][c] += x * sums[c] + turned[c];
            self.turned[1][c] += y * sums[c];
        });
    }

    fn add_weighted(&mut self, row: &[Rgba], x: i64, y: i64) {
        for (x, pixel) in (x..).zip(row) {
            let w = i64::from(pixel[3]);
            self.weight += w;
            self.at[0] += w * x;
            self.at[1] += w * y;
            self.spread[0] += w * x * x;
            self.spread[1] += w * x * y;
            self.spread[2] += w * y * y;
            (0..3).for_each(|c| {
                let value = w * i64::from(pixel[c]);
                self.colour[c] += value;
                self.turned[0][c] += value * x;
                self.turned[1][c] += value * y;
            });
        }
    }

    /// The plane nearest to the pixels; `None` where there are none. `unit` is what a pixel weighs that is seen
    /// whole.
    pub(crate) fn plane(&self, unit: f64) -> Option<Slopes> {
        if self.weight <= 0 {
            return None;
        }
        let n = self.weight as f64;
        let [x, y] = self.at.map(|sum| sum as f64 / n);
        let [xx, xy, yy] = self.centred();
        let ridge = RIDGE * unit;
        let (a, b) = (xx + ridge, yy + ridge);
        let determinant = a * b - xy * xy;
        let mut slopes = Slopes { at: [x, y], mean: [0.0; 3], across: [0.0; 3], down: [0.0; 3] };
        for c in 0..3 {
            let sum = self.colour[c] as f64;
            let (u, v) = (self.turned[0][c] as f64 - x * sum, self.turned[1][c] as f64 - y * sum);
            slopes.mean[c] = sum / n;
            slopes.across[c] = (b * u - xy * v) / determinant;
            slopes.down[c] = (a * v - xy * u) / determinant;
        }
        Some(slopes)
    }

    /// How much of the pixels' squares the plane accounts for; at least what their mean does.
    pub(crate) fn explained(&self) -> f64 {
        let Some(slopes) = self.plane(1.0) else { return 0.0 };
        let n = self.weight as f64;
        let [xx, xy, yy] = self.centred();
        let mut explained = 0.0;
        for c in 0..3 {
            let sum = self.colour[c] as f64;
            let [u, v] = [0, 1].map(|i| self.turned[i][c] as f64 - slopes.at[i] * sum);
            let (p, q) = (slopes.across[c], slopes.down[c]);
            explained += sum * sum / n;
            explained += 2.0 * (p * u + q * v) - (p * p * xx + 2.0 * p * q * xy + q * q * yy);
        }
        explained
    }

    /// The spread around the centre: xx, xy and yy.
    fn centred(&self) -> [f64; 3] {
        let n = self.weight as f64;
        let [x, y] = self.at.map(|sum| sum as f64);
        let [xx, xy, yy] = self.spread.map(|sum| sum as f64);
        [xx - x * x / n, xy - x * y / n, yy - y * y / n]
    }
}

impl std::ops::AddAssign for Moments {
    fn add_assign(&mut self, o: Self) {
        self.weight += o.weight;
        for i in 0..2 {
            self.at[i] += o.at[i];
        }
        for c in 0..3 {
            self.spread[c] += o.spread[c];
            self.colour[c] += o.colour[c];
            self.turned[0][c] += o.turned[0][c];
            self.turned[1][c] += o.turned[1][c];
        }
    }
}

/// A plane of colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slopes {
    /// The centre, in pixels from the origin of the [`Moments`].
    pub(crate) at: [f64; 2],
    /// Red, green and blue there.
    pub(crate) mean: [f64; 3],
    /// Their change from one pixel to the next.
    pub(crate) across: [f64; 3],
    pub(crate) down: [f64; 3],
}

impl Slopes {
    /// The colour at a place.
    pub(crate) fn colour(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let (dx, dy) = (x - self.at[0], y - self.at[1]);
        std::array::from_fn(|c| self.mean[c] + dx * self.across[c] + dy * self.down[c])
    }
}

/// The origin for [`Moments`] of a triangle: its first corner's pixel.
pub(crate) fn origin([a, ..]: [Point; 3]) -> [i64; 2] {
    [a.x, a.y].map(|v| i64::from(v.div_euclid(crate::geom::SUBPIXEL)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};
    use crate::geom::{SUBPIXEL, Size, orient};
    use proptest::prelude::*;

    fn noise(size: Size, seed: u64, opaque: bool) -> Frame {
        let pixel = |i: usize| {
            let [r, g, b, a, ..] = rank(seed, Purpose::Noise, i as u32, 0).to_le_bytes();
            [r, g, b, if opaque { 255 } else { a }]
        };
        Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("a small frame")
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn the_plane_has_no_more_error_than_the_mean_and_less_than_planes_beside_it(
            corners in proptest::array::uniform3((0i32..=40 * SUBPIXEL, 0i32..=30 * SUBPIXEL)),
            seed: u64,
        ) {
            let frame = noise(Size::new(40, 30), seed, true);
            let triangle = corners.map(|(x, y)| Point::new(x, y));
            prop_assume!(orient(triangle[0], triangle[1], triangle[2]) != 0);
            let moments = Moments::of(&frame, triangle, [3, 4]);
            prop_assume!(moments.weight > 0);
            let slopes = moments.plane(1.0).expect("it has pixels");
            let error = |slopes: &Slopes, ridge: f64| {
                let mut error = 0.0;
                scan::spans(triangle, 0..30, |y, columns| for x in columns {
                    let at = [x as f64 - 3.0, f64::from(y) - 4.0];
                    let plane = slopes.colour(at);
                    let pixel = frame.at(x as u32, y);
                    error += (0..3).map(|c| (plane[c] - f64::from(pixel[c])).powi(2)).sum::<f64>();
                });
                let squared = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>();
                error + ridge * (squared(slopes.across) + squared(slopes.down))
            };
            let flat = Slopes { across: [0.0; 3], down: [0.0; 3], ..slopes };
            let squares = {
                let mut sum = 0.0;
                scan::spans(triangle, 0..30, |y, columns| for x in columns {
                    let pixel = frame.at(x as u32, y);
                    sum += (0..3).map(|c| f64::from(pixel[c]).powi(2)).sum::<f64>();
                });
                sum
            };
            let best = error(&slopes, 0.0);
            prop_assert!(best <= error(&flat, 0.0) + 1e-6);
            prop_assert!((squares - moments.explained() - best).abs() < 1e-4 * squares.max(1.0));
            for i in 0..3 {
                for by in [-0.01, 0.01] {
                    let mut other = slopes;
                    other.across[i] += by;
                    other.down[(i + 1) % 3] -= by;
                    prop_assert!(error(&slopes, RIDGE) <= error(&other, RIDGE) + 1e-9);
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_seen_weighs_nothing_and_parts_add_up() {
        let size = Size::new(20, 20);
        let pixel = |i: usize| [i as u8, 200, 9, if i % 20 < 10 { 255 } else { 0 }];
        let frame =
            Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("a small frame");
        let p = |x: i32, y: i32| Point::new(x * SUBPIXEL, y * SUBPIXEL);
        let all = Moments::of(&frame, [p(0, 0), p(20, 0), p(0, 20)], [0, 0]);
        let left = Moments::of(&frame, [p(0, 0), p(10, 0), p(0, 20)], [0, 0]);
        assert!(left.weight < all.weight);
        let mut sum = left;
        sum += Moments::of(&frame, [p(10, 0), p(20, 0), p(0, 20)], [0, 0]);
        assert_eq!(sum, all);
        assert_eq!(Moments::of(&frame, [p(12, 0), p(20, 0), p(20, 6)], [0, 0]).weight, 0);
    }
}
