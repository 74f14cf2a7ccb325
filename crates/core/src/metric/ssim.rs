//! Structural similarity (Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From Error
//! Visibility to Structural Similarity", IEEE TIP 13(4), 2004), with K1 0.01, K2 0.03 and range 255,
//! in the two forms of scikit-image's `structural_similarity`.
//!
//! Planes may be of rounded luma ([`Plane::luma`]: what `OpenCV` and Pillow call gray, and what
//! [`ssim`] and [`ssim_gaussian`] take) or of exact luma ([`Plane::exact_luma`]).

use crate::parallel::prelude::*;

use super::same_size;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::plane::Plane;

/// Rows that one task works through. Fixed, so that sums are added in one order on any number of
/// threads.
const BAND: usize = 32;

/// Side of the uniform window (scikit-image's default).
const UNIFORM: usize = 7;

/// Side of the Gaussian window: sigma 1.5 cut at 3.5 sigma, as Wang et al. have it.
const GAUSSIAN: usize = 11;

/// (K1 x range)^2 and (K2 x range)^2.
const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);

/// Mean structural similarity of the rounded luma of two frames, -1..1, by a uniform 7x7 window with
/// sample covariance; the border, where the window would leave the frame, is not counted.
///
/// # Errors
/// When the frames differ in size or are smaller than the window.
pub fn ssim(a: &Frame, b: &Frame) -> Result<f64> {
    ssim_of_planes(&Plane::luma(a), &Plane::luma(b))
}

/// Mean structural similarity of the rounded luma of two frames, -1..1, by a Gaussian window of
/// sigma 1.5, 11x11, with population covariance, as Wang et al. have it (scikit-image's
/// `gaussian_weights=True, use_sample_covariance=False`).
///
/// # Errors
/// When the frames differ in size or are smaller than the window.
pub fn ssim_gaussian(a: &Frame, b: &Frame) -> Result<f64> {
    ssim_gaussian_of_planes(&Plane::luma(a), &Plane::luma(b))
}

/// [`ssim`] of any two planes of values 0..255.
///
/// # Errors
/// When the planes differ in size or are smaller than the window.
pub fn ssim_of_planes<T>(a: &Plane<T>, b: &Plane<T>) -> Result<f64>
where
    T: Copy + Sync + Into<f64>,
{
    check(a, b, UNIFORM)?;
    let pixels = (UNIFORM * UNIFORM) as f64;
    let bessel = pixels / (pixels - 1.0);
    Ok(mean_over_bands(a, UNIFORM, |first, rows| {
        let mut columns = vec![Moments::default(); a.size().width as usize];
        for y in first..first + UNIFORM {
            weigh_row(&mut columns, a.row(y as u32), b.row(y as u32), 1.0);
        }
        let mut sum = 0.0;
        for y in first..first + rows {
            if y > first {
                let enters = (y + UNIFORM - 1) as u32;
                weigh_row(&mut columns, a.row(enters), b.row(enters), 1.0);
                weigh_row(&mut columns, a.row(y as u32 - 1), b.row(y as u32 - 1), -1.0);
            }
            let mut window = Moments::default();
            columns[..UNIFORM - 1].iter().for_each(|c| window.add(c, 1.0));
            for x in UNIFORM - 1..columns.len() {
                window.add(&columns[x], 1.0);
                sum += window.similarity(1.0 / pixels, bessel);
                window.add(&columns[x + 1 - UNIFORM], -1.0);
            }
        }
        sum
    }))
}

/// [`ssim_gaussian`] of any two planes of values 0..255.
///
/// # Errors
/// When the planes differ in size or are smaller than the window.
pub fn ssim_gaussian_of_planes<T>(a: &Plane<T>, b: &Plane<T>) -> Result<f64>
where
    T: Copy + Sync + Into<f64>,
{
    check(a, b, GAUSSIAN)?;
    let tap = |i: usize| (-((i as f64 - 5.0) / 1.5).powi(2) / 2.0).exp();
    let taps: [f64; GAUSSIAN] = std::array::from_fn(tap);
    let total: f64 = taps.iter().sum();
    let taps = taps.map(|t| t / total);
    Ok(mean_over_bands(a, GAUSSIAN, |first, rows| {
        let mut columns = vec![Moments::default(); a.size().width as usize];
        let mut sum = 0.0;
        for y in first..first + rows {
            columns.fill(Moments::default());
            for (i, &tap) in taps.iter().enumerate() {
                weigh_row(&mut columns, a.row((y + i) as u32), b.row((y + i) as u32), tap);
            }
            for window in columns.windows(GAUSSIAN) {
                let mut moments = Moments::default();
                window.iter().zip(&taps).for_each(|(c, &tap)| moments.add(c, tap));
                sum += moments.similarity(1.0, 1.0);
            }
        }
        sum
    }))
}

fn check<T: Copy>(a: &Plane<T>, b: &Plane<T>, window: usize) -> Result<()> {
    same_size(a.size(), b.size())?;
    if (a.size().width.min(a.size().height) as usize) < window {
        return Err(Error::TooSmall { size: a.size(), window });
    }
    Ok(())
}

/// The mean over all windows that lie in the frame, where `band(y, n)` adds up those whose top row
/// is `y` to `y + n - 1`.
fn mean_over_bands<T: Copy>(
    a: &Plane<T>,
    window: usize,
    band: impl Fn(usize, usize) -> f64 + Sync,
) -> f64 {
    let rows = a.size().height as usize + 1 - window;
    let columns = a.size().width as usize + 1 - window;
    let starts: Vec<usize> = (0..rows).step_by(BAND).collect();
    let sums: Vec<f64> =
        starts.par_iter().map(|&first| band(first, BAND.min(rows - first))).collect();
    sums.iter().sum::<f64>() / (rows * columns) as f64
}

/// Weighted sums of a, b, a^2, b^2 and ab. For whole values and weights they are exact.
#[derive(Clone, Copy, Default)]
struct Moments {
    a: f64,
    b: f64,
    aa: f64,
    bb: f64,
    ab: f64,
}

impl Moments {
    fn add(&mut self, o: &Self, weight: f64) {
        self.a += weight * o.a;
        self.b += weight * o.b;
        self.aa += weight * o.aa;
        self.bb += weight * o.bb;
        self.ab += weight * o.ab;
    }

    /// Equation 13 of Wang et al. from these sums, `scale` making means of them and `bessel`
    /// covariances of the kind wanted.
    fn similarity(&self, scale: f64, bessel: f64) -> f64 {
        let (a, b) = (self.a * scale, self.b * scale);
        let (aa, bb, ab) = (a * a, b * b, a * b);
        let variances = bessel * ((self.aa + self.bb) * scale - (aa + bb));
        let covariance = bessel * (self.ab * scale - ab);
        (2.0 * ab + C1) * (2.0 * covariance + C2) / ((aa + bb + C1) * (variances + C2))
    }
}

fn weigh_row<T: Copy + Into<f64>>(columns: &mut [Moments], a: &[T], b: &[T], weight: f64) {
    for ((sums, &a), &b) in columns.iter_mut().zip(a).zip(b) {
        let (a, b): (f64, f64) = (a.into(), b.into());
        sums.add(&Moments { a, b, aa: a * a, bb: b * b, ab: a * b }, weight);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};
    use crate::geom::Size;

    fn noise(size: Size, seed: u64) -> Plane<u8> {
        let pixels = (0..size.pixels() as u32).map(|i| rank(seed, Purpose::Noise, i, 0) as u8);
        Plane::new(size, pixels.collect()).expect("as many as pixels")
    }

    #[test]
    fn a_plane_is_like_itself_and_as_like_either_way_round() {
        let (a, b) = (noise(Size::new(70, 90), 1), noise(Size::new(70, 90), 2));
        assert_eq!(ssim_of_planes(&a, &a).expect("one size"), 1.0);
        assert!((ssim_gaussian_of_planes(&a, &a).expect("one size") - 1.0).abs() < 1e-12);
        let (ab, ba) = (ssim_of_planes(&a, &b), ssim_of_planes(&b, &a));
        assert_eq!(ab.expect("one size"), ba.expect("one size"));
        assert!(ssim_of_planes(&a, &b).expect("one size").abs() < 0.05);
    }

    #[test]
    fn flat_planes_differ_by_their_luminance_alone() {
        let size = Size::new(20, 20);
        let (a, b) = (Plane::filled(size, 100_u8), Plane::filled(size, 150_u8));
        let right = (2.0 * 100.0 * 150.0 + C1) / (100.0 * 100.0 + 150.0 * 150.0 + C1);
        assert!((ssim_of_planes(&a, &b).expect("one size") - right).abs() < 1e-12);
        assert!((ssim_gaussian_of_planes(&a, &b).expect("one size") - right).abs() < 1e-9);
    }

    #[test]
    fn sliding_is_summing_anew() {
        let (a, b) = (noise(Size::new(13, 80), 5), noise(Size::new(13, 80), 6));
        let mut sum = 0.0;
        for y in 0..=80 - UNIFORM as u32 {
            for x in 0..=13 - UNIFORM {
                let mut window = Moments::default();
                for v in y..y + UNIFORM as u32 {
                    for u in x..x + UNIFORM {
                        let (a, b) = (f64::from(a.row(v)[u]), f64::from(b.row(v)[u]));
                        window.add(&Moments { a, b, aa: a * a, bb: b * b, ab: a * b }, 1.0);
                    }
                }
                sum += window.similarity(1.0 / 49.0, 49.0 / 48.0);
            }
        }
        let mean = sum / (74.0 * 7.0);
        assert!((ssim_of_planes(&a, &b).expect("one size") - mean).abs() < 1e-12);
    }

    #[test]
    fn pictures_smaller_than_the_window_are_refused() {
        let small = Plane::filled(Size::new(6, 40), 0_u8);
        assert!(ssim_of_planes(&small, &small).is_err());
        let small = Plane::filled(Size::new(40, 10), 0_u8);
        assert!(ssim_of_planes(&small, &small).is_ok());
        assert!(ssim_gaussian_of_planes(&small, &small).is_err());
    }
}
