//! Saliency by the spectral residual (Hou and Zhang, "Saliency Detection: A Spectral Residual
//! Approach", CVPR 2007), in the form of `OpenCV`'s `StaticSaliencySpectralResidual`.

use super::edges::mirrored;
use crate::parallel::prelude::*;
use rustfft::algorithm::Radix4;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftDirection};

use crate::geom::Size;
use crate::plane::Plane;

/// Side of the square on which the spectrum is taken (Hou and Zhang, section 2.2).
const SIDE: usize = 64;

/// An amplitude below it is rounding of the transform, not signal: those of 8-bit values sum to
/// less than 2^20 and carry errors around 1e-10.
const NO_AMPLITUDE: f64 = 1e-6;

/// The square of values on which the method works.
type Square = [f64; SIDE * SIDE];

/// The saliency of each pixel, 0..1; the largest value of the small map is 1.
///
/// A constant plane has 1 everywhere.
pub fn saliency(luma: &Plane<u8>) -> Plane<f32> {
    if luma.size().pixels() == 0 {
        return Plane::filled(luma.size(), 1.0);
    }
    let small = shrink(luma);
    if small.iter().all(|&v| v == small[0]) {
        return Plane::filled(luma.size(), 1.0);
    }
    let mut map = smooth(&residual(&small));
    map.iter_mut().for_each(|v| *v *= *v);
    let most = map.iter().copied().fold(0.0, f64::max);
    if most <= 0.0 {
        return Plane::filled(luma.size(), 1.0);
    }
    let map: Vec<f32> = map.iter().map(|v| (v / most) as f32).collect();
    enlarge(&map, luma.size())
}

/// A position between two neighbouring samples.
#[derive(Clone, Copy)]
struct Between {
    low: usize,
    high: usize,
    /// Weight of `high`, 0..1.
    weight: f32,
}

/// For each of `to` samples its position among `from` samples over the same length; beyond the first and the last
/// centre that of the end sample.
fn places(from: usize, to: usize) -> Vec<Between> {
    let scale = from as f64 / to as f64;
    (0..to)
        .map(|i| {
            let at = ((i as f64 + 0.5) * scale - 0.5).clamp(0.0, from as f64 - 1.0);
            let low = at as usize;
            Between { low, high: (low + 1).min(from - 1), weight: (at - low as f64) as f32 }
        })
        .collect()
}

/// The plane sampled at the centres of a 64x64 grid, bilinear, rounded to whole values as the
/// reference's 8-bit resize does.
fn shrink(luma: &Plane<u8>) -> Square {
    let Size { width, height } = luma.size();
    let columns = places(width as usize, SIDE);
    let rows = places(height as usize, SIDE);
    let mut small = [0.0; SIDE * SIDE];
    for (line, y) in small.chunks_exact_mut(SIDE).zip(&rows) {
        let (top, bottom) = (luma.row(y.low as u32), luma.row(y.high as u32));
        for (value, x) in line.iter_mut().zip(&columns) {
            let mix = |row: &[u8]| {
                let (a, b) = (f64::from(row[x.low]), f64::from(row[x.high]));
                a + (b - a) * f64::from(x.weight)
            };
            let (a, b) = (mix(top), mix(bottom));
            *value = (a + (b - a) * f64::from(y.weight)).round();
        }
    }
    small
}

/// The magnitude of the picture whose log amplitude is the spectral residual of `small`, and whose
/// phase is that of `small`.
fn residual(small: &Square) -> Square {
    let mut spectrum: Vec<Complex<f64>> = small.iter().map(|&v| Complex::new(v, 0.0)).collect();
    transform(FftDirection::Forward, &mut spectrum);
    let mut log_amplitude = [0.0; SIDE * SIDE];
    for (log, value) in log_amplitude.iter_mut().zip(&spectrum) {
        *log = value.norm().max(NO_AMPLITUDE).ln();
    }
    let mean = filter(&log_amplitude, &[1.0 / 3.0; 3]);
    for ((value, log), mean) in spectrum.iter_mut().zip(&log_amplitude).zip(&mean) {
        let amplitude = value.norm();
        // A frequency of amplitude 0 has no phase and stays 0.
        let gain = if amplitude < NO_AMPLITUDE { 0.0 } else { (log - mean).exp() / amplitude };
        *value *= gain;
    }
    transform(FftDirection::Inverse, &mut spectrum);
    std::array::from_fn(|i| spectrum[i].norm())
}

/// The two-dimensional transform: rows, then columns by way of two transpositions.
///
/// One plain algorithm, not the planner: the planner brings code for every length and instruction set (half of the
/// time that this crate took to build), and its result depends on the processor.
fn transform(direction: FftDirection, data: &mut [Complex<f64>]) {
    let fft = Radix4::new(SIDE, direction);
    for _ in 0..2 {
        fft.process(data);
        for y in 0..SIDE {
            for x in 0..y {
                data.swap(y * SIDE + x, x * SIDE + y);
            }
        }
    }
}

/// The 5x5 Gaussian of sigma 8 with which the reference softens the map.
fn smooth(map: &Square) -> Square {
    let tap = |d: f64| (-d * d / (2.0 * 8.0 * 8.0)).exp();
    let taps = [tap(2.0), tap(1.0), 1.0, tap(1.0), tap(2.0)];
    let sum: f64 = taps.iter().sum();
    filter(map, &taps.map(|t| t / sum))
}

/// `map` filtered with `taps` along rows and columns, mirrored at the border without repeating the
/// border itself (reflect-101).
fn filter(map: &Square, taps: &[f64]) -> Square {
    let mirrored = mirrored(SIDE as u32, taps.len() / 2);
    let along = |from: &Square, place: fn(usize, usize) -> usize| -> Square {
        let mut out = [0.0; SIDE * SIDE];
        for i in 0..SIDE {
            for j in 0..SIDE {
                out[place(i, j)] = taps
                    .iter()
                    .enumerate()
                    .map(|(t, tap)| tap * from[place(mirrored[i + t], j)])
                    .sum();
            }
        }
        out
    };
    along(&along(map, |i, j| j * SIDE + i), |i, j| i * SIDE + j)
}

/// The small map over a frame of `size`, bilinear.
fn enlarge(map: &[f32], size: Size) -> Plane<f32> {
    let columns = places(SIDE, size.width as usize);
    let rows = places(SIDE, size.height as usize);
    let mut out = Plane::filled(size, 0.0);
    let lines = out.values_mut().par_chunks_exact_mut(size.width as usize);
    lines.zip(&rows).for_each(|(line, y)| {
        let top = &map[y.low * SIDE..][..SIDE];
        let bottom = &map[y.high * SIDE..][..SIDE];
        let mixed: [f32; SIDE] = std::array::from_fn(|i| top[i] + (bottom[i] - top[i]) * y.weight);
        for (value, x) in line.iter_mut().zip(&columns) {
            let (a, b) = (mixed[x.low], mixed[x.high]);
            *value = a + (b - a) * x.weight;
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};

    #[test]
    fn a_flat_plane_gives_a_uniform_map() {
        for value in [0, 7, 255] {
            let map = saliency(&Plane::filled(Size::new(90, 70), value));
            assert!(map.values().iter().all(|&v| v == 1.0), "flat {value}");
        }
    }

    #[test]
    fn a_lone_spot_stands_out() {
        // On a ground with some texture: a perfect rectangle on nothing has a spectrum full of
        // zeros, whose residual means little.
        let spot = |x: u32, y: u32| x.abs_diff(188).pow(2) + y.abs_diff(46).pow(2) < 64;
        let ground = |x: u32, y: u32| 40 + (rank(1, Purpose::Noise, x / 4, y / 4) % 16) as u8;
        let pixel = |i: u32| (i % 256, i / 256);
        let value = |(x, y)| if spot(x, y) { 220 } else { ground(x, y) };
        let values = (0..256 * 192).map(|i| value(pixel(i))).collect();
        let luma = Plane::new(Size::new(256, 192), values).expect("256 x 192 values");
        let map = saliency(&luma);
        assert!(map.values().iter().all(|v| (0.0..=1.0).contains(v)));
        let best = (0..256 * 192).max_by(|&a, &b| map.values()[a].total_cmp(&map.values()[b]));
        let (x, y) = best.map(|i| (i % 256, i / 256)).expect("a map has pixels");
        assert!((176..200).contains(&x) && (36..56).contains(&y), "found at {x}, {y}");
    }

    #[test]
    fn every_size_down_to_one_pixel_has_a_finite_map() {
        for (width, height) in [(1, 1), (1, 9), (300, 1), (64, 64), (63, 65)] {
            let size = Size::new(width, height);
            let values = (0..size.pixels()).map(|i| (i * 89 % 251) as u8).collect();
            let map = saliency(&Plane::new(size, values).expect("as many as pixels"));
            assert!(map.values().iter().all(|v| v.is_finite() && *v >= 0.0), "{size}");
        }
    }

    #[test]
    fn stripes_leave_no_amplitude_but_a_finite_map() {
        let size = Size::new(128, 128);
        let values = (0..size.pixels()).map(|i| if i % 8 < 4 { 0 } else { 255 }).collect();
        let map = saliency(&Plane::new(size, values).expect("as many as pixels"));
        assert!(map.values().iter().all(|v| v.is_finite()));
    }
}
