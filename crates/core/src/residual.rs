//! Residual feedback: the next frame's mesh is refined towards a target with the last frame's residual, so that the
//! picture does not flicker.
//!
//! With O the output, I the source and T = O' + I - I' the picture whose change since the frame before
//! (O', I') is the source's, |O - I|^2 + l |O - T|^2 is, up to a constant, (1 + l) |O - B|^2 with
//! B = I + m (O' - I'), m = l / (1 + l): to lower error and squared flicker at once is to approach B.
//!
//! The mesh stage [requests](ResidualRequest) a frame's residual, O' - I'; the paint stage, which knows O' and
//! I', writes the [`Residual`]; the next frame's refinement takes it.

use crate::parallel::prelude::*;

use crate::colour::{Form, Planes};
use crate::frame::{Buffers, Frame, Rgba};
use crate::geom::Size;
use crate::simd::dispatch;

/// The share m at coherence 1. A larger one reduces no clip's flicker further, but likeness.
const MAX_SHARE: f64 = 0.7;

/// One in the fixed-point numbers of the share.
const ONE: f64 = 128.0;

/// The byte that stands for no difference.
const ZERO: u8 = 128;

/// Bytes that are one piece of work.
const CHUNK: usize = 1 << 16;

/// A request to the paint stage for the [`Residual`] of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualRequest {
    /// In 1/128.
    share: i16,
    /// To be filled.
    buffers: Buffers,
}

impl ResidualRequest {
    /// A request with the strength `coherence`, 0 to 1, to be written in `buffers`. `None` if the share would be
    /// zero.
    pub fn new(coherence: f64, buffers: Buffers) -> Option<Self> {
        let share = (MAX_SHARE * coherence * ONE).round() as i16;
        (share > 0).then_some(Self { share, buffers })
    }

    /// The buffer for a picture of `size` as pixels, and what [writes](ResidualWriter::write) it.
    pub(crate) fn pixels(&mut self, size: Size) -> (&mut [Rgba], ResidualWriter) {
        self.buffers.pixels.resize(size.pixels(), [0; 4]);
        (&mut self.buffers.pixels, ResidualWriter(self.share))
    }

    /// The buffer for a picture as planes of this many `bytes`, and what writes it.
    pub(crate) fn planes(&mut self, bytes: usize) -> (&mut [u8], ResidualWriter) {
        self.buffers.planes.resize(bytes, 0);
        (&mut self.buffers.planes, ResidualWriter(self.share))
    }

    /// The residual, once the whole buffer of a picture of `size` is written: of its pixels, or of its planes
    /// of that `form`.
    pub(crate) fn finish(self, size: Size, form: Option<Form>) -> Residual {
        Residual { size, form, offsets: self.buffers }
    }
}

/// Writes a share of the difference between two pictures.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResidualWriter(i16);

impl ResidualWriter {
    /// Writes `offsets` from what was `painted` and its `source`, equally long parts of opaque pictures.
    pub(crate) fn write(self, offsets: &mut [u8], painted: &[u8], source: &[u8]) {
        dispatch(
            #[inline(always)]
            || {
                for ((offset, &painted), &source) in offsets.iter_mut().zip(painted).zip(source) {
                    let part = (i16::from(painted) - i16::from(source)) * self.0;
                    *offset =
                        (i16::from(ZERO) + ((part + ONE as i16 / 2) >> 7)).clamp(0, 255) as u8;
                }
            },
        );
    }

    /// The same of whole pictures, on all threads.
    pub(crate) fn write_all(self, offsets: &mut [u8], painted: &[u8], source: &[u8]) {
        let given = painted.par_chunks(CHUNK).zip(source.par_chunks(CHUNK));
        let parts = offsets.par_chunks_mut(CHUNK).zip(given);
        parts.for_each(|(offsets, (painted, source))| self.write(offsets, painted, source));
    }
}

/// A share of the difference between a painted picture and its source, for each pixel.
#[derive(Debug)]
pub struct Residual {
    size: Size,
    /// The form of the planes, where it is of planes and not of pixels.
    form: Option<Form>,
    /// [`ZERO`] plus the difference, clamped to a byte; alpha's difference is zero.
    offsets: Buffers,
}

impl Residual {
    /// B for the next `frame`; `None` unless it is opaque, of the same size and in the same form. Its pixels
    /// are converted when they are first read.
    pub(crate) fn target_for(self, frame: &Frame) -> Option<Frame> {
        let planes = frame.planes();
        if frame.size() != self.size
            || !frame.is_opaque()
            || planes.map(|planes| planes.form) != self.form
        {
            return None;
        }
        let Buffers { mut pixels, planes: mut data } = self.offsets;
        if let Some(planes) = planes {
            add(&mut data, &planes.data);
            return Frame::planar(Planes { form: planes.form, data }, pixels).ok();
        }
        add(pixels.as_flattened_mut(), frame.pixels().as_flattened());
        Frame::known(self.size, pixels, true).ok()
    }

    /// Its buffers, to be filled again.
    pub(crate) fn into_buffers(self) -> Buffers {
        self.offsets
    }
}

/// Adds the values of a picture, `source`, to the differences in `offsets`.
fn add(offsets: &mut [u8], source: &[u8]) {
    offsets.par_chunks_mut(CHUNK).zip(source.par_chunks(CHUNK)).for_each(|(offsets, source)| {
        dispatch(
            #[inline(always)]
            || {
                for (offset, &source) in offsets.iter_mut().zip(source) {
                    let sum = i16::from(source) + i16::from(*offset) - i16::from(ZERO);
                    *offset = sum.clamp(0, 255) as u8;
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

    fn residual(painted: &Frame, source: &Frame, coherence: f64) -> Option<Residual> {
        // What it was used for before does not matter.
        let buffers = Buffers { pixels: vec![[7; 4]; 5], planes: vec![7; 3] };
        let mut request = ResidualRequest::new(coherence, buffers)?;
        if let (Some(painted), Some(source)) = (painted.planes(), source.planes()) {
            let (offsets, writer) = request.planes(source.data.len());
            writer.write(offsets, &painted.data, &source.data);
            return Some(request.finish(source.form.layout.size, Some(source.form)));
        }
        let (offsets, writer) = request.pixels(source.size());
        let [painted, pixels] = [painted, source].map(|frame| frame.pixels().as_flattened());
        writer.write(offsets.as_flattened_mut(), painted, pixels);
        Some(request.finish(source.size(), None))
    }

    #[test]
    fn the_next_frame_is_off_by_a_share_of_what_the_last_was() {
        let size = Size::new(9, 5);
        for (painted, now) in [(140, 50), (60, 50), (100, 0), (80, 5), (140, 250)] {
            let residual = residual(&grey(size, painted), &grey(size, 100), 0.5).expect("a share");
            let wanted = residual.target_for(&grey(size, now)).expect("the next frame");
            let share = f64::from(45) / 128.0;
            let exact = f64::from(now) + share * (f64::from(painted) - 100.0);
            let [r, g, b, a] = wanted.at(8, 4);
            assert!((f64::from(r) - exact.clamp(0.0, 255.0)).abs() <= 0.5, "{r}, not {exact}");
            assert_eq!((g, b, a), (r, 0, 255));
        }
    }

    #[test]
    fn planes_have_the_residual_of_pixels() {
        let planes = |grey: u8, range| {
            let size = Size::new(4, 2);
            let layout = Layout::of_video(size);
            let form = Form { layout, coding: Coding { matrix: Matrix::Bt709, range } };
            let data = [vec![grey; 8], vec![128; 4]].concat();
            Frame::planar(Planes { form, data }, Vec::new()).expect("even sides")
        };
        let full = |grey| planes(grey, Range::Full);
        let last = || residual(&full(140), &full(100), 0.5).expect("a share");
        let wanted = last().target_for(&full(50)).expect("the next frame");
        // 50 + 45 / 128 * (140 - 100)
        assert_eq!(wanted.at(3, 1), [64, 64, 64, 255]);
        assert!(last().target_for(&planes(50, Range::Limited)).is_none(), "in another range");
        assert!(last().target_for(&grey(Size::new(4, 2), 50)).is_none(), "as pixels");
    }

    #[test]
    fn there_is_none_without_coherence_or_of_another_frame() {
        let size = Size::new(9, 5);
        assert!(residual(&grey(size, 1), &grey(size, 2), 0.0).is_none());
        let last = || residual(&grey(size, 1), &grey(size, 2), 1.0).expect("a share");
        assert!(last().target_for(&grey(Size::new(5, 9), 2)).is_none());
        let clear = Frame::filled(size, [0; 4]).expect("a small frame");
        assert!(last().target_for(&clear).is_none());
    }
}
