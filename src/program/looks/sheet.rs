//! A contact sheet: pictures in rows, each with its name.

use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};
use polyreel::error::Result;
use polyreel::frame::{Frame, check_size, over};
use polyreel::geom::Size;

use crate::program::letters::Letters;

const PAPER: Rgb<u8> = Rgb([248, 248, 246]);
const INK: Rgb<u8> = Rgb([34, 34, 38]);
const FAINT: Rgb<u8> = Rgb([124, 124, 130]);

/// What shows through transparent pixels: squares of two greys.
const SQUARES: [[u8; 4]; 2] = [[255, 255, 255, 255], [222, 222, 222, 255]];

/// Width and height of a sheet that is pleasant to look at.
const ASPECT: f64 = 1.5;

/// A look on the sheet.
#[derive(Debug)]
pub(super) struct Cell {
    pub(super) name: String,
    /// More of it, in grey.
    pub(super) remark: String,
    /// Its frames from left to right, all of the size that the layout says.
    pub(super) tiles: Vec<RgbImage>,
}

/// Where things are on a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// The size of a tile.
    pub(super) tile: Size,
    frames: u32,
    columns: u32,
    rows: u32,
    /// Pixels around and between cells.
    gap: u32,
    /// The height of a line of letters.
    line: u32,
}

impl Layout {
    /// For `cells` looks of `frames` frames of `size`, with tiles of at most `longest` pixels.
    ///
    /// # Errors
    /// When the sheet would be too large.
    pub(super) fn new(
        size: Size,
        (cells, frames): (u32, u32),
        longest: u32,
        columns: Option<u32>,
    ) -> Result<Self> {
        let tile = fitted(size, longest);
        let gap = (longest / 32).max(6);
        let line = (tile.width.max(tile.height) / 20).clamp(13, 32);
        let with = |columns: u32| {
            let columns = columns.min(cells);
            Self { tile, frames, columns, rows: cells.div_ceil(columns), gap, line }
        };
        let layout = match columns {
            Some(columns) => with(columns),
            None => {
                let all = (1..=cells).map(with);
                let best =
                    all.min_by(|one, other| one.badness(cells).total_cmp(&other.badness(cells)));
                best.unwrap_or_else(|| with(1))
            }
        };
        check_size(layout.size())?;
        Ok(layout)
    }

    /// How far the sheet is from a pleasant one: in its shape, and in places without a look.
    fn badness(&self, cells: u32) -> f64 {
        let Size { width, height } = self.size();
        let shape = (f64::from(width) / f64::from(height) / ASPECT).ln().abs();
        shape + f64::from(self.columns * self.rows - cells) / f64::from(cells)
    }

    /// The size of the sheet.
    pub(super) fn size(&self) -> Size {
        let (width, height) = self.cell();
        Size::new(
            self.gap + self.columns.saturating_mul(width + self.gap),
            self.gap + self.rows.saturating_mul(height + self.gap),
        )
    }

    /// Width and height of a look with its name.
    fn cell(&self) -> (u32, u32) {
        let frames = self.frames.saturating_mul(self.tile.width + self.between());
        (frames - self.between(), self.tile.height + 2 * self.line)
    }

    /// Pixels between the frames of a look.
    fn between(&self) -> u32 {
        self.gap / 4
    }

    /// The sheet of `cells`, row by row.
    pub(super) fn draw(&self, cells: &[Cell]) -> RgbImage {
        let size = self.size();
        let mut sheet = RgbImage::from_pixel(size.width, size.height, PAPER);
        let letters = Letters::new(self.line);
        let (width, height) = self.cell();
        for (index, cell) in (0..).zip(cells) {
            let left = self.gap + index % self.columns * (width + self.gap);
            let top = self.gap + index / self.columns * (height + self.gap);
            for (place, tile) in (0..).zip(&cell.tiles) {
                let left = left + place * (self.tile.width + self.between());
                imageops::replace(&mut sheet, tile, i64::from(left), i64::from(top));
            }
            let baseline = top + self.tile.height + self.line / 3;
            let name = letters.fitted(&cell.name, width);
            letters.write(&mut sheet, &name, (left, baseline), INK);
            let remark = letters.width(&cell.remark);
            if letters.width(&name) + self.line + remark <= width {
                letters.write(&mut sheet, &cell.remark, (left + width - remark, baseline), FAINT);
            }
        }
        sheet
    }
}

/// The size of a tile: that of the picture if it fits, and a multiple of it for small ones.
fn fitted(size: Size, longest: u32) -> Size {
    let side = size.width.max(size.height);
    if side <= longest {
        let times = longest / side;
        return Size::new(size.width * times, size.height * times);
    }
    let scaled = |length: u32| {
        (f64::from(length) * f64::from(longest) / f64::from(side)).round().max(1.0) as u32
    };
    Size::new(scaled(size.width), scaled(size.height))
}

/// `frame` as a tile of `size`: shrunk smoothly, or magnified to squares.
pub(super) fn tile(frame: &Frame, size: Size) -> RgbImage {
    let Size { width, height } = frame.size();
    let square = (f64::from(width) / f64::from(size.width) * 8.0).ceil().max(1.0) as u32;
    let opaque = RgbImage::from_fn(width, height, |x, y| {
        let below = SQUARES[((x / square + y / square) % 2) as usize];
        let [r, g, b, _] = over(frame.at(x, y), below);
        Rgb([r, g, b])
    });
    let filter = if size.width > width { FilterType::Nearest } else { FilterType::CatmullRom };
    imageops::resize(&opaque, size.width, size.height, filter)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_are_about_three_by_two() {
        for (size, cells, columns) in
            [((1600, 900), 8, 3), ((900, 1600), 8, 4), ((1000, 1000), 8, 4), ((1000, 1000), 1, 1)]
        {
            let size = Size::new(size.0, size.1);
            let layout = Layout::new(size, (cells, 1), 400, None).expect("a sheet");
            assert_eq!(layout.columns, columns, "{size}, {cells}");
        }
        let layout = Layout::new(Size::new(100, 100), (8, 3), 400, Some(20)).expect("a sheet");
        assert_eq!((layout.columns, layout.rows), (8, 1));
        assert!(Layout::new(Size::new(9000, 9000), (60, 60), 2048, None).is_err());
    }

    #[test]
    fn tiles_fit_and_small_pictures_are_magnified() {
        let fitted = |width, height| {
            let Size { width, height } = fitted(Size::new(width, height), 400);
            (width, height)
        };
        assert_eq!(fitted(4000, 1000), (400, 100));
        assert_eq!(fitted(300, 200), (300, 200));
        assert_eq!(fitted(64, 32), (384, 192));
        assert_eq!(fitted(9000, 1), (400, 1));
    }
}
