//! What the next frame would look like if nothing flickered, mixed into what it does look like.

use rayon::prelude::*;

use super::surface::Surface;
use crate::frame::{Frame, Rgba};
use crate::scan::runs::{BAND, Bands};
use crate::vector::widest;

/// One in the fixed-point numbers of the mixture.
const ONE: f64 = 128.0;

/// The last frame, while the surface still has its triangles.
///
/// With O the output, I the source and T = O' + I - I' the picture whose change since the frame before
/// (O', I') is the source's, |O - I|^2 + l |O - T|^2 is, up to a constant, (1 + l) |O - B|^2 with
/// B = I + m (O' - I'), m = l / (1 + l): to lower error and squared flicker at once is to approach B.
#[derive(Debug, Default)]
pub(super) struct Echo {
    source: Vec<Rgba>,
    spare: Vec<Rgba>,
    /// The triangles of the last frame.
    bands: Bands,
}

impl Echo {
    /// Forgets the last frame.
    pub(super) fn forget(&mut self) {
        self.source.clear();
    }

    /// Takes up `frame` for the next one; nothing where `share` is 0 or the frame is not opaque.
    pub(super) fn hear(&mut self, frame: &Frame, share: f64) {
        self.source.clear();
        if share > 0.0 && frame.is_opaque() {
            self.source.extend_from_slice(frame.pixels());
        }
    }

    /// `frame` with a `share` (0 to below 1) of what the triangles of `surface`, which are still those
    /// of the last frame, missed of it. `None` where there is no last frame like this one. Takes up the
    /// frame as [`Echo::hear`] does.
    pub(super) fn answer(&mut self, surface: &Surface, frame: &Frame, share: f64) -> Option<Frame> {
        let (size, part) = (frame.size(), (share * ONE).round() as i16);
        if part <= 0 || !frame.is_opaque() || self.source.len() != size.pixels() {
            self.hear(frame, share);
            return None;
        }
        let mut pixels = std::mem::take(&mut self.spare);
        pixels.resize(size.pixels(), [0; 4]);
        let painted = (0..surface.triangles()).map(|t| {
            let [r, g, b, _] = surface.mean[t].colour.map(|c| (c + 0.5) as u8);
            (surface.corners(t as u32), [r, g, b, 255])
        });
        self.bands.sort(size.height, painted);
        let width = size.width as usize;
        let rows = width * BAND as usize;
        let sources = self.source.par_chunks_mut(rows).zip(frame.pixels().par_chunks(rows));
        let parts = pixels.par_chunks_mut(rows).zip(sources).enumerate();
        parts.for_each(|(band, (pixels, (then, now)))| {
            self.bands.fill(band, width, pixels);
            let bytes = pixels.as_flattened_mut();
            widest(
                #[inline(always)]
                || mix(bytes, now.as_flattened(), then.as_flattened(), part),
            );
            then.copy_from_slice(now);
        });
        Frame::known(size, pixels, true).ok()
    }

    /// Takes a frame of [`Echo::answer`] back, to use its memory again.
    pub(super) fn keep(&mut self, answered: Option<Frame>) {
        if let Some(answered) = answered {
            self.spare = answered.into_pixels();
        }
    }
}

/// Every `out`, what was painted, becomes `now` plus a `share`, in 1/128, of what it was off `then`.
#[inline(always)]
fn mix(out: &mut [u8], now: &[u8], then: &[u8], share: i16) {
    for ((out, &now), &then) in out.iter_mut().zip(now).zip(then) {
        let part = ((i16::from(*out) - i16::from(then)) * share + ONE as i16 / 2) >> 7;
        *out = (i16::from(now) + part).clamp(0, 255) as u8;
    }
}
