//! Frames as planes, the form of video, with pixels that are converted on demand.

use std::iter::Sum;
use std::ops::Range;
use std::sync::{Mutex, OnceLock, PoisonError};

use crate::parallel::prelude::*;

use super::{Frame, Rgba, check_size};
use crate::colour::{Form, FromYuv, Planes, RowsToRgba, to_rgba};
use crate::error::{Error, Result};

/// Rows in one parallel piece of work.
const PACK: usize = 64;

/// Buffers of a frame that is no longer needed, to be filled again.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Buffers {
    /// Of pixels.
    pub pixels: Vec<Rgba>,
    /// Of planes.
    pub planes: Vec<u8>,
}

impl Buffers {
    /// Whether both are empty.
    pub fn is_empty(&self) -> bool {
        self.pixels.is_empty() && self.planes.is_empty()
    }
}

/// Pixels that exist, or are converted on demand.
#[derive(Debug)]
pub(super) struct Pixels {
    made: OnceLock<Vec<Rgba>>,
    /// Buffer for the conversion.
    room: Mutex<Vec<Rgba>>,
}

impl From<Vec<Rgba>> for Pixels {
    fn from(pixels: Vec<Rgba>) -> Self {
        Self { made: pixels.into(), room: Mutex::default() }
    }
}

impl Clone for Pixels {
    fn clone(&self) -> Self {
        Self { made: self.made.clone(), room: Mutex::default() }
    }
}

impl Pixels {
    /// All pixels; they are converted from `planes` if they do not exist.
    #[inline]
    pub(super) fn of(&self, planes: Option<&Planes>) -> &[Rgba] {
        self.made.get_or_init(|| {
            let Planes { form: Form { layout, coding }, data } =
                planes.expect("a frame without pixels has planes");
            let mut pixels = self.take_room();
            // On one thread: a thread that waits for others might take up work that waits for this conversion.
            to_rgba(layout, *coding, data, &mut pixels);
            pixels
        })
    }

    fn take_room(&self) -> Vec<Rgba> {
        std::mem::take(&mut *self.room.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// They themselves.
    pub(super) fn into_vec(self, planes: Option<&Planes>) -> Vec<Rgba> {
        self.of(planes);
        self.into_buffers()
    }

    /// Their buffer, converted or not.
    pub(super) fn into_buffers(self) -> Vec<Rgba> {
        let room = self.room.into_inner().unwrap_or_else(PoisonError::into_inner);
        self.made.into_inner().unwrap_or(room)
    }
}

impl Frame {
    /// A frame of opaque `planes`, each chroma sample of which belongs to [four
    /// pixels](crate::colour::Layout::is_squared). Its pixels are converted on demand, in the buffer `room`.
    ///
    /// # Errors
    /// When a side is 0 or above [`crate::geom::MAX_SIDE`], the planes are of another layout, or not as
    /// long as it says.
    #[doc(hidden)]
    pub fn planar(planes: Planes, room: Vec<Rgba>) -> Result<Self> {
        let (layout, bytes) = (planes.form.layout, planes.data.len());
        check_size(layout.size)?;
        if !layout.is_squared() || bytes != layout.bytes() {
            let wanted = "4:2:0 of even sides without alpha";
            let what = format!("of planes is {wanted}, not {layout:?} in {bytes} bytes");
            return Err(Error::FrameSize { size: layout.size, what });
        }
        let pixels = Pixels { made: OnceLock::new(), room: Mutex::new(room) };
        Ok(Self { size: layout.size, opaque: true, planes: Some(planes), pixels })
    }

    /// Whether the pixels exist and need no conversion.
    pub(crate) fn has_pixels(&self) -> bool {
        self.undeveloped().is_none()
    }

    /// The planes from which pixels would be converted.
    fn undeveloped(&self) -> Option<&Planes> {
        self.planes.as_ref().filter(|_| self.pixels.made.get().is_none())
    }

    /// Calls `visit` in parallel with the pixels of `rows`, `together` rows at a time, and adds up its results;
    /// `with` has an item for each call. Pixels that do not exist are converted for the call and not kept.
    pub(crate) fn pass_over<T: Send, S: Sum<S> + Send>(
        &self,
        rows: Range<usize>,
        together: usize,
        with: impl IndexedParallelIterator<Item = T>,
        visit: impl Fn(&[Rgba], T) -> S + Sync,
    ) -> S {
        debug_assert_eq!(with.len(), rows.len().div_ceil(together), "one for each");
        let width = self.size.width as usize;
        let with = with.with_min_len(PACK.div_ceil(together));
        match self.undeveloped() {
            Some(Planes { form, data }) => {
                let maker = || (RowsToRgba::new(&form.layout, form.coding, data), Vec::new());
                let parts = with.enumerate().map_init(maker, |(maker, pixels), (part, with)| {
                    let first = rows.start + part * together;
                    pixels.resize(together.min(rows.end - first) * width, [0; 4]);
                    maker.make(first, pixels);
                    visit(pixels, with)
                });
                parts.sum()
            }
            None => {
                let pixels = &self.pixels()[rows.start * width..rows.end * width];
                let parts = pixels.par_chunks(together * width).zip(with);
                parts.map(|(pixels, with)| visit(pixels, with)).sum()
            }
        }
    }

    /// The planes, if the frame has them.
    #[doc(hidden)]
    pub fn planes(&self) -> Option<&Planes> {
        self.planes.as_ref()
    }

    /// This frame with the pixels in `rows` only, which are converted in the buffer `room`; others must not be read.
    /// `None` if all pixels exist already, or have to be converted.
    pub(crate) fn with_rows(
        &self,
        rows: impl IntoIterator<Item = Range<u32>>,
        room: &mut Vec<Rgba>,
    ) -> Option<Self> {
        let Planes { form, data } = self.undeveloped()?;
        let mut maker = RowsToRgba::new(&form.layout, form.coding, data);
        let mut pixels = std::mem::take(room);
        let width = self.size.width as usize;
        pixels.resize(self.size.pixels(), [0; 4]);
        for rows in rows {
            let first = rows.start as usize;
            maker.make(first, &mut pixels[first * width..rows.end as usize * width]);
        }
        Some(Self { size: self.size, opaque: true, planes: None, pixels: pixels.into() })
    }

    /// The approximate colour at `(x, y)`: of planes, the nearest sample of each.
    pub(crate) fn near(&self, x: u32, y: u32) -> Rgba {
        match &self.planes {
            Some(planes) => {
                let codes = planes.at(x, y).map(|code| (code.into(), 1));
                FromYuv::new(planes.form.coding).mean(codes)
            }
            None => self.at(x, y),
        }
    }

    /// The buffers of a frame that is no longer needed.
    #[doc(hidden)]
    pub fn into_buffers(self) -> Buffers {
        Buffers {
            pixels: self.pixels.into_buffers(),
            planes: self.planes.map(|planes| planes.data).unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{Coding, Layout, Matrix, Range};
    use crate::geom::Size;

    const CODING: Coding = Coding { matrix: Matrix::Bt709, range: Range::Limited };

    fn planes(width: u32, height: u32) -> Planes {
        let size = Size::new(width, height);
        let layout = Layout::of_video(size);
        let data = (0..layout.bytes()).map(|i| (i * 37 % 251) as u8).collect();
        Planes { form: Form { layout, coding: CODING }, data }
    }

    #[test]
    fn pixels_are_those_of_the_planes() {
        let planes = planes(20, 150);
        let mut pixels = Vec::new();
        to_rgba(&planes.form.layout, CODING, &planes.data, &mut pixels);
        let frame = Frame::planar(planes.clone(), vec![[7; 4]; 5]).expect("even sides");
        assert!(frame.is_opaque());
        assert_eq!(frame.planes(), Some(&planes));
        assert_eq!(frame.pixels(), pixels);
        assert_eq!(
            frame,
            Frame::new(planes.form.layout.size, pixels.clone()).expect("a small frame")
        );
        assert_eq!(frame.into_buffers(), Buffers { pixels, planes: planes.data });
    }

    #[test]
    fn rows_are_passed_over_and_not_kept() {
        let planes = planes(20, 150);
        let whole = Frame::planar(planes.clone(), Vec::new()).expect("even sides");
        assert_eq!(whole.pixels().len(), 20 * 150);
        let frame = Frame::planar(planes, Vec::new()).expect("even sides");
        for (frame, is_there) in [(&frame, false), (&whole, true)] {
            for rows in [0..150, 16..150, 32..50, 0..16] {
                let mut seen = vec![Vec::new(); rows.len().div_ceil(16)];
                let count =
                    frame.pass_over(rows.clone(), 16, seen.par_iter_mut(), |pixels, seen| {
                        seen.extend_from_slice(pixels);
                        pixels.len()
                    });
                assert_eq!(count, rows.len() * 20);
                assert_eq!(seen.concat(), whole.pixels()[rows.start * 20..rows.end * 20]);
            }
            assert_eq!(frame.has_pixels(), is_there);
        }
    }

    #[test]
    fn some_rows_are_those_of_all() {
        let frame = Frame::planar(planes(6, 40), Vec::new()).expect("even sides");
        let some = frame.with_rows([3..5, 20..40], &mut vec![[9; 4]; 2]).expect("not made yet");
        for y in [3, 4, 20, 31, 39] {
            assert_eq!(some.row(y), frame.row(y));
        }
        assert!(
            frame.with_rows(std::iter::once(0..1), &mut Vec::new()).is_none(),
            "all are there by now"
        );
    }

    #[test]
    fn other_planes_are_refused() {
        let odd = planes(7, 4);
        assert!(Frame::planar(odd, Vec::new()).is_err());
        let mut short = planes(8, 4);
        short.data.pop();
        assert!(Frame::planar(short, Vec::new()).is_err());
    }
}
