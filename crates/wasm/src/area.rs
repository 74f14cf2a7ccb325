//! The part of a frame that changed.

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Area {
    pub(crate) x: usize,
    pub(crate) y: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Area {
    /// The smallest area outside of which `same` holds for every pixel of a frame of `width` x `height`; one pixel where
    /// it holds for all. `same` gets the number of the pixel.
    pub(crate) fn changed(width: usize, height: usize, same: impl Fn(usize) -> bool) -> Self {
        let row_same = |y: &usize| (0..width).all(|x| same(y * width + x));
        let Some(top) = (0..height).find(|y| !row_same(y)) else {
            return Self { x: 0, y: 0, width: 1, height: 1 };
        };
        let bottom = (top..height).rev().find(|y| !row_same(y)).unwrap_or(top);
        let column_same = |x: &usize| (top..=bottom).all(|y| same(y * width + x));
        let left = (0..width).find(|x| !column_same(x)).unwrap_or(0);
        let right = (left..width).rev().find(|x| !column_same(x)).unwrap_or(left);
        Self { x: left, y: top, width: right + 1 - left, height: bottom + 1 - top }
    }

    /// The pixels of the area, of a frame `width` wide, row by row.
    pub(crate) fn of<T: Copy>(self, pixels: &[T], width: usize) -> Vec<T> {
        let rows = (self.y..self.y + self.height).flat_map(|y| {
            let start = y * width + self.x;
            pixels[start..start + self.width].iter().copied()
        });
        rows.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_area_holds_all_changes() {
        let changed = |pixels: &[usize]| Area::changed(5, 4, |i| !pixels.contains(&i));
        assert_eq!(changed(&[]), Area { x: 0, y: 0, width: 1, height: 1 });
        let area = changed(&[7, 13]);
        assert_eq!(area, Area { x: 2, y: 1, width: 2, height: 2 });
        let numbers: Vec<usize> = (0..20).collect();
        assert_eq!(area.of(&numbers, 5), [7, 8, 12, 13]);
    }
}
