//! Canny's edge detector (Canny, "A Computational Approach to Edge Detection", IEEE PAMI 8(6), 1986)
//! in the form of scikit-image's `feature.canny` with `mode='nearest'`: Gaussian, Sobel's gradient,
//! suppression of non-maxima along the gradient (its neighbours interpolated, not picked by
//! rounded angle), and hysteresis over eight neighbours. Of imageproc's `canny` neither the sigma nor
//! the border can be chosen, and its hysteresis follows six neighbours of eight.

use super::edges::{about, by_rows, gradient};
use super::mask::Mask;
use crate::error::{Error, Result};
use crate::plane::Plane;

/// Share of the pixels that are taken not to be edges (MATLAB, `edge`, method `canny`).
const NOT_EDGES: f64 = 0.7;

/// The low threshold as a share of the high one (MATLAB, `edge`, method `canny`).
const LOW_TO_HIGH: f32 = 0.4;

/// Bins of the histogram from which the high threshold is read (MATLAB, `edge`, method `canny`).
const BINS: usize = 64;

/// Parameters of the edge detector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Canny {
    /// Standard deviation of the Gaussian in pixels, 0.1 to 16. Default the root of 2 (MATLAB's).
    pub sigma: f32,
    /// Low and high threshold of the gradient's length in steps of luma, with Sobel's weights
    /// (1, 2, 1) not divided by their sum; `None` chooses them for the picture, so that 70 % of its
    /// pixels lie below the high one and the low one is 0.4 of it, as MATLAB's `edge` does. Default
    /// `None`.
    pub thresholds: Option<(f32, f32)>,
}

impl Default for Canny {
    fn default() -> Self {
        Self { sigma: std::f32::consts::SQRT_2, thresholds: None }
    }
}

impl Canny {
    /// The edge pixels of `luma`. None lies on the frame's border, where there is no gradient to
    /// trust.
    ///
    /// # Errors
    /// When a field is out of its range.
    pub fn edges(&self, luma: &Plane<u8>) -> Result<Mask> {
        let Self { sigma, thresholds } = *self;
        if !(0.1..=16.0).contains(&sigma) {
            return Err(Error::out_of_range("canny-sigma", sigma, "0.1 to 16"));
        }
        if let Some((low, high)) = thresholds
            && !(0.0 <= low && low <= high && high.is_finite())
        {
            return Err(Error::out_of_range(
                "canny-thresholds",
                format!("{low} and {high}"),
                "low then high, from 0",
            ));
        }
        let size = luma.size();
        if size.pixels() == 0 {
            return Ok(Mask::new(size));
        }
        let smooth = gaussian(luma, sigma);
        let slope = by_rows(size, (0.0, 0.0), |y, out| {
            let rows = about(&smooth, y);
            out.iter_mut().enumerate().for_each(|(x, value)| *value = gradient(&rows, x));
        });
        let length = slope.map(|(dx, dy)| (dx * dx + dy * dy).sqrt());
        let (low, high) = thresholds.unwrap_or_else(|| choose(&length));
        let ridge = thin(&slope, &length, low);
        Ok(grow(&ridge, high))
    }
}

/// `luma` smoothed with a Gaussian that is cut at four sigma (scipy's default); the border repeats
/// itself outwards.
fn gaussian(luma: &Plane<u8>, sigma: f32) -> Plane<f32> {
    let reach = (4.0 * f64::from(sigma) + 0.5) as usize;
    let weight = |i: usize| (-(i as f64 / f64::from(sigma)).powi(2) / 2.0).exp();
    let total: f64 = (1..=reach).map(weight).sum::<f64>() * 2.0 + weight(0);
    let taps: Vec<f32> = (0..=reach).map(|i| (weight(i) / total) as f32).collect();
    let size = luma.size();
    by_rows(size, 0.0, |y, out| {
        let row = |y: u32| luma.row(y.min(size.height - 1));
        let mut line = vec![0.0; out.len() + 2 * reach];
        let middle = &mut line[reach..][..out.len()];
        middle.iter_mut().zip(row(y)).for_each(|(sum, &v)| *sum = taps[0] * f32::from(v));
        for (i, tap) in taps.iter().enumerate().skip(1) {
            let (above, below) = (row(y.saturating_sub(i as u32)), row(y + i as u32));
            for ((sum, &a), &b) in middle.iter_mut().zip(above).zip(below) {
                *sum += tap * (f32::from(a) + f32::from(b));
            }
        }
        let (first, last) = (line[reach], line[reach + out.len() - 1]);
        line[..reach].fill(first);
        line[reach + out.len()..].fill(last);
        let at = |shift: usize| &line[shift..];
        out.iter_mut().zip(at(reach)).for_each(|(sum, &v)| *sum = taps[0] * v);
        for (i, tap) in taps.iter().enumerate().skip(1) {
            for ((sum, &a), &b) in out.iter_mut().zip(at(reach - i)).zip(at(reach + i)) {
                *sum += tap * (a + b);
            }
        }
    })
}

/// The thresholds of MATLAB's `edge`: 64 bins up to the largest length; the high threshold is the
/// upper end of the bin at which more than 70 % of the pixels are reached.
fn choose(length: &Plane<f32>) -> (f32, f32) {
    let most = length.values().iter().copied().fold(0.0, f32::max);
    if most <= 0.0 {
        return (f32::INFINITY, f32::INFINITY);
    }
    let mut bins = [0_usize; BINS];
    for &value in length.values() {
        bins[((value / most * BINS as f32) as usize).min(BINS - 1)] += 1;
    }
    let enough = NOT_EDGES * length.values().len() as f64;
    let mut below = 0;
    let reached = bins.iter().position(|&n| {
        below += n;
        below as f64 > enough
    });
    let high = most * (reached.unwrap_or(BINS - 1) + 1) as f32 / BINS as f32;
    (LOW_TO_HIGH * high, high)
}

/// The lengths that are maxima along their gradient and reach `low`; 0 elsewhere and on the border.
fn thin(slope: &Plane<(f32, f32)>, length: &Plane<f32>, low: f32) -> Plane<f32> {
    let (width, height) = (length.size().width as usize, length.size().height);
    by_rows(length.size(), 0.0, |y, out| {
        if y == 0 || y + 1 == height {
            return;
        }
        let [above, here, below] = about(length, y);
        for x in 1..width.saturating_sub(1) {
            let value = here[x];
            // A gradient of 0 is no edge, however low the threshold.
            if value < low || value <= 0.0 {
                continue;
            }
            let (dx, dy) = slope.row(y)[x];
            // The line of the gradient leaves the pixel between a side neighbour and a diagonal
            // one, here and on the opposite side; `t` is how far it is on its way to the diagonal.
            let falls = (dx >= 0.0) == (dy >= 0.0);
            let (sides, t) = if dx.abs() >= dy.abs() {
                ([here[x + 1], here[x - 1]], dy.abs() / dx.abs())
            } else {
                ([below[x], above[x]], dx.abs() / dy.abs())
            };
            let diagonals = match (falls, dx.abs() >= dy.abs()) {
                (true, _) => [below[x + 1], above[x - 1]],
                (false, true) => [above[x + 1], below[x - 1]],
                (false, false) => [below[x - 1], above[x + 1]],
            };
            let peak = (0..2).all(|i| sides[i] * (1.0 - t) + diagonals[i] * t <= value);
            if peak {
                out[x] = value;
            }
        }
    })
}

/// The pixels of `ridge` above 0 that are joined, over eight neighbours, to one that reaches `high`.
fn grow(ridge: &Plane<f32>, high: f32) -> Mask {
    let size = ridge.size();
    let mut edges = Mask::new(size);
    let mut waiting = Vec::new();
    for y in 0..size.height {
        for x in 0..size.width {
            let value = ridge.at(x, y);
            if value > 0.0 && value >= high && !edges.contains(x, y) {
                edges.insert(x, y);
                waiting.push((x, y));
            }
            while let Some((x, y)) = waiting.pop() {
                for v in y.saturating_sub(1)..=(y + 1).min(size.height - 1) {
                    for u in x.saturating_sub(1)..=(x + 1).min(size.width - 1) {
                        if ridge.at(u, v) > 0.0 && edges.put(u, v) {
                            waiting.push((u, v));
                        }
                    }
                }
            }
        }
    }
    edges
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geom::Size;

    /// The distance from the centre of the [`disk`].
    pub(in crate::feature) fn from_centre(x: u32, y: u32) -> f64 {
        f64::from(x.abs_diff(30).pow(2) + y.abs_diff(24).pow(2)).sqrt()
    }

    /// A light disk with a radius of 15 pixels.
    pub(in crate::feature) fn disk() -> Plane<u8> {
        let pixel = |i: u32| if from_centre(i % 64, i / 64) < 15.0 { 190 } else { 60 };
        Plane::new(Size::new(64, 48), (0..64 * 48).map(pixel).collect()).expect("64 x 48")
    }

    #[test]
    fn the_edge_of_a_disk_is_one_thin_ring() {
        let edges = Canny::default().edges(&disk()).expect("the defaults are sound");
        // A ring of radius 15 has about 8/9 of its circumference in pixels.
        assert!((70..110).contains(&edges.len()), "{} pixels", edges.len());
        for (x, y) in edges.iter() {
            let r = from_centre(x, y);
            assert!((r - 15.0).abs() < 2.0, "({x}, {y}) is {r:.1} from the centre");
        }
    }

    #[test]
    fn a_flat_plane_has_no_edges() {
        for thresholds in [None, Some((0.0, 0.0))] {
            let canny = Canny { thresholds, ..Canny::default() };
            let edges = canny.edges(&Plane::filled(Size::new(40, 30), 128));
            assert!(edges.expect("in range").is_empty(), "{thresholds:?}");
        }
    }

    #[test]
    fn weak_edges_live_by_strong_ones() {
        // A vertical edge that fades from a step of 100 to one of 22, and one of 22 by itself.
        let pixel = |i: u32| match (i % 80, (i / 80) as u8) {
            (40..60, _) => 72,
            (20..40, y) => 150 - 2 * y,
            _ => 50,
        };
        let plane = Plane::new(Size::new(80, 40), (0..3200).map(pixel).collect()).expect("80 x 40");
        let rows = |low, high, column: u32| {
            let canny = Canny { sigma: 1.0, thresholds: Some((low, high)) };
            let edges = canny.edges(&plane).expect("in range");
            edges.iter().filter(|&(x, _)| x.abs_diff(column) < 3).count()
        };
        assert!(rows(20.0, 200.0, 20) >= 38, "followed to where it is weak");
        assert!((20..35).contains(&rows(100.0, 200.0, 20)), "given up where it is too weak");
        assert_eq!(rows(20.0, 200.0, 60), 0, "weak all along, and by itself");
        assert_eq!(rows(20.0, 1000.0, 20), 0, "nothing strong to start from");
    }

    #[test]
    fn the_smallest_planes_have_no_edges() {
        for (width, height) in [(1, 1), (2, 2), (1, 9), (9, 1)] {
            let size = Size::new(width, height);
            let values = (0..size.pixels()).map(|i| (i * 97 % 256) as u8).collect();
            let plane = Plane::new(size, values).expect("as many as pixels");
            assert!(Canny::default().edges(&plane).expect("in range").is_empty());
        }
    }

    #[test]
    fn fields_out_of_range_are_refused() {
        let plane = Plane::filled(Size::new(4, 4), 0);
        for (sigma, thresholds) in
            [(0.0, None), (17.0, None), (1.0, Some((2.0, 1.0))), (1.0, Some((f32::NAN, 1.0)))]
        {
            assert!(Canny { sigma, thresholds }.edges(&plane).is_err());
        }
    }
}
