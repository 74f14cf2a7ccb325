//! A value for every pixel of a frame, for maps and metrics.

use crate::parallel::prelude::*;

use crate::frame::{Frame, luma};
use crate::geom::Size;

/// One value a pixel, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plane<T> {
    size: Size,
    values: Vec<T>,
}

impl<T: Copy> Plane<T> {
    /// A plane of `values`, row by row; `None` when they are not width x height.
    pub fn new(size: Size, values: Vec<T>) -> Option<Self> {
        (values.len() == size.pixels()).then_some(Self { size, values })
    }

    /// A plane that holds `value` everywhere.
    pub fn filled(size: Size, value: T) -> Self {
        Self { size, values: vec![value; size.pixels()] }
    }

    /// A plane in the `memory` of another one. Old values are kept as far as they go, then it holds `value`.
    pub(crate) fn in_memory(size: Size, mut memory: Vec<T>, value: T) -> Self {
        memory.resize(size.pixels(), value);
        Self { size, values: memory }
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// All values, row by row.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// All values, to be written.
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// The values of row `y`.
    pub fn row(&self, y: u32) -> &[T] {
        let width = self.size.width as usize;
        &self.values[y as usize * width..][..width]
    }

    /// The value at `(x, y)`.
    pub fn at(&self, x: u32, y: u32) -> T {
        self.row(y)[x as usize]
    }

    /// Sets the value at `(x, y)`.
    pub(crate) fn set(&mut self, x: u32, y: u32, value: T) {
        let place = y as usize * self.size.width as usize + x as usize;
        self.values[place] = value;
    }

    /// The values themselves.
    pub fn into_values(self) -> Vec<T> {
        self.values
    }
}

impl<T: Copy + Sync> Plane<T> {
    /// `change` of every value.
    pub fn map<U: Copy + Send>(&self, change: impl Fn(T) -> U + Sync) -> Plane<U> {
        let values = self.values.par_iter().with_min_len(1 << 14).map(|&v| change(v)).collect();
        Plane { size: self.size, values }
    }
}

impl Plane<u8> {
    /// The luma of every pixel of `frame`, 0..255 ([`luma`]). Alpha is ignored.
    pub fn luma(frame: &Frame) -> Self {
        let values = frame.pixels().par_iter().with_min_len(1 << 14).map(|&p| luma(p)).collect();
        Self { size: frame.size(), values }
    }
}

impl Plane<f32> {
    /// The luma of every pixel of `frame` before it is rounded, 0..255: 0.299 R + 0.587 G + 0.114 B.
    pub fn exact_luma(frame: &Frame) -> Self {
        let weigh = |&[r, g, b, _]: &[u8; 4]| {
            ((299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b)) as f32) / 1000.0
        };
        let values = frame.pixels().par_iter().with_min_len(1 << 14).map(weigh).collect();
        Self { size: frame.size(), values }
    }

    /// Every value rounded to the nearest of 0..255, halves up.
    pub fn to_bytes(&self) -> Plane<u8> {
        // A float cast to an integer saturates, and takes NaN to 0.
        self.map(|v| (v + 0.5) as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_holds_one_value_a_pixel() {
        assert!(Plane::new(Size::new(2, 3), vec![0_u8; 5]).is_none());
        let plane = Plane::new(Size::new(2, 2), vec![1_u8, 2, 3, 4]).expect("four values");
        assert_eq!((plane.at(1, 0), plane.row(1)), (2, &[3, 4][..]));
        assert_eq!(plane.map(|v| u32::from(v) * 10).values(), [10, 20, 30, 40]);
    }

    #[test]
    fn rounded_luma_is_the_nearest_to_the_exact_one() {
        let colours = [[0, 0, 0, 255], [255, 255, 255, 0], [200, 30, 90, 255], [13, 201, 77, 9]];
        let frame = Frame::new(Size::new(4, 1), colours.to_vec()).expect("four pixels");
        let (rounded, exact) = (Plane::luma(&frame), Plane::exact_luma(&frame));
        for (&r, &e) in rounded.values().iter().zip(exact.values()) {
            assert!((f32::from(r) - e).abs() <= 0.51, "{r} for {e}");
        }
        assert_eq!(exact.to_bytes(), rounded);
    }

    #[test]
    fn bytes_saturate() {
        let plane = Plane::new(Size::new(4, 1), vec![-3.0, 0.5, 254.4, 1e9]).expect("four values");
        assert_eq!(plane.to_bytes().values(), [0, 1, 254, 255]);
    }
}
