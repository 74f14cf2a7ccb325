//! Draws a frame on the canvas: as large as it fits, in proportion.

use polyreel::frame::{Frame, over};
use polyreel::geom::Size;

use super::canvas::{Area, Canvas, mixed};

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

/// Where pixel `i` of `to` pixels lies among `from` pixels: the one before it, the one after it, and the
/// weight of that of 256. Both pixel grids have the same ends.
fn place(i: usize, from: usize, to: usize) -> (usize, usize, u32) {
    // In 1/256 pixel: (i + 0.5) from / to - 0.5.
    let at = ((2 * i as u64 + 1) * from as u64 * 128 / to as u64).saturating_sub(128);
    let first = ((at >> 8) as usize).min(from - 1);
    (first, (first + 1).min(from - 1), (at & 255) as u32)
}

/// The place of a whole picture on the canvas, in pixels. It may stick out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sheet {
    pub(super) x: i64,
    pub(super) y: i64,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Sheet {
    /// One that fills `area`.
    pub(super) fn of(area: Area) -> Self {
        Self { x: area.x as i64, y: area.y as i64, width: area.width, height: area.height }
    }

    /// The part of it that lies in `room`.
    pub(super) fn within(&self, room: Area) -> Area {
        let (x, width) = shared((self.x, self.width), (room.x, room.width));
        let (y, height) = shared((self.y, self.height), (room.y, room.height));
        Area { x, y, width, height }
    }

    /// The point of the picture at a place of the canvas, as shares of its sides.
    pub(super) fn share_of(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let share = |at: f64, start: i64, side: usize| (at - start as f64) / side.max(1) as f64;
        (share(x, self.x, self.width), share(y, self.y, self.height))
    }
}

/// Start and length of what two stretches share.
fn shared((start, length): (i64, usize), (room, width): (usize, usize)) -> (usize, usize) {
    let end = (start + length as i64).min((room + width) as i64);
    let start = start.max(room as i64);
    (start.max(0) as usize, (end - start).max(0) as usize)
}

/// Draws `frame` on the canvas, scaled to `sheet` (bilinear), as far as it lies in `room`.
pub(super) fn lay(canvas: &mut Canvas, frame: &Frame, sheet: Sheet, room: Area) {
    let Size { width, height } = frame.size();
    let (from_w, from_h) = (width as usize, height as usize);
    let seen = sheet.within(room);
    if seen.width == 0 {
        return;
    }
    let columns = seen.x..seen.x + seen.width;
    let offset = |at: usize, start: i64| (at as i64 - start) as usize;
    let across: Vec<_> =
        columns.clone().map(|x| place(offset(x, sheet.x), from_w, sheet.width)).collect();
    let mut rows = Rows::new(from_w);
    for y in seen.y..seen.y + seen.height {
        let start = y * canvas.width;
        let Some(out) = canvas.pixels.get_mut(start + columns.start..start + columns.end) else {
            return;
        };
        let row = rows.between(frame, place(offset(y, sheet.y), from_h, sheet.height));
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
        let room = canvas.area();
        lay(&mut canvas, &frame, Sheet { x: 1, y: 1, width: 4, height: 3 }, room);
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
            lay(&mut canvas, &frame, Sheet::of(area), area);
            assert!(canvas.pixels.iter().all(|&p| p == 0xc8_6432), "{width}x{height}");
        }
    }

    #[test]
    fn only_the_room_is_painted() {
        let frame = Frame::filled(Size::new(8, 8), [255; 4]).expect("a frame");
        let mut canvas = Canvas::new(16, 16);
        let area = canvas.area();
        lay(&mut canvas, &frame, Sheet::of(area), Area { x: 5, width: 4, ..area });
        for (i, &pixel) in canvas.pixels.iter().enumerate() {
            assert_eq!(pixel != 0, (5..9).contains(&(i % 16)), "pixel {i}");
        }
        // None at all is no mistake.
        lay(&mut canvas, &frame, Sheet::of(area), Area { x: 9, width: 0, ..area });
        lay(
            &mut canvas,
            &frame,
            Sheet { x: 4, y: 4, width: 4, height: 4 },
            Area { width: 2, ..area },
        );
    }

    #[test]
    fn transparent_pixels_show_squares() {
        let frame = Frame::filled(Size::new(16, 16), [0; 4]).expect("a frame");
        let mut canvas = Canvas::new(16, 16);
        let area = canvas.area();
        lay(&mut canvas, &frame, Sheet::of(area), area);
        assert_ne!(canvas.pixels[0], canvas.pixels[8]);
        assert_eq!(canvas.pixels[0], canvas.pixels[8 * 16 + 8]);
    }

    #[test]
    fn a_magnified_picture_sticks_out_of_the_window() {
        let pixels = (0..16u8).map(|i| [16 * i, 0, 0, 255]).collect();
        let frame = Frame::new(Size::new(4, 4), pixels).expect("a frame");
        let (mut whole, mut part) = (Canvas::new(40, 40), Canvas::new(10, 10));
        let (all, room) = (whole.area(), part.area());
        lay(&mut whole, &frame, Sheet::of(all), all);
        let sheet = Sheet { x: -12, y: -25, width: 40, height: 40 };
        lay(&mut part, &frame, sheet, room);
        for (i, &pixel) in part.pixels.iter().enumerate() {
            assert_eq!(pixel, whole.pixels[(25 + i / 10) * 40 + 12 + i % 10], "pixel {i}");
        }
        assert_eq!(sheet.within(room), room);
    }
}
