//! Draws a frame on the canvas: as large as it fits, in proportion.

use std::ops::Range;

use polyreel::frame::{Frame, over};
use polyreel::geom::Size;

use super::canvas::{Area, Canvas};

/// The largest area in proportion to `size` that fits into `room`, in its middle.
pub(super) fn fitted(size: Size, room: Area) -> Area {
    let (w, h) = (u64::from(size.width), u64::from(size.height));
    let (room_w, room_h) = (room.width as u64, room.height as u64);
    if room_w == 0 || room_h == 0 {
        return Area { width: 0, height: 0, ..room };
    }
    let rounded = |a: u64, b: u64| ((2 * a + b) / (2 * b)).max(1);
    let (width, height) = if w * room_h >= h * room_w {
        (room_w, rounded(h * room_w, w).min(room_h))
    } else {
        (rounded(w * room_h, h).min(room_w), room_h)
    };
    let (width, height) = (width as usize, height as usize);
    let (x, y) = (room.x + (room.width - width) / 2, room.y + (room.height - height) / 2);
    Area { x, y, width, height }
}

/// Side of the squares behind transparent pixels, in pixels of the frame.
const SQUARE: usize = 8;

/// Row `y` of `frame` as a canvas has it.
fn convert(frame: &Frame, y: usize, out: &mut [u32]) {
    let row = frame.row(y as u32);
    if frame.is_opaque() {
        for (out, &[r, g, b, _]) in out.iter_mut().zip(row) {
            *out = u32::from_be_bytes([0, r, g, b]);
        }
        return;
    }
    for (x, (out, &pixel)) in out.iter_mut().zip(row).enumerate() {
        let light = (x / SQUARE + y / SQUARE).is_multiple_of(2);
        let [r, g, b, _] = over(pixel, if light { [150; 4] } else { [105; 4] });
        *out = u32::from_be_bytes([0, r, g, b]);
    }
}

/// `a` and `b` mixed, with `weight` of 256 parts for `b`. Two channels at a time.
fn mixed(a: u32, b: u32, weight: u32) -> u32 {
    let both = |mask: u32| ((a & mask) * (256 - weight) + (b & mask) * weight) >> 8 & mask;
    both(0xff_00ff) | both(0x00_ff00)
}

/// Where pixel `i` of `to` pixels lies among `from` pixels: the one before it, the one after it, and the
/// weight of that of 256. Both pixel grids have the same ends.
fn place(i: usize, from: usize, to: usize) -> (usize, usize, u32) {
    // In 1/256 pixel: (i + 0.5) from / to - 0.5.
    let at = ((2 * i as u64 + 1) * from as u64 * 128 / to as u64).saturating_sub(128);
    let first = ((at >> 8) as usize).min(from - 1);
    (first, (first + 1).min(from - 1), (at & 255) as u32)
}

/// Draws `frame` on `area` of the canvas, scaled to it (bilinear), but only the columns `columns` of the canvas.
pub(super) fn lay(canvas: &mut Canvas, frame: &Frame, area: Area, columns: Range<usize>) {
    let Size { width, height } = frame.size();
    let (from_w, from_h) = (width as usize, height as usize);
    let columns = columns.start.max(area.x)..columns.end.min(area.x + area.width);
    if columns.is_empty() {
        return;
    }
    let across: Vec<_> = columns.clone().map(|x| place(x - area.x, from_w, area.width)).collect();
    let mut rows = Rows::new(from_w);
    for y in 0..area.height {
        let start = (area.y + y) * canvas.width;
        let Some(out) = canvas.pixels.get_mut(start + columns.start..start + columns.end) else {
            return;
        };
        let row = rows.between(frame, place(y, from_h, area.height));
        for (pixel, &(left, right, weight)) in out.iter_mut().zip(&across) {
            *pixel = mixed(row[left], row[right], weight);
        }
    }
}

/// Rows of a frame, converted once each as they are gone through from the top.
struct Rows {
    /// Two rows and their numbers.
    held: [(usize, Vec<u32>); 2],
    mixed: Vec<u32>,
}

impl Rows {
    fn new(width: usize) -> Self {
        let none = || (usize::MAX, vec![0; width]);
        Self { held: [none(), none()], mixed: vec![0; width] }
    }

    /// What lies between rows `above` and `below`, with `weight` of 256 parts of the latter.
    fn between(&mut self, frame: &Frame, (above, below, weight): (usize, usize, u32)) -> &[u32] {
        if self.held[0].0 != above {
            self.held.swap(0, 1);
        }
        for (held, y) in self.held.iter_mut().zip([above, below]) {
            if held.0 != y {
                convert(frame, y, &mut held.1);
                held.0 = y;
            }
        }
        let [(_, upper), (_, lower)] = &self.held;
        if weight == 0 {
            return upper;
        }
        for ((out, &a), &b) in self.mixed.iter_mut().zip(upper).zip(lower) {
            *out = mixed(a, b, weight);
        }
        &self.mixed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_keep_their_proportion() {
        let room = Area { x: 10, y: 20, width: 800, height: 600 };
        let wide = fitted(Size::new(1920, 1080), room);
        assert_eq!(wide, Area { x: 10, y: 20 + 75, width: 800, height: 450 });
        let tall = fitted(Size::new(100, 300), room);
        assert_eq!(tall, Area { x: 10 + 300, y: 20, width: 200, height: 600 });
        assert_eq!(fitted(Size::new(800, 600), room), room);
        let sliver = fitted(Size::new(16384, 1), Area { x: 0, y: 0, width: 100, height: 100 });
        assert_eq!((sliver.width, sliver.height), (100, 1));
        assert_eq!(fitted(Size::new(4, 3), Area::default()), Area::default());
    }

    #[test]
    fn a_picture_of_its_own_size_is_itself() {
        let pixels = (0..12u8).map(|i| [i, 2 * i, 3 * i, 255]).collect();
        let frame = Frame::new(Size::new(4, 3), pixels).expect("a frame");
        let mut canvas = Canvas::new(6, 5);
        lay(&mut canvas, &frame, Area { x: 1, y: 1, width: 4, height: 3 }, 0..6);
        assert_eq!(canvas.pixels[6 + 1..6 + 5], [0x00_0000, 0x01_0203, 0x02_0406, 0x03_0609]);
        assert_eq!(canvas.pixels[0..6], [0; 6]);
        assert_eq!(canvas.pixels[4 * 6..], [0; 6]);
    }

    #[test]
    fn one_colour_stays_itself_at_any_size() {
        let frame = Frame::filled(Size::new(7, 5), [200, 100, 50, 255]).expect("a frame");
        for (width, height) in [(3, 2), (50, 90), (7, 6), (1, 1)] {
            let mut canvas = Canvas::new(width, height);
            let area = canvas.area();
            lay(&mut canvas, &frame, area, 0..width);
            assert!(canvas.pixels.iter().all(|&p| p == 0xc8_6432), "{width}x{height}");
        }
    }

    #[test]
    fn only_the_columns_asked_for_are_laid() {
        let frame = Frame::filled(Size::new(8, 8), [255; 4]).expect("a frame");
        let mut canvas = Canvas::new(16, 16);
        let area = canvas.area();
        lay(&mut canvas, &frame, area, 5..9);
        for (i, &pixel) in canvas.pixels.iter().enumerate() {
            assert_eq!(pixel != 0, (5..9).contains(&(i % 16)), "pixel {i}");
        }
        // None at all is no mistake.
        lay(&mut canvas, &frame, area, 9..9);
        lay(&mut canvas, &frame, Area { x: 4, y: 4, width: 4, height: 4 }, 0..2);
    }

    #[test]
    fn transparent_pixels_show_squares() {
        let frame = Frame::filled(Size::new(16, 16), [0; 4]).expect("a frame");
        let mut canvas = Canvas::new(16, 16);
        let area = canvas.area();
        lay(&mut canvas, &frame, area, 0..16);
        assert_ne!(canvas.pixels[0], canvas.pixels[8]);
        assert_eq!(canvas.pixels[0], canvas.pixels[8 * 16 + 8]);
    }
}
