//! The hexagonal grid of level two.

use std::ops::Range;

use crate::geom::Size;

/// The narrowest cell in pixels: a finer grid would have cells without a pixel.
const MIN_WIDTH: f64 = 1.0;

/// A grid of regular hexagons, pointed at top and bottom, in rows; odd rows are shifted by half a
/// cell. The first cell's centre lies in the frame's top left corner.
///
/// The "side" of the paper is the flat-to-flat width `w` here: the area of a cell is
/// `sqrt(3) / 2 * w^2`, rows are `sqrt(3) / 2 * w` apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HexGrid {
    size: Size,
    width: f64,
    columns: usize,
    rows: usize,
}

impl HexGrid {
    /// A grid over `size` with cells of `width` pixels, at least 1 pixel.
    pub fn new(size: Size, width: f64) -> Self {
        let width = width.max(MIN_WIDTH);
        // Centres run from 0 to the far side; half a cell more on the right for shifted rows.
        let columns = (f64::from(size.width) / width).ceil() as usize + 2;
        let rows = (f64::from(size.height) / (width * ROW_PITCH)).ceil() as usize + 2;
        Self { size, width, columns, rows }
    }

    /// A grid whose cells have an area of `hex_density` times the frame's (the paper's parameter).
    pub fn with_density(size: Size, hex_density: f64) -> Self {
        Self::with_cell_area(size, size.pixels() as f64 * hex_density)
    }

    /// A grid with cells of `area` square pixels.
    pub fn with_cell_area(size: Size, area: f64) -> Self {
        Self::new(size, (area / ROW_PITCH).sqrt())
    }

    /// Flat-to-flat width of a cell in pixels.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Area of a cell in square pixels.
    pub fn cell_area(&self) -> f64 {
        ROW_PITCH * self.width * self.width
    }

    /// Number of cells, including those that touch the frame or are just outside it.
    pub fn cells(&self) -> usize {
        self.columns * self.rows
    }

    /// The frame's size.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Centre of cell `cell` in pixels; it may lie outside the frame.
    pub fn centre(&self, cell: usize) -> (f64, f64) {
        let (row, column) = (cell / self.columns, cell % self.columns);
        // Shifted rows begin half a cell before the frame, so that they cover its left border too.
        let shift = if row % 2 == 1 { 0.5 } else { 0.0 };
        ((column as f64 - shift) * self.width, row as f64 * self.width * ROW_PITCH)
    }

    /// Four corners of a cell in pixels, from the upper right by the lower tip to the lower left: the ends
    /// of its right and lower sides.
    pub fn lower_right(&self, cell: usize) -> [(f64, f64); 4] {
        let (x, y) = self.centre(cell);
        // From flat to flat and from tip to tip, halved.
        let (half, tip) = (self.width() / 2.0, self.width() / 3f64.sqrt());
        [
            (x + half, y - tip / 2.0),
            (x + half, y + tip / 2.0),
            (x, y + tip),
            (x - half, y + tip / 2.0),
        ]
    }

    /// The cell that the place `(x, y)` in pixels belongs to: the one with the nearest centre; of two
    /// equally near ones the first.
    pub fn cell_at(&self, x: f64, y: f64) -> usize {
        let (u, v) = (x / self.width, y / (self.width * ROW_PITCH));
        let below = (v.max(0.0) as usize).min(self.rows - 2);
        let near = |row: usize| {
            let shift = if row % 2 == 1 { 0.5 } else { 0.0 };
            let column = (u + shift).round().clamp(0.0, (self.columns - 1) as f64);
            let dx = u + shift - column;
            let dy = (v - row as f64) * ROW_PITCH;
            (dx * dx + dy * dy, row * self.columns + column as usize)
        };
        let (upper, lower) = (near(below), near(below + 1));
        if lower.0 < upper.0 { lower.1 } else { upper.1 }
    }

    /// Calls `visit(cell, columns)` for each run of pixels of row `y` in one cell, from left to right.
    pub fn row_runs(&self, y: u32, mut visit: impl FnMut(usize, Range<u32>)) {
        // Cells are convex: if both ends of a stretch are in one cell, all of it is. Steps of a quarter of a cell
        // find most borders with few lookups.
        let stride = ((self.width / 4.0) as u32).max(1);
        let mut start = 0;
        while start < self.size.width {
            let cell = self.cell_of_pixel(start, y);
            let mut same = start;
            let mut other = start + stride;
            while other < self.size.width && self.cell_of_pixel(other, y) == cell {
                (same, other) = (other, other + stride);
            }
            other = other.min(self.size.width);
            while other - same > 1 {
                let middle = same.midpoint(other);
                if self.cell_of_pixel(middle, y) == cell { same = middle } else { other = middle }
            }
            visit(cell, start..other);
            start = other;
        }
    }

    /// The cell of pixel `(x, y)`'s centre.
    pub fn cell_of_pixel(&self, x: u32, y: u32) -> usize {
        self.cell_at(f64::from(x) + 0.5, f64::from(y) + 0.5)
    }
}

/// Distance of rows in cell widths, and area of a cell in squared widths: sqrt(3) / 2.
const ROW_PITCH: f64 = 0.866_025_403_784_438_6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_belongs_to_the_cell_with_the_nearest_centre() {
        for (size, width) in
            [(Size::new(37, 23), 5.3), (Size::new(9, 40), 2.0), (Size::new(3, 2), 30.0)]
        {
            let grid = HexGrid::new(size, width);
            for y in 0..size.height {
                for x in 0..size.width {
                    let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
                    let distance = |cell| {
                        let (cx, cy) = grid.centre(cell);
                        (cx - px).hypot(cy - py)
                    };
                    let best = (0..grid.cells()).map(distance).fold(f64::INFINITY, f64::min);
                    let found = distance(grid.cell_of_pixel(x, y));
                    assert!(found <= best + 1e-9, "{size} {width} ({x}, {y}): {found} > {best}");
                }
            }
        }
    }

    #[test]
    fn runs_are_the_pixels_of_their_cells() {
        for (size, width) in
            [(Size::new(90, 50), 7.3), (Size::new(61, 20), 1.0), (Size::new(40, 9), 100.0)]
        {
            let grid = HexGrid::new(size, width);
            for y in 0..size.height {
                let mut next = 0;
                grid.row_runs(y, |cell, columns| {
                    assert_eq!(columns.start, next);
                    next = columns.end;
                    for x in columns {
                        assert_eq!(grid.cell_of_pixel(x, y), cell, "({x}, {y}) of {size}");
                    }
                });
                assert_eq!(next, size.width);
            }
        }
    }

    #[test]
    fn cells_have_the_area_that_was_asked_for() {
        let size = Size::new(400, 300);
        let grid = HexGrid::with_density(size, 0.001);
        assert!((grid.cell_area() - 120.0).abs() < 1e-9);
        let mut count = vec![0u32; grid.cells()];
        for y in 0..size.height {
            for x in 0..size.width {
                count[grid.cell_of_pixel(x, y)] += 1;
            }
        }
        let full: Vec<_> = (0..grid.cells())
            .filter(|&c| {
                let (x, y) = grid.centre(c);
                x > 12.0 && y > 12.0 && x < 388.0 && y < 288.0
            })
            .map(|c| f64::from(count[c]))
            .collect();
        let mean = full.iter().sum::<f64>() / full.len() as f64;
        assert!((mean - 120.0).abs() < 1.0, "{mean}");
    }
}
