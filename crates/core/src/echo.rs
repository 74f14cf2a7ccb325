//! What a picture was off its source, for the next frame's mesh to be off by as well: then it does not
//! flicker.
//!
//! With O the output, I the source and T = O' + I - I' the picture whose change since the frame before
//! (O', I') is the source's, |O - I|^2 + l |O - T|^2 is, up to a constant, (1 + l) |O - B|^2 with
//! B = I + m (O' - I'), m = l / (1 + l): to lower error and squared flicker at once is to approach B.
//!
//! Who refines a frame [calls](Call); who paints it knows O' and I', and answers with an [`Echo`].

use crate::parallel::prelude::*;

use crate::colour::{Form, Planes};
use crate::frame::{Buffers, Frame, Rgba};
use crate::geom::Size;
use crate::vector::widest;

/// [`Call::new`]'s share at coherence 1. With more no clip flickers less, and likeness goes on falling.
const MOST: f64 = 0.7;

/// One in the fixed-point numbers of the share.
const ONE: f64 = 128.0;

/// What stands for no difference.
const NOTHING: u8 = 128;

/// Values that are one piece of work.
const PACK: usize = 1 << 16;

/// Asks whoever paints a frame for its [`Echo`].
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// In 1/128.
    share: i16,
    /// To be filled.
    memory: Buffers,
}

impl Call {
    /// Asks for an echo as strong as `coherence`, 0 to 1, says; `memory` is used again for it. `None`
    /// where that is none at all.
    pub fn new(coherence: f64, memory: Buffers) -> Option<Self> {
        let share = (MOST * coherence * ONE).round() as i16;
        (share > 0).then_some(Self { share, memory })
    }

    /// Room for a picture of `size`, and how to [fill](Hearing::hear) it.
    pub(crate) fn room(&mut self, size: Size) -> (&mut [Rgba], Hearing) {
        self.memory.pixels.resize(size.pixels(), [0; 4]);
        (&mut self.memory.pixels, Hearing(self.share))
    }

    /// The same as planes.
    pub(crate) fn room_of_planes(&mut self, bytes: usize) -> (&mut [u8], Hearing) {
        self.memory.planes.resize(bytes, 0);
        (&mut self.memory.planes, Hearing(self.share))
    }

    /// The echo, once all the room of a picture of `size`, or of one of that `form`, is filled.
    pub(crate) fn answered(self, size: Size, form: Option<Form>) -> Echo {
        Echo { size, form, off: self.memory }
    }
}

/// How much of a difference is heard.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hearing(i16);

impl Hearing {
    /// Fills `room` with what `painted` is off `source`, parts of opaque pictures, as long.
    pub(crate) fn hear(self, room: &mut [u8], painted: &[u8], source: &[u8]) {
        widest(
            #[inline(always)]
            || {
                for ((off, &painted), &source) in room.iter_mut().zip(painted).zip(source) {
                    let part = (i16::from(painted) - i16::from(source)) * self.0;
                    *off =
                        (i16::from(NOTHING) + ((part + ONE as i16 / 2) >> 7)).clamp(0, 255) as u8;
                }
            },
        );
    }

    /// The same of whole pictures, by all threads.
    pub(crate) fn hear_all(self, room: &mut [u8], painted: &[u8], source: &[u8]) {
        let given = painted.par_chunks(PACK).zip(source.par_chunks(PACK));
        let parts = room.par_chunks_mut(PACK).zip(given);
        parts.for_each(|(room, (painted, source))| self.hear(room, painted, source));
    }
}

/// A share of what a picture was off its source, at each pixel.
#[derive(Debug)]
pub struct Echo {
    size: Size,
    /// That of the planes, where they tell it, not pixels.
    form: Option<Form>,
    /// [`NOTHING`] and the difference, which ends at as much either way; alpha's is none.
    off: Buffers,
}

impl Echo {
    /// B, where `frame` is the next one, opaque, of the same size, and told in the same form. Its pixels are
    /// made when they are asked for.
    pub(crate) fn on(self, frame: &Frame) -> Option<Frame> {
        let planes = frame.planes();
        if frame.size() != self.size
            || !frame.is_opaque()
            || planes.map(|planes| planes.form) != self.form
        {
            return None;
        }
        let Buffers { mut pixels, planes: mut data } = self.off;
        if let Some(planes) = planes {
            add(&mut data, &planes.data);
            return Frame::planar(Planes { form: planes.form, data }, pixels).ok();
        }
        add(pixels.as_flattened_mut(), frame.pixels().as_flattened());
        Frame::known(self.size, pixels, true).ok()
    }

    /// Its memory.
    pub(crate) fn into_buffers(self) -> Buffers {
        self.off
    }
}

/// Turns the differences in `off` into the values `now` with them.
fn add(off: &mut [u8], now: &[u8]) {
    off.par_chunks_mut(PACK).zip(now.par_chunks(PACK)).for_each(|(off, now)| {
        widest(
            #[inline(always)]
            || {
                for (off, &now) in off.iter_mut().zip(now) {
                    let sum = i16::from(now) + i16::from(*off) - i16::from(NOTHING);
                    *off = sum.clamp(0, 255) as u8;
                }
            },
        );
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{Coding, Layout, Matrix, Range};

    fn grey(size: Size, value: u8) -> Frame {
        Frame::filled(size, [value, value, 0, 255]).expect("a small frame")
    }

    fn echo(painted: &Frame, source: &Frame, coherence: f64) -> Option<Echo> {
        // What it was used for before does not matter.
        let memory = Buffers { pixels: vec![[7; 4]; 5], planes: vec![7; 3] };
        let mut call = Call::new(coherence, memory)?;
        if let (Some(painted), Some(source)) = (painted.planes(), source.planes()) {
            let (room, hearing) = call.room_of_planes(source.data.len());
            hearing.hear(room, &painted.data, &source.data);
            return Some(call.answered(source.form.layout.size, Some(source.form)));
        }
        let (room, hearing) = call.room(source.size());
        let [painted, pixels] = [painted, source].map(|frame| frame.pixels().as_flattened());
        hearing.hear(room.as_flattened_mut(), painted, pixels);
        Some(call.answered(source.size(), None))
    }

    #[test]
    fn the_next_frame_is_off_by_a_share_of_what_the_last_was() {
        let size = Size::new(9, 5);
        for (painted, now) in [(140, 50), (60, 50), (100, 0), (80, 5), (140, 250)] {
            let echo = echo(&grey(size, painted), &grey(size, 100), 0.5).expect("a share");
            let wanted = echo.on(&grey(size, now)).expect("the next frame");
            let share = f64::from(45) / 128.0;
            let exact = f64::from(now) + share * (f64::from(painted) - 100.0);
            let [r, g, b, a] = wanted.at(8, 4);
            assert!((f64::from(r) - exact.clamp(0.0, 255.0)).abs() <= 0.5, "{r}, not {exact}");
            assert_eq!((g, b, a), (r, 0, 255));
        }
    }

    #[test]
    fn planes_echo_as_pixels_do() {
        let planes = |grey: u8, range| {
            let size = Size::new(4, 2);
            let layout = Layout::of_video(size);
            let form = Form { layout, coding: Coding { matrix: Matrix::Bt709, range } };
            let data = [vec![grey; 8], vec![128; 4]].concat();
            Frame::planar(Planes { form, data }, Vec::new()).expect("even sides")
        };
        let full = |grey| planes(grey, Range::Full);
        let heard = || echo(&full(140), &full(100), 0.5).expect("a share");
        let wanted = heard().on(&full(50)).expect("the next frame");
        // 50 + 45 / 128 * (140 - 100)
        assert_eq!(wanted.at(3, 1), [64, 64, 64, 255]);
        assert!(heard().on(&planes(50, Range::Limited)).is_none(), "told in other codes");
        assert!(heard().on(&grey(Size::new(4, 2), 50)).is_none(), "told as pixels");
    }

    #[test]
    fn there_is_none_without_coherence_or_of_another_frame() {
        let size = Size::new(9, 5);
        assert!(echo(&grey(size, 1), &grey(size, 2), 0.0).is_none());
        let heard = || echo(&grey(size, 1), &grey(size, 2), 1.0).expect("a share");
        assert!(heard().on(&grey(Size::new(5, 9), 2)).is_none());
        let clear = Frame::filled(size, [0; 4]).expect("a small frame");
        assert!(heard().on(&clear).is_none());
    }
}
