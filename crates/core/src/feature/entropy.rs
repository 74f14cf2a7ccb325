//! Local entropy of luma in bits. The window is a disk that is clipped at the border of the frame, as in
//! scikit-image's `filters.rank.entropy`.

use crate::parallel::prelude::*;

use crate::error::{Error, Result};
use crate::geom::Size;
use crate::plane::Plane;

/// The radius of the disk in the paper's HELP.
pub const DEFAULT_RADIUS: u32 = 5;

/// The largest radius that [`entropy`] takes.
pub const MAX_RADIUS: u32 = 32;

/// Fraction bits of the sums of count x log2 count. They are added and subtracted as the window moves; whole numbers
/// give the same sum whatever its path.
const FRACTION: u32 = 32;

/// Rows that one task works through.
const BAND: usize = 16;

/// Base-2 entropy of the histogram of `luma` within `radius` of each pixel, in bits: 0 where all
/// values are one, log2 of the window's pixels where all differ.
///
/// The histogram slides along the row: one pixel enters and one leaves for each row of the disk
/// (Huang, Yang and Tang, "A fast two-dimensional median filtering algorithm", 1979).
///
/// # Errors
/// When `radius` is not 1..=32.
pub fn entropy(luma: &Plane<u8>, radius: u32) -> Result<Plane<f32>> {
    if !(1..=MAX_RADIUS).contains(&radius) {
        return Err(Error::out_of_range("entropy-radius", radius, format!("1 to {MAX_RADIUS}")));
    }
    let disk = Disk::new(radius);
    let tables = Tables::new(disk.area());
    let width = luma.size().width as usize;
    let mut out = Plane::filled(luma.size(), 0.0);
    if width > 0 {
        let bands = out.values_mut().par_chunks_mut(width * BAND).enumerate();
        bands.for_each(|(band, values)| {
            let mut window = Window::new(&tables);
            for (i, line) in values.chunks_exact_mut(width).enumerate() {
                slide(luma, (band * BAND + i) as u32, &disk, &mut window, line);
            }
        });
    }
    Ok(out)
}

/// The pixels within a radius: half a width for each row, from the top one down.
struct Disk {
    radius: u32,
    half_widths: Vec<u32>,
}

impl Disk {
    fn new(radius: u32) -> Self {
        let half_width = |dy: u32| (radius * radius - dy * dy).isqrt();
        let half_widths = (0..=2 * radius).map(|i| half_width(i.abs_diff(radius))).collect();
        Self { radius, half_widths }
    }

    fn area(&self) -> usize {
        self.half_widths.iter().map(|h| 2 * *h as usize + 1).sum()
    }

    /// The rows of the disk about row `y` that lie in the frame: each with its half width.
    fn rows<'a>(&self, luma: &'a Plane<u8>, y: u32) -> Vec<(&'a [u8], usize)> {
        let rows = self.half_widths.iter().zip(0..);
        rows.filter_map(|(&half, i)| {
            let row = (y + i).checked_sub(self.radius).filter(|&r| r < luma.size().height)?;
            Some((luma.row(row), half as usize))
        })
        .collect()
    }
}

/// Terms of the entropy of a window of n pixels: (n log2 n - sum of count x log2 count) / n.
struct Tables {
    /// `i` x log2 `i`.
    part: Vec<i64>,
    /// Its increment from `i` to `i + 1`.
    growth: Vec<i64>,
}

impl Tables {
    fn new(area: usize) -> Self {
        let part = |count: usize| {
            let count = count as f64;
            let bits = if count > 0.0 { count * count.log2() } else { 0.0 };
            (bits * (1_u64 << FRACTION) as f64).round() as i64
        };
        let part: Vec<i64> = (0..=area).map(part).collect();
        let growth = part.windows(2).map(|pair| pair[1] - pair[0]).collect();
        Self { part, growth }
    }
}

/// The histogram of a window that grows and shrinks by single pixels.
struct Window<'a> {
    tables: &'a Tables,
    counts: [u32; 256],
    pixels: usize,
    sum: i64,
}

impl<'a> Window<'a> {
    fn new(tables: &'a Tables) -> Self {
        Self { tables, counts: [0; 256], pixels: 0, sum: 0 }
    }

    fn clear(&mut self) {
        self.counts = [0; 256];
        self.pixels = 0;
        self.sum = 0;
    }

    fn add(&mut self, value: u8) {
        let count = &mut self.counts[value as usize];
        self.sum += self.tables.growth[*count as usize];
        *count += 1;
        self.pixels += 1;
    }

    fn remove(&mut self, value: u8) {
        let count = &mut self.counts[value as usize];
        *count -= 1;
        self.sum -= self.tables.growth[*count as usize];
        self.pixels -= 1;
    }

    fn bits(&self) -> f32 {
        let bits = (self.tables.part[self.pixels] - self.sum) as f64 / self.pixels as f64;
        (bits / (1_u64 << FRACTION) as f64) as f32
    }
}

/// The entropies of row `y`.
fn slide(luma: &Plane<u8>, y: u32, disk: &Disk, window: &mut Window, line: &mut [f32]) {
    let rows = disk.rows(luma, y);
    let reach = disk.radius as usize;
    window.clear();
    for (row, half) in &rows {
        row.iter().take(half + 1).for_each(|&value| window.add(value));
    }
    line[0] = window.bits();
    for x in 1..line.len() {
        if x > reach && x + reach < line.len() {
            for &(row, half) in &rows {
                let (enters, leaves) = (row[x + half], row[x - half - 1]);
                if enters != leaves {
                    window.remove(leaves);
                    window.add(enters);
                }
            }
        } else {
            for &(row, half) in &rows {
                // Pixels are removed first, so that no count exceeds the disk's area.
                if x > half {
                    window.remove(row[x - half - 1]);
                }
                row.get(x + half).into_iter().for_each(|&value| window.add(value));
            }
        }
        line[x] = window.bits();
    }
}

/// [`entropy`] by counting every window anew: slow, and plainly right.
pub fn entropy_by_counting(luma: &Plane<u8>, radius: u32) -> Plane<f32> {
    let Size { width, height } = luma.size();
    let mut out = Plane::filled(luma.size(), 0.0);
    for (i, value) in out.values_mut().iter_mut().enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        let mut counts = [0_u32; 256];
        for v in y.saturating_sub(radius)..=(y + radius).min(height - 1) {
            for u in x.saturating_sub(radius)..=(x + radius).min(width - 1) {
                if u.abs_diff(x).pow(2) + v.abs_diff(y).pow(2) <= radius * radius {
                    counts[luma.at(u, v) as usize] += 1;
                }
            }
        }
        let pixels = f64::from(counts.iter().sum::<u32>());
        let share = |&count: &u32| f64::from(count) / pixels;
        *value = counts.iter().filter(|&&c| c > 0).map(|c| -share(c) * share(c).log2()).sum::<f64>()
            as f32;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};
    use proptest::prelude::*;

    fn noise(size: Size, seed: u64, levels: u64) -> Plane<u8> {
        let pixels = (0..size.pixels() as u32).map(|i| rank(seed, Purpose::Noise, i, 0) % levels);
        Plane::new(size, pixels.map(|v| v as u8).collect()).expect("as many as pixels")
    }

    proptest! {
        #[test]
        fn sliding_is_counting(
            width in 1_u32..50, height in 1_u32..40, radius in 1_u32..9, seed in 0_u64..99,
            levels in 1_u64..=256,
        ) {
            let luma = noise(Size::new(width, height), seed, levels);
            let slid = entropy(&luma, radius).expect("a radius in range");
            let counted = entropy_by_counting(&luma, radius);
            for (a, b) in slid.values().iter().zip(counted.values()) {
                prop_assert!((a - b).abs() < 2e-6, "{a} for {b}");
            }
        }
    }

    #[test]
    fn the_largest_disk_fits_the_tables() {
        let luma = noise(Size::new(80, 70), 1, 256);
        let slid = entropy(&luma, MAX_RADIUS).expect("the largest radius");
        let counted = entropy_by_counting(&luma, MAX_RADIUS);
        for (a, b) in slid.values().iter().zip(counted.values()) {
            assert!((a - b).abs() < 2e-6, "{a} for {b}");
        }
    }

    #[test]
    fn one_value_carries_nothing() {
        let bits = entropy(&Plane::filled(Size::new(40, 30), 9), 5).expect("a radius in range");
        assert!(bits.values().iter().all(|&v| v == 0.0));
    }

    #[test]
    fn a_radius_out_of_range_is_refused() {
        let luma = Plane::filled(Size::new(4, 4), 0);
        assert!(entropy(&luma, 0).is_err() && entropy(&luma, 33).is_err());
    }
}
