//! What a picture was off its source, for the next frame's mesh to be off by as well: then it does not
//! flicker.
//!
//! With O the output, I the source and T = O' + I - I' the picture whose change since the frame before
//! (O', I') is the source's, |O - I|^2 + l |O - T|^2 is, up to a constant, (1 + l) |O - B|^2 with
//! B = I + m (O' - I'), m = l / (1 + l): to lower error and squared flicker at once is to approach B.
//!
//! Who refines a frame [calls](Call); who paints it knows O' and I', and answers with an [`Echo`].

use rayon::prelude::*;

use crate::frame::{Frame, Rgba};
use crate::geom::Size;
use crate::vector::widest;

/// [`Call::new`]'s share at coherence 1. With more no clip flickers less, and likeness goes on falling.
const MOST: f64 = 0.7;

/// One in the fixed-point numbers of the share.
const ONE: f64 = 128.0;

/// What stands for no difference.
const NOTHING: u8 = 128;

/// Pixels that are one piece of work.
const PACK: usize = 1 << 14;

/// Asks whoever paints a frame for its [`Echo`].
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// In 1/128.
    share: i16,
    /// To be filled.
    memory: Vec<Rgba>,
}

impl Call {
    /// Asks for an echo as strong as `coherence`, 0 to 1, says; `memory` is used again for it. `None`
    /// where that is none at all.
    pub fn new(coherence: f64, memory: Vec<Rgba>) -> Option<Self> {
        let share = (MOST * coherence * ONE).round() as i16;
        (share > 0).then_some(Self { share, memory })
    }

    /// Room for a picture of `size`, and how to [fill](Hearing::hear) it.
    pub(crate) fn room(&mut self, size: Size) -> (&mut [Rgba], Hearing) {
        self.memory.resize(size.pixels(), [0; 4]);
        (&mut self.memory, Hearing(self.share))
    }

    /// The echo, once all the room of a picture of `size` is filled.
    pub(crate) fn answered(self, size: Size) -> Echo {
        Echo { size, off: self.memory }
    }
}

/// How much of a difference is heard.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hearing(i16);

impl Hearing {
    /// Fills `room` with what `painted` is off `source`, which are opaque and as long.
    pub(crate) fn hear(self, room: &mut [Rgba], painted: &[Rgba], source: &[Rgba]) {
        let (room, painted, source) =
            (room.as_flattened_mut(), painted.as_flattened(), source.as_flattened());
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
}

/// A share of what a picture was off its source, at each pixel.
#[derive(Debug)]
pub struct Echo {
    size: Size,
    /// [`NOTHING`] and the difference, which ends at as much either way; alpha's is none.
    off: Vec<Rgba>,
}

impl Echo {
    /// B, where `frame` is the next one, opaque, and of the same size.
    pub(crate) fn on(self, frame: &Frame) -> Option<Frame> {
        if frame.size() != self.size || !frame.is_opaque() {
            return None;
        }
        let mut pixels = self.off;
        let packs = pixels.par_chunks_mut(PACK).zip(frame.pixels().par_chunks(PACK));
        packs.for_each(|(off, now)| {
            let (off, now) = (off.as_flattened_mut(), now.as_flattened());
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
        Frame::known(self.size, pixels, true).ok()
    }

    /// Its memory.
    pub(crate) fn into_memory(self) -> Vec<Rgba> {
        self.off
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(size: Size, value: u8) -> Frame {
        Frame::filled(size, [value, value, 0, 255]).expect("a small frame")
    }

    fn echo(painted: &Frame, source: &Frame, coherence: f64) -> Option<Echo> {
        // What it was used for before does not matter.
        let mut call = Call::new(coherence, vec![[7; 4]; 5])?;
        let (room, hearing) = call.room(source.size());
        hearing.hear(room, painted.pixels(), source.pixels());
        Some(call.answered(source.size()))
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
    fn there_is_none_without_coherence_or_of_another_frame() {
        let size = Size::new(9, 5);
        assert!(echo(&grey(size, 1), &grey(size, 2), 0.0).is_none());
        let heard = || echo(&grey(size, 1), &grey(size, 2), 1.0).expect("a share");
        assert!(heard().on(&grey(Size::new(5, 9), 2)).is_none());
        let clear = Frame::filled(size, [0; 4]).expect("a small frame");
        assert!(heard().on(&clear).is_none());
    }
}
