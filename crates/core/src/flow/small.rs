//! Downscaled luma, in which motion and cuts are found.

use crate::parallel::prelude::*;

use super::patch::PATCH;
use crate::colour::Planes;
use crate::frame::Frame;
use crate::geom::Size;
use crate::plane::Plane;
use crate::simd::dispatch;

/// The longest side of a small picture. A small pixel is the mean of a whole number of pixels.
const SMALL_SIDE: u32 = 480;

/// Levels of the pyramid: the coarsest patch is 32 small pixels wide, and finds moves of as many.
const LEVELS: usize = 3;

/// A downscaled frame: means of the luma of `factor` x `factor` pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Small {
    /// Side of a small pixel in pixels of the frame.
    pub factor: u32,
    /// The frame's size.
    pub size: Size,
    /// The mean lumas, finest level first, each level half as large as the one before.
    pub(super) levels: Vec<Plane<f32>>,
}

impl Small {
    /// Downscales `frame`. Rows and columns that do not fill a small pixel are ignored.
    pub fn new(frame: &Frame) -> Self {
        Self::in_memory(frame, None)
    }

    /// The same in the buffers of another one, if any.
    pub(crate) fn in_memory(frame: &Frame, spent: Option<Self>) -> Self {
        let mut spent = spent.into_iter().flat_map(|small| small.levels).map(Plane::into_values);
        let mut memory = || spent.next().unwrap_or_default();
        let size = frame.size();
        let side = size.width.max(size.height);
        let factor = side.div_ceil(SMALL_SIDE).min(size.width.min(size.height));
        let small = Size::new(size.width / factor, size.height / factor);
        let mut plane = Plane::in_memory(small, memory(), 0.0);
        match frame.planes() {
            Some(planes) => means_of_luma(&mut plane, factor, planes),
            None => means_of_pixels(&mut plane, factor, frame),
        }
        let mut levels = vec![plane];
        while let Some(last) = levels.last()
            && levels.len() < LEVELS
            && last.size().width.min(last.size().height) >= 4 * PATCH as u32
        {
            levels.push(super::halve(last, memory()));
        }
        Self { factor, size, levels }
    }

    /// The mean lumas at the finest level, 0..255.
    pub fn plane(&self) -> &Plane<f32> {
        &self.levels[0]
    }
}

/// Fills `small` with the mean lumas of `factor` x `factor` pixels of `frame`.
fn means_of_pixels(small: &mut Plane<f32>, factor: u32, frame: &Frame) {
    let row = |y: u32| frame.row(y).as_flattened();
    small_rows(small, factor, 4, row, |sums| mean_luma(sums, factor));
}

/// The same of the luma of `planes`.
fn means_of_luma(small: &mut Plane<f32>, factor: u32, planes: &Planes) {
    let [luma, _, _] = planes.split();
    let width = planes.form.layout.size.width as usize;
    let row = |y: u32| &luma[y as usize * width..][..width];
    let (black, codes) = planes.form.coding.luma_codes();
    let (scale, all) = (255.0 / codes, (factor * factor) as f32);
    small_rows(small, factor, 1, row, |sums| {
        let sum: u32 = sums.iter().map(|&sum| u32::from(sum)).sum();
        ((sum as f32 / all - black) * scale).clamp(0.0, 255.0)
    });
}

/// Fills rows of small pixels: each is the `mean` of sums of `factor` rows of the frame in its columns; `each` is the
/// number of bytes of a pixel in these rows.
fn small_rows<'a>(
    small: &mut Plane<f32>,
    factor: u32,
    each: usize,
    row: impl Fn(u32) -> &'a [u8] + Sync,
    mean: impl Fn(&[u16]) -> f32 + Sync,
) {
    let width = small.size().width;
    let used = (width * factor) as usize * each;
    let rows = small.values_mut().par_chunks_exact_mut(width as usize).enumerate();
    rows.for_each_init(
        || vec![0u16; used],
        |sums, (y, out)| {
            let first = y as u32 * factor;
            dispatch(
                #[inline(always)]
                || {
                    sums.fill(0);
                    for y in first..first + factor {
                        for (sum, &byte) in sums.iter_mut().zip(row(y)) {
                            // A small pixel has 35 rows at most: MAX_SIDE / SMALL_SIDE.
                            *sum += u16::from(byte);
                        }
                    }
                    for (out, sums) in out.iter_mut().zip(sums.chunks_exact(each * factor as usize))
                    {
                        *out = mean(sums);
                    }
                },
            );
        },
    );
}

/// The mean luma of a small pixel, 0..255, from its columns' sums of red, green, blue and alpha.
#[inline(always)]
fn mean_luma(sums: &[u16], factor: u32) -> f32 {
    let mut colour = [0u32; 4];
    for column in sums.as_chunks::<4>().0 {
        for (sum, &channel) in colour.iter_mut().zip(column) {
            *sum += u32::from(channel);
        }
    }
    let weighted: f32 = colour.iter().zip(LUMA).map(|(&sum, weight)| sum as f32 * weight).sum();
    weighted / (factor * factor) as f32
}

/// Weights of red, green and blue (ITU-R BT.601).
const LUMA: [f32; 3] = [0.299, 0.587, 0.114];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{Coding, Form, Layout, Matrix, Range};

    /// A limited and a full range of luma, as planes and as the pixels that they make.
    #[test]
    fn planes_are_as_bright_as_their_pixels() {
        let size = Size::new(1004, 62);
        let layout = Layout::of_video(size);
        for (range, least, codes) in [(Range::Limited, 16, 220), (Range::Full, 0, 256)] {
            let form = Form { layout, coding: Coding { matrix: Matrix::Bt601, range } };
            let luma = (0..size.pixels()).map(|i| (least + (i * i / 7) % codes) as u8);
            let data = luma.chain(vec![128; size.pixels() / 2]).collect();
            let planar = Frame::planar(Planes { form, data }, Vec::new()).expect("even sides");
            let pixels = Frame::new(size, planar.pixels().to_vec()).expect("a small frame");
            let [of_planes, of_pixels] = [Small::new(&planar), Small::new(&pixels)];
            assert_eq!(of_planes.plane().size(), Size::new(334, 20));
            for (a, b) in of_planes.plane().values().iter().zip(of_pixels.plane().values()) {
                assert!((a - b).abs() < 0.5, "{a} and {b}, {range:?}");
            }
        }
    }
}
