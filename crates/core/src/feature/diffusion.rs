//! Anisotropic diffusion: smooths within regions and leaves their edges (Perona and Malik,
//! "Scale-space and edge detection using anisotropic diffusion", IEEE PAMI 12(7), 1990), with their
//! first conductance, exp(-(d / kappa)^2), as medpy's `anisotropic_diffusion` with `option=1`.

use crate::parallel::prelude::*;

use crate::error::{Error, Result};
use crate::geom::Size;
use crate::plane::Plane;

/// Rows that one task works through.
const BAND: usize = 64;

/// Iterations of a band of rows between exchanges with its neighbours: it computes as many extra rows beyond its
/// border, which are discarded.
const STRIDE: u32 = 10;

/// Parameters of the diffusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffusion {
    /// Steps of time, at most 1000. Default 10.
    pub iterations: u32,
    /// Differences well above it count as edges and stay, those well below it are smoothed away;
    /// in steps of luma, above 0. Default 50 (medpy's).
    pub kappa: f32,
    /// Length of a step, above 0 and at most 0.25, beyond which the scheme is not stable (Perona
    /// and Malik, section V). Default 0.1 (medpy's).
    pub gamma: f32,
}

impl Default for Diffusion {
    fn default() -> Self {
        Self { iterations: 10, kappa: 50.0, gamma: 0.1 }
    }
}

impl Diffusion {
    /// `luma` after the diffusion, 0..255: 4 neighbours, nothing flows over the frame's border.
    ///
    /// # Errors
    /// When a field is out of its range.
    pub fn diffuse(&self, luma: &Plane<u8>) -> Result<Plane<f32>> {
        self.validate()?;
        let mut plane = luma.map(f32::from);
        if plane.size().pixels() == 0 {
            return Ok(plane);
        }
        let mut left = self.iterations;
        while left > 0 {
            let steps = left.min(STRIDE);
            plane = self.advance(&plane, steps);
            left -= steps;
        }
        Ok(plane)
    }

    fn validate(&self) -> Result<()> {
        let Self { iterations, kappa, gamma } = *self;
        if iterations > 1000 {
            return Err(Error::out_of_range("diffusion-iterations", iterations, "0 to 1000"));
        }
        if !(kappa > 0.0 && kappa.is_finite()) {
            return Err(Error::out_of_range("diffusion-kappa", kappa, "above 0"));
        }
        if !(gamma > 0.0 && gamma <= 0.25) {
            return Err(Error::out_of_range("diffusion-gamma", gamma, "above 0 and at most 0.25"));
        }
        Ok(())
    }

    /// `steps` iterations. The result does not depend on the division into bands.
    fn advance(&self, from: &Plane<f32>, steps: u32) -> Plane<f32> {
        let Size { width, height } = from.size();
        let (width, height) = (width as usize, height as usize);
        let halo = steps as usize;
        let mut to = Plane::filled(from.size(), 0.0);
        to.values_mut().par_chunks_mut(width * BAND).enumerate().for_each(|(band, out)| {
            let (first, end) = (band * BAND, band * BAND + out.len() / width);
            let (top, bottom) = (first.saturating_sub(halo), (end + halo).min(height));
            let mut rows = from.values()[top * width..bottom * width].to_vec();
            for _ in 0..steps {
                self.step(&mut rows, width);
            }
            out.copy_from_slice(&rows[(first - top) * width..(end - top) * width]);
        });
        to
    }

    /// One iteration in place: the flow between two rows is computed before either changes.
    fn step(&self, rows: &mut [f32], width: usize) {
        let flux = Flux::new(self.kappa);
        let mut above = vec![0.0; width];
        let mut below = vec![0.0; width];
        let mut right = vec![0.0; width];
        let mut rest = rows;
        while !rest.is_empty() {
            let (row, next) = rest.split_at_mut(width);
            if next.is_empty() {
                below.fill(0.0);
            } else {
                flux.between(row, &next[..width], &mut below);
            }
            flux.between(&row[..width - 1], &row[1..], &mut right[..width - 1]);
            let mut left = 0.0;
            for (((value, above), below), right) in
                row.iter_mut().zip(&above).zip(&below).zip(&right)
            {
                *value += self.gamma * ((below - above) + (right - left));
                left = *right;
            }
            std::mem::swap(&mut above, &mut below);
            rest = next;
        }
    }
}

/// The flow between neighbours with the difference d: d exp(-(d / kappa)^2).
struct Flux {
    /// -log2(e) / kappa^2, by which d^2 becomes a power of two.
    scale: f32,
}

impl Flux {
    fn new(kappa: f32) -> Self {
        Self { scale: -std::f32::consts::LOG2_E / (kappa * kappa) }
    }

    /// The flow from `there` to `here`, pixel by pixel.
    fn between(&self, here: &[f32], there: &[f32], out: &mut [f32]) {
        for ((out, here), there) in out.iter_mut().zip(here).zip(there) {
            let d = there - here;
            *out = d * exp2(d * d * self.scale);
        }
    }
}

/// 2 to the power of `x`, for `x` up to 0, to seven digits. The loop about it must compile to vector
/// instructions, which calls of the library's function would prevent.
fn exp2(x: f32) -> f32 {
    // Adding 1.5 x 2^23 leaves no bits for a fraction: the sum is rounded to the nearest whole
    // number, which stands in its lowest bits.
    const ROUND: f32 = 12_582_912.0;
    // Below 2^-126 there are no normal numbers; such a flow is 0.
    let x = if x > -126.0 { x } else { -126.0 };
    let rounded = x + ROUND;
    let f = x - (rounded - ROUND);
    // Taylor's series of 2^f, f within half of 0: its next term, (f ln 2)^7 / 7!, is below 2e-7.
    let power = 1.0
        + f * (std::f32::consts::LN_2
            + f * (0.240_226_5
                + f * (0.055_504_11
                    + f * (0.009_618_129 + f * (0.001_333_356 + f * 0.000_154_035)))));
    f32::from_bits(power.to_bits().wrapping_add(rounded.to_bits() << 23))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};

    fn noise(size: Size) -> Plane<u8> {
        let pixels = (0..size.pixels() as u32).map(|i| rank(3, Purpose::Noise, i, 0) as u8);
        Plane::new(size, pixels.collect()).expect("as many as pixels")
    }

    /// The definition, a pixel at a time, in 64 bits.
    fn plain(luma: &Plane<u8>, how: Diffusion) -> Vec<f64> {
        let Size { width, height } = luma.size();
        let (w, h) = (width as usize, height as usize);
        let mut now: Vec<f64> = luma.values().iter().map(|&v| f64::from(v)).collect();
        let flux = |d: f64| d * (-(d / f64::from(how.kappa)).powi(2)).exp();
        for _ in 0..how.iterations {
            let old = now.clone();
            for (i, value) in now.iter_mut().enumerate() {
                let (x, y) = (i % w, i / w);
                let mut sum = 0.0;
                let mut from = |inside: bool, j: usize| {
                    if inside {
                        sum += flux(old[j] - old[i]);
                    }
                };
                from(x > 0, i.wrapping_sub(1));
                from(x + 1 < w, i + 1);
                from(y > 0, i.wrapping_sub(w));
                from(y + 1 < h, i + w);
                *value += f64::from(how.gamma) * sum;
            }
        }
        now
    }

    #[test]
    fn bands_and_vectors_are_the_plain_definition() {
        for (width, height, iterations) in [(37, 200, 23), (1, 90, 5), (50, 1, 12), (1, 1, 3)] {
            let luma = noise(Size::new(width, height));
            let how = Diffusion { iterations, kappa: 60.0, gamma: 0.25 };
            let fast = how.diffuse(&luma).expect("fields in range");
            for (a, b) in fast.values().iter().zip(plain(&luma, how)) {
                assert!((f64::from(*a) - b).abs() < 2e-3, "{a} for {b}");
            }
        }
    }

    #[test]
    fn nothing_is_lost_and_extremes_shrink() {
        let luma = noise(Size::new(100, 150));
        let out = Diffusion::default().diffuse(&luma).expect("the defaults are sound");
        let before: f64 = luma.values().iter().map(|&v| f64::from(v)).sum();
        let after: f64 = out.values().iter().map(|&v| f64::from(v)).sum();
        assert!((before - after).abs() / before < 1e-6, "{before} became {after}");
        assert!(out.values().iter().all(|&v| (-1e-3..=255.001).contains(&v)));
    }

    #[test]
    fn an_edge_stays_where_ripples_go() {
        let size = Size::new(64, 8);
        let pixel = |i: usize| if i % 64 < 32 { 20 + (i % 2) as u8 * 6 } else { 220 };
        let luma = Plane::new(size, (0..size.pixels()).map(pixel).collect()).expect("64 x 8");
        let how = Diffusion { iterations: 40, kappa: 20.0, gamma: 0.2 };
        let out = how.diffuse(&luma).expect("fields in range");
        assert!(out.at(32, 4) - out.at(31, 4) > 190.0);
        assert!((out.at(10, 4) - out.at(11, 4)).abs() < 0.5);
    }

    #[test]
    fn the_power_is_the_librarys_to_seven_digits() {
        for i in 0..20_000 {
            let x = -(i as f32) * 0.005;
            let (fast, right) = (exp2(x), f64::from(x).exp2());
            assert!((f64::from(fast) / right - 1.0).abs() < 5e-7, "2^{x}: {fast}, not {right}");
        }
        assert!(exp2(-1e9) < 1e-37);
    }

    #[test]
    fn fields_out_of_range_are_refused() {
        let luma = Plane::filled(Size::new(4, 4), 0);
        let refused = |how: Diffusion| how.diffuse(&luma).is_err();
        assert!(refused(Diffusion { kappa: 0.0, ..Diffusion::default() }));
        assert!(refused(Diffusion { kappa: f32::NAN, ..Diffusion::default() }));
        assert!(refused(Diffusion { gamma: 0.3, ..Diffusion::default() }));
        assert!(refused(Diffusion { iterations: 1001, ..Diffusion::default() }));
    }
}
