//! Which part of the picture is seen: the whole, or a magnified part of it.

use polyreel::geom::Size;

use super::canvas::Area;
use super::picture::{Sheet, fitted};

/// The factor of one notch of the mouse wheel.
const NOTCH: f64 = 1.25;

/// The largest magnification of the picture that fits into the window.
const MOST: f64 = 32.0;

/// The magnification, and the point of the picture in the middle of the window, as shares of its sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lens {
    zoom: f64,
    centre: (f64, f64),
}

impl Default for Lens {
    /// The whole picture.
    fn default() -> Self {
        Self { zoom: 1.0, centre: (0.5, 0.5) }
    }
}

impl Lens {
    /// Whether a part is magnified.
    pub(super) fn is_zoomed(&self) -> bool {
        self.zoom > 1.0
    }

    /// The magnification, 1 and more.
    pub(super) fn zoom(&self) -> f64 {
        self.zoom
    }

    /// The place of a whole picture of `size` in a window with this `room`.
    pub(super) fn sheet(&self, size: Size, room: Area) -> Sheet {
        let whole = fitted(size, room);
        if !self.is_zoomed() {
            return Sheet::of(whole);
        }
        let scaled = |side: usize| (side as f64 * self.zoom).round() as usize;
        let (width, height) = (scaled(whole.width), scaled(whole.height));
        let x = start(room.x, room.width, width, self.centre.0);
        let y = start(room.y, room.height, height, self.centre.1);
        Sheet { x, y, width, height }
    }

    /// Zooms by `notches` of the wheel; the point under the mouse `at` stays where it is.
    pub(super) fn turn(&mut self, notches: f64, at: (f64, f64), size: Size, room: Area) {
        let before = self.sheet(size, room);
        let point = before.share_of(at);
        self.zoom = (self.zoom * NOTCH.powf(notches)).clamp(1.0, MOST);
        let after = self.sheet(size, room);
        self.centre = (
            moved(point.0, at.0, (room.x, room.width), after.width),
            moved(point.1, at.1, (room.y, room.height), after.height),
        );
        self.keep_inside(size, room);
    }

    /// Moves the picture with the mouse, by `(dx, dy)` pixels of the window.
    pub(super) fn drag(&mut self, (dx, dy): (f64, f64), size: Size, room: Area) {
        let sheet = self.sheet(size, room);
        self.centre.0 -= dx / sheet.width.max(1) as f64;
        self.centre.1 -= dy / sheet.height.max(1) as f64;
        self.keep_inside(size, room);
    }

    /// Moves the middle so that no room stays empty that the picture could fill.
    fn keep_inside(&mut self, size: Size, room: Area) {
        let sheet = self.sheet(size, room);
        let inside = |centre: f64, room: usize, side: usize| {
            let half = room as f64 / side.max(1) as f64 / 2.0;
            if half >= 0.5 { 0.5 } else { centre.clamp(half, 1.0 - half) }
        };
        self.centre = (
            inside(self.centre.0, room.width, sheet.width),
            inside(self.centre.1, room.height, sheet.height),
        );
    }
}

/// Where a side of `length` pixels begins whose share `centre` is in the middle of the room.
fn start(room: usize, width: usize, length: usize, centre: f64) -> i64 {
    (room as f64 + width as f64 / 2.0 - centre * length as f64).round() as i64
}

/// The share of a side of `length` pixels that is in the middle of the room when its share `point` is at `at`.
fn moved(point: f64, at: f64, (room, width): (usize, usize), length: usize) -> f64 {
    point + (room as f64 + width as f64 / 2.0 - at) / length.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size::new(200, 100);
    const ROOM: Area = Area { x: 0, y: 10, width: 400, height: 300 };

    #[test]
    fn the_point_under_the_mouse_stays() {
        let mut lens = Lens::default();
        let at = (300.0, 150.0);
        let before = lens.sheet(SIZE, ROOM).share_of(at);
        // Until the picture is larger than the room in height, it stays in its middle.
        (0..8).for_each(|_| lens.turn(1.0, at, SIZE, ROOM));
        let there = lens.sheet(SIZE, ROOM).share_of(at);
        assert!((there.0 - before.0).abs() < 0.01, "{before:?} {there:?}");
        (0..20).for_each(|_| lens.turn(-1.0, at, SIZE, ROOM));
        assert_eq!(lens, Lens::default());
    }

    #[test]
    fn a_picture_is_not_dragged_out_of_the_window() {
        let mut lens = Lens::default();
        lens.drag((500.0, 500.0), SIZE, ROOM);
        assert_eq!(lens, Lens::default(), "the whole picture has nowhere to go");
        (0..9).for_each(|_| lens.turn(1.0, (200.0, 160.0), SIZE, ROOM));
        for by in [1e4, -1e4] {
            lens.drag((by, by), SIZE, ROOM);
            let sheet = lens.sheet(SIZE, ROOM);
            assert!(sheet.x <= 0 && sheet.x + sheet.width as i64 >= 400, "{sheet:?}");
            assert!(sheet.y <= 10 && sheet.y + sheet.height as i64 >= 310, "{sheet:?}");
        }
    }
}
