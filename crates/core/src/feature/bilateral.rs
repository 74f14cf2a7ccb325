//! The bilateral filter (Tomasi and Manduchi, "Bilateral Filtering for Gray and Color Images", ICCV 1998), in the form
//! of `OpenCV`'s `bilateralFilter`: smooths what differs little, and keeps edges.

use super::edges::mirrored;
use crate::error::{Error, Result};
use crate::frame::{Frame, Rgba};
use crate::parallel::prelude::*;

/// Parameters of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bilateral {
    /// Diameter of the disk of neighbours in pixels, odd, 3 to 31. Default 9, the largest that `OpenCV`'s manual
    /// recommends for interactive use.
    pub diameter: u32,
    /// Standard deviation in colour, the sum of the differences of red, green and blue, above 0. Default 75 (the manual
    /// calls 10 weak and 150 a cartoon).
    pub sigma_colour: f32,
    /// Standard deviation in space, in pixels, above 0. Default 75: nearly the same weight all over the disk.
    pub sigma_space: f32,
}

impl Default for Bilateral {
    fn default() -> Self {
        Self { diameter: 9, sigma_colour: 75.0, sigma_space: 75.0 }
    }
}

/// The largest sum of the differences of red, green and blue.
const MOST: usize = 3 * 255;

impl Bilateral {
    /// `frame` under the filter; alpha stays. The border is mirrored about its pixels.
    ///
    /// # Errors
    /// When a field is out of its range.
    pub fn smooth(&self, frame: &Frame) -> Result<Frame> {
        let Self { diameter, sigma_colour, sigma_space } = *self;
        if !(3..=31).contains(&diameter) || diameter.is_multiple_of(2) {
            return Err(Error::out_of_range("bilateral-diameter", diameter, "odd, 3 to 31"));
        }
        for (name, sigma) in
            [("bilateral-sigma-colour", sigma_colour), ("bilateral-sigma-space", sigma_space)]
        {
            if !(sigma > 0.0 && sigma.is_finite()) {
                return Err(Error::out_of_range(name, sigma, "above 0"));
            }
        }
        let weight = |d: f32, sigma: f32| (-(d / sigma).powi(2) / 2.0).exp();
        let by_colour: Vec<f32> = (0..=MOST).map(|d| weight(d as f32, sigma_colour)).collect();
        let radius = (diameter / 2) as usize;
        let disk = disk(radius, |d| weight(d, sigma_space));
        let size = frame.size();
        let columns = mirrored(size.width, radius);
        let rows = mirrored(size.height, radius);
        let mut pixels = vec![[0; 4]; size.pixels()];
        let lines = pixels.par_chunks_mut(size.width.max(1) as usize).enumerate();
        lines.for_each(|(y, out)| {
            let near: Vec<_> =
                rows[y..=y + 2 * radius].iter().map(|&y| frame.row(y as u32)).collect();
            for (x, pixel) in out.iter_mut().enumerate() {
                let columns = &columns[x..=x + 2 * radius];
                *pixel = mean(near[radius][x], &near, columns, &disk, &by_colour);
            }
        });
        Frame::known(size, pixels, frame.is_opaque())
    }
}

/// A neighbour: its row and column from the upper left of the square about the disk, and its weight.
type Neighbour = (usize, usize, f32);

/// The neighbours within `radius`.
fn disk(radius: usize, weight: impl Fn(f32) -> f32) -> Vec<Neighbour> {
    let mut disk = Vec::new();
    for row in 0..=2 * radius {
        for column in 0..=2 * radius {
            let far = (row.abs_diff(radius).pow(2) + column.abs_diff(radius).pow(2)) as f32;
            if far.sqrt() <= radius as f32 {
                disk.push((row, column, weight(far.sqrt())));
            }
        }
    }
    disk
}

/// The weighted mean of the pixels about `centre`, in these `rows` and `columns`.
fn mean(
    centre: Rgba,
    rows: &[&[Rgba]],
    columns: &[usize],
    disk: &[Neighbour],
    by_colour: &[f32],
) -> Rgba {
    let (mut sums, mut total) = ([0.0f32; 3], 0.0f32);
    for &(row, column, near) in disk {
        let pixel = rows[row][columns[column]];
        let differs = |c: usize| usize::from(pixel[c].abs_diff(centre[c]));
        let weight = near * by_colour[differs(0) + differs(1) + differs(2)];
        (0..3).for_each(|c| sums[c] += weight * f32::from(pixel[c]));
        total += weight;
    }
    // The centre has a weight of its own.
    let [r, g, b] = sums.map(|sum| (sum / total + 0.5) as u8);
    [r, g, b, centre[3]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};
    use crate::geom::Size;

    #[test]
    fn grain_goes_and_edges_stay() {
        let size = Size::new(40, 20);
        let pixel = |i: u32| {
            let grain = (rank(4, Purpose::Noise, i, 0) % 9) as u8;
            let v = if i % 40 < 20 { 40 } else { 180 } + grain;
            [v, v, v, 255]
        };
        let frame = Frame::new(size, (0..800).map(pixel).collect()).expect("small");
        let filter = Bilateral { sigma_colour: 40.0, ..Bilateral::default() };
        let smooth = filter.smooth(&frame).expect("in range");
        let spread = |frame: &Frame, columns: std::ops::Range<u32>| {
            let values: Vec<u8> = (0..20)
                .flat_map(|y| columns.clone().map(move |x| (x, y)))
                .map(|(x, y)| frame.at(x, y)[0])
                .collect();
            values.iter().max().expect("some") - values.iter().min().expect("some")
        };
        assert!(spread(&frame, 0..20) == 8 && spread(&smooth, 0..20) <= 4);
        assert!(spread(&smooth, 20..40) <= 4 && spread(&smooth, 19..21) > 120);
    }

    #[test]
    fn flat_frames_of_any_size_stay() {
        for (width, height) in [(1, 1), (2, 1), (1, 9), (30, 3)] {
            let flat = Frame::filled(Size::new(width, height), [9, 80, 200, 77]).expect("flat");
            assert_eq!(Bilateral::default().smooth(&flat).expect("in range"), flat);
        }
    }

    #[test]
    fn fields_out_of_range_are_refused() {
        let flat = Frame::filled(Size::new(4, 4), [0, 0, 0, 255]).expect("flat");
        let wrong = [
            Bilateral { diameter: 4, ..Bilateral::default() },
            Bilateral { diameter: 33, ..Bilateral::default() },
            Bilateral { sigma_colour: 0.0, ..Bilateral::default() },
            Bilateral { sigma_space: f32::NAN, ..Bilateral::default() },
        ];
        assert!(wrong.iter().all(|filter| filter.smooth(&flat).is_err()));
    }
}
