//! The canvas on which the frames of an animation are composed.

use crate::frame::Rgba;
use crate::geom::Size;

/// A rectangle of pixels, `x0 <= x < x1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Area {
    pub(super) x0: u32,
    pub(super) y0: u32,
    pub(super) x1: u32,
    pub(super) y1: u32,
}

impl Area {
    /// The rectangle of `size` whose upper left corner is `(x, y)`.
    pub(super) fn at(x: u32, y: u32, size: Size) -> Self {
        Self { x0: x, y0: y, x1: x.saturating_add(size.width), y1: y.saturating_add(size.height) }
    }

    /// The whole of a picture of `size`.
    pub(super) fn whole(size: Size) -> Self {
        Self::at(0, 0, size)
    }

    /// The size of the smallest picture that begins at the origin and holds the rectangle.
    pub(super) fn far(self) -> Size {
        Size::new(self.x1, self.y1)
    }

    /// The part of it inside a picture of `size`.
    pub(super) fn clipped(self, size: Size) -> Self {
        Self {
            x0: self.x0.min(size.width),
            y0: self.y0.min(size.height),
            x1: self.x1.min(size.width),
            y1: self.y1.min(size.height),
        }
    }

    /// The index ranges of its rows in a frame of this `width`.
    pub(super) fn rows(self, width: u32) -> impl Iterator<Item = std::ops::Range<usize>> {
        let width = width as usize;
        (self.y0 as usize..self.y1 as usize)
            .map(move |y| y * width + self.x0 as usize..y * width + self.x1 as usize)
    }
}

/// What happens to a frame's rectangle before the next frame is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Disposal {
    Keep,
    Background,
    Previous,
}

/// A disposal that is due before the next frame.
#[derive(Debug)]
enum Undo {
    Nothing,
    Clear(Area),
    Restore(Area, Vec<Rgba>),
}

/// The picture that a viewer shows. It begins transparent.
#[derive(Debug)]
pub(super) struct Canvas {
    size: Size,
    pixels: Vec<Rgba>,
    undo: Undo,
}

impl Canvas {
    /// A transparent canvas.
    pub(super) fn new(size: Size) -> Self {
        Self { size, pixels: vec![[0; 4]; size.pixels()], undo: Undo::Nothing }
    }

    /// Disposes of the last frame, and stores the disposal of the next one, which covers `area` (inside the canvas).
    /// Call it before the frame is drawn.
    pub(super) fn begin(&mut self, area: Area, disposal: Disposal) {
        self.dispose();
        self.undo = match disposal {
            Disposal::Keep => Undo::Nothing,
            Disposal::Background => Undo::Clear(area),
            Disposal::Previous => {
                let rows = area.rows(self.size.width);
                Undo::Restore(area, rows.flat_map(|r| self.pixels[r].iter().copied()).collect())
            }
        };
    }

    fn dispose(&mut self) {
        match std::mem::replace(&mut self.undo, Undo::Nothing) {
            Undo::Nothing => {}
            Undo::Clear(area) => {
                area.rows(self.size.width).for_each(|row| self.pixels[row].fill([0; 4]));
            }
            Undo::Restore(area, saved) => {
                let mut saved = saved.as_slice();
                for row in area.rows(self.size.width) {
                    let (now, later) = saved.split_at(row.len());
                    self.pixels[row].copy_from_slice(now);
                    saved = later;
                }
            }
        }
    }

    /// Draws the pixels `frame`, row by row, over `area` (inside the canvas): `blend` computes a pixel from the
    /// frame's and the canvas's.
    pub(super) fn draw(&mut self, area: Area, frame: &[Rgba], blend: impl Fn(Rgba, Rgba) -> Rgba) {
        let width = (area.x1 - area.x0).max(1) as usize;
        for (row, drawn) in area.rows(self.size.width).zip(frame.chunks(width)) {
            for (pixel, &new) in self.pixels[row].iter_mut().zip(drawn) {
                *pixel = blend(new, *pixel);
            }
        }
    }

    /// The pixels of row `y` from `x0` to `x1`.
    pub(super) fn row_mut(&mut self, y: u32, x0: u32, x1: u32) -> &mut [Rgba] {
        let start = y as usize * self.size.width as usize;
        &mut self.pixels[start + x0 as usize..start + x1 as usize]
    }

    /// All pixels, row by row.
    pub(super) fn pixels(&self) -> &[Rgba] {
        &self.pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Rgba = [255, 0, 0, 255];
    const BLUE: Rgba = [0, 0, 255, 255];

    #[test]
    fn what_the_background_took_does_not_come_back() {
        let mut canvas = Canvas::new(Size::new(2, 1));
        let (all, left) = (Area::whole(Size::new(2, 1)), Area::at(0, 0, Size::new(1, 1)));
        let over = |new, _| new;
        canvas.begin(all, Disposal::Background);
        canvas.draw(all, &[RED, RED], over);
        canvas.begin(left, Disposal::Previous);
        canvas.draw(left, &[BLUE], over);
        assert_eq!(canvas.pixels(), [BLUE, [0; 4]]);
        canvas.begin(left, Disposal::Keep);
        assert_eq!(canvas.pixels(), [[0; 4]; 2]);
    }
}
