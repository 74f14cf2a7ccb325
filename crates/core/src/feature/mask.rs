//! A set of pixels, one bit each.

use crate::geom::Size;
use crate::plane::Plane;

/// A set of pixels of a frame. Rows are padded to whole 64-bit words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    size: Size,
    stride: usize,
    words: Vec<u64>,
}

impl Mask {
    /// The empty set over a frame of `size`.
    pub fn new(size: Size) -> Self {
        let stride = size.width.div_ceil(64) as usize;
        Self { size, stride, words: vec![0; stride * size.height as usize] }
    }

    /// These `pixels` of a frame of `size`.
    pub(crate) fn of(size: Size, pixels: &[(u32, u32)]) -> Self {
        let mut mask = Self::new(size);
        pixels.iter().for_each(|&(x, y)| mask.insert(x, y));
        mask
    }

    /// The frame's size.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Adds pixel `(x, y)`.
    pub fn insert(&mut self, x: u32, y: u32) {
        self.words[y as usize * self.stride + x as usize / 64] |= 1 << (x % 64);
    }

    /// Adds pixel `(x, y)`, and returns whether it was not there.
    pub(crate) fn put(&mut self, x: u32, y: u32) -> bool {
        let is_new = !self.contains(x, y);
        self.insert(x, y);
        is_new
    }

    /// Takes pixel `(x, y)` out.
    pub fn remove(&mut self, x: u32, y: u32) {
        self.words[y as usize * self.stride + x as usize / 64] &= !(1 << (x % 64));
    }

    /// Whether pixel `(x, y)` is in the set.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        self.words[y as usize * self.stride + x as usize / 64] >> (x % 64) & 1 == 1
    }

    /// Number of pixels in the set.
    pub fn len(&self) -> usize {
        self.words.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// Whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&w| w == 0)
    }

    /// The words of row `y`: bit `x % 64` of word `x / 64` is pixel `x`.
    pub fn row(&self, y: u32) -> &[u64] {
        &self.words[y as usize * self.stride..][..self.stride]
    }

    /// All rows at once, each of [`Mask::stride`] words.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// All rows at once, each of [`Mask::stride`] words, to be written in parallel. Bits at or beyond
    /// the width must stay 0.
    pub fn words_mut(&mut self) -> &mut [u64] {
        &mut self.words
    }

    /// Words in a row.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// 1 for pixels in the set, 0 for the others.
    pub fn to_plane(&self) -> Plane<f32> {
        let mut plane = Plane::filled(self.size, 0.0);
        for (x, y) in self.iter() {
            plane.set(x, y, 1.0);
        }
        plane
    }

    /// The pixels of the set, row by row.
    pub fn iter(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        (0..self.size.height).flat_map(move |y| {
            self.row(y)
                .iter()
                .enumerate()
                .flat_map(move |(i, &word)| Bits(word).map(move |bit| (i as u32 * 64 + bit, y)))
        })
    }
}

/// The positions of the ones in a word, rising.
struct Bits(u64);

impl Iterator for Bits {
    type Item = u32;
    fn next(&mut self) -> Option<u32> {
        (self.0 != 0).then(|| {
            let bit = self.0.trailing_zeros();
            self.0 &= self.0 - 1;
            bit
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_in_comes_out_in_order() {
        let mut mask = Mask::new(Size::new(130, 3));
        let pixels = [(0, 0), (63, 0), (64, 0), (129, 1), (5, 2)];
        for &(x, y) in &pixels {
            mask.insert(x, y);
        }
        assert_eq!(mask.iter().collect::<Vec<_>>(), pixels);
        assert_eq!(mask.len(), 5);
        assert!(mask.contains(129, 1) && !mask.contains(128, 1));
    }
}
