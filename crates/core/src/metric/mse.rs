//! Mean squared error and the peak signal-to-noise ratio that it stands for.

use crate::parallel::prelude::*;

use super::same_size;
use crate::error::Result;
use crate::frame::Frame;

/// Mean over all pixels and the channels R, G and B of the squared difference, 0..65025; alpha is
/// ignored. As scikit-image's `mean_squared_error` on the RGB arrays.
///
/// # Errors
/// When the frames differ in size.
pub fn mse(a: &Frame, b: &Frame) -> Result<f64> {
    same_size(a.size(), b.size())?;
    let pairs = a.pixels().par_iter().zip(b.pixels()).with_min_len(1 << 14);
    let sum: u64 = pairs
        .map(|(p, q)| {
            let square = |c: usize| u64::from(u32::from(p[c].abs_diff(q[c])).pow(2));
            square(0) + square(1) + square(2)
        })
        .sum();
    Ok(sum as f64 / (3 * a.size().pixels()) as f64)
}

/// Peak signal-to-noise ratio in decibels of a mean squared error of 8-bit values:
/// 10 log10(255^2 / mse); infinite for equal pictures.
pub fn psnr(mse: f64) -> f64 {
    10.0 * (255.0 * 255.0 / mse).log10()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;

    #[test]
    fn a_constant_difference_is_its_square() {
        let size = Size::new(300, 200);
        let a = Frame::filled(size, [10, 20, 30, 255]).expect("a sound size");
        let b = Frame::filled(size, [13, 16, 30, 0]).expect("a sound size");
        assert_eq!(mse(&a, &b).expect("one size"), (9.0 + 16.0) / 3.0);
        assert_eq!(psnr(mse(&a, &a).expect("one size")), f64::INFINITY);
        assert!((psnr(65025.0 / 100.0) - 20.0).abs() < 1e-12);
    }

    #[test]
    fn sizes_must_agree() {
        let a = Frame::filled(Size::new(2, 3), [0; 4]).expect("a sound size");
        let b = Frame::filled(Size::new(3, 2), [0; 4]).expect("a sound size");
        assert!(mse(&a, &b).is_err());
    }
}
