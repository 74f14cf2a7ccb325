//! CIE L*a*b*: colours in which equal distances look about equally different.

use std::sync::OnceLock;

use crate::parallel::prelude::*;

use crate::frame::{Frame, Rgba};

/// Steps in one unit of L*, a* or b*. Whole steps make sums exact.
pub(super) const STEPS: f32 = 128.0;

/// Entries of the table of the cube root: fine enough for half a step of L* in all but the blackest.
const ROOTS: usize = 1 << 14;

/// L*, a* and b* of a frame's pixels, row by row, each in whole steps of 1/128.
#[derive(Clone, Debug)]
pub(super) struct Lab {
    pub(super) channels: [Vec<i16>; 3],
}

impl Lab {
    /// The pixels of `frame` taken as sRGB, white being D65 (IEC 61966-2-1; CIE 15).
    pub(super) fn of(frame: &Frame) -> Self {
        let tables = Tables::new();
        let pixels: Vec<[i16; 3]> = frame
            .pixels()
            .par_iter()
            .with_min_len(1 << 14)
            .map(|&[r, g, b, _]| tables.lab([r, g, b]))
            .collect();
        let channel = |c: usize| pixels.par_iter().with_min_len(1 << 14).map(|p| p[c]).collect();
        Self { channels: [channel(0), channel(1), channel(2)] }
    }

    /// L* of the pixels of `frame`, 0..255 in place of 0..100.
    pub(super) fn lightness(frame: &Frame) -> Vec<u8> {
        let tables = Tables::new();
        let byte =
            |&[r, g, b, _]: &Rgba| (f32::from(tables.lab([r, g, b])[0]) / STEPS * 2.55 + 0.5) as u8;
        frame.pixels().par_iter().with_min_len(1 << 14).map(byte).collect()
    }
}

struct Tables {
    linear: [f32; 256],
    root: Vec<f32>,
}

impl Tables {
    fn new() -> Self {
        let linear = |i: usize| {
            let v = i as f64 / 255.0;
            (if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }) as f32
        };
        // CIE 15: the cube root, and a straight line below (6/29)^3.
        let root = |i: usize| {
            let t = i as f64 / (ROOTS - 1) as f64;
            let edge = 6.0_f64 / 29.0;
            let f = if t > edge.powi(3) { t.cbrt() } else { t / (3.0 * edge * edge) + 4.0 / 29.0 };
            f as f32
        };
        Self { linear: std::array::from_fn(linear), root: (0..ROOTS).map(root).collect() }
    }

    fn lab(&self, rgb: [u8; 3]) -> [i16; 3] {
        let [r, g, b] = rgb.map(|v| self.linear[v as usize]);
        let f = |t: f32| self.root[((t * (ROOTS - 1) as f32 + 0.5) as usize).min(ROOTS - 1)];
        let x = f((0.412_456_4 * r + 0.357_576_1 * g + 0.180_437_5 * b) / 0.950_47);
        let y = f(0.212_672_9 * r + 0.715_152_2 * g + 0.072_175 * b);
        let z = f((0.019_333_9 * r + 0.119_192 * g + 0.950_304_1 * b) / 1.088_83);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)].map(|v| (v * STEPS).round() as i16)
    }
}

/// Made when they are first asked for.
static TABLES: OnceLock<Tables> = OnceLock::new();

/// L*, a* and b* of a colour, whatever its alpha, in whole steps of 1/128.
pub(crate) fn of([r, g, b, _]: Rgba) -> [f64; 3] {
    TABLES.get_or_init(Tables::new).lab([r, g, b]).map(|v| f64::from(v) / f64::from(STEPS))
}

/// The colour of L*, a* and b*, channels clamped.
pub(crate) fn to_rgb([lightness, a, b]: [f64; 3]) -> [u8; 3] {
    let y = (lightness + 16.0) / 116.0;
    let cubed = |f: f64| {
        let edge = 6.0 / 29.0;
        if f > edge { f * f * f } else { 3.0 * edge * edge * (f - 4.0 / 29.0) }
    };
    let (x, z) = (cubed(y + a / 500.0) * 0.950_47, cubed(y - b / 200.0) * 1.088_83);
    let y = cubed(y);
    let linear = [
        3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        -0.969_266 * x + 1.876_010_8 * y + 0.041_556 * z,
        0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    ];
    let table = &TABLES.get_or_init(Tables::new).linear;
    // The nearest entry: no power has to be the same on all machines.
    linear.map(|v| {
        let v = v as f32;
        let above = table.partition_point(|&entry| entry < v).min(255);
        let below = above.saturating_sub(1);
        (if v - table[below] < table[above] - v { below } else { above }) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_where_the_field_has_them() {
        // skimage.color.rgb2lab of these colours (scikit-image 0.26.0).
        for (rgb, lab) in [
            ([255, 255, 255], [100.0, 0.0, 0.0]),
            ([0, 0, 0], [0.0, 0.0, 0.0]),
            ([255, 0, 0], [53.24, 80.09, 67.20]),
            ([0, 255, 0], [87.73, -86.18, 83.18]),
            ([0, 0, 255], [32.30, 79.19, -107.86]),
            ([120, 90, 200], [46.28, 37.73, -53.31]),
        ] {
            let found = Tables::new().lab(rgb).map(|v| f32::from(v) / STEPS);
            for (f, l) in found.iter().zip(lab) {
                assert!((f - l).abs() < 0.25, "{rgb:?}: {found:?}, not {lab:?}");
            }
        }
    }

    #[test]
    fn colours_come_back() {
        for i in 0..4096u32 {
            let rgb = [i * 16 % 256, i / 16 % 16 * 17, i / 256 * 17].map(|v| v as u8);
            let back = to_rgb(of([rgb[0], rgb[1], rgb[2], 255]));
            // The table of roots is coarse near black.
            assert!((0..3).all(|c| back[c].abs_diff(rgb[c]) <= 3), "{rgb:?} {back:?}");
        }
    }
}
