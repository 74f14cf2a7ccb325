//! Converts pictures to the planes of a video.

use crate::colour::{Form, from_rgba};
use crate::frame::{Buffers, Frame, Rgba, over};

/// Fills `out` with the planes of `frame` in `form`. Transparent pixels are composed over the `background` if there
/// is one; else alpha is ignored. Returns buffers to be recycled: the frame's own, or those of `out`.
pub(super) fn fill_planes(
    out: &mut Vec<u8>,
    frame: Frame,
    form: &Form,
    background: Option<Rgba>,
) -> Buffers {
    if frame.planes().is_some_and(|planes| planes.form == *form) {
        let mut buffers = frame.into_buffers();
        std::mem::swap(out, &mut buffers.planes);
        return buffers;
    }
    let (size, opaque) = (frame.size(), frame.is_opaque());
    let mut pixels = frame.into_pixels();
    if let Some(background) = background.filter(|_| !opaque) {
        pixels.iter_mut().for_each(|pixel| *pixel = over(*pixel, background));
    }
    from_rgba(size, &pixels, &form.layout, form.coding, out);
    Buffers { pixels, ..Buffers::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{Coding, Layout, Matrix, Planes, Range};
    use crate::geom::Size;

    const FORM: Form = Form {
        layout: Layout::of_video(Size::new(4, 2)),
        coding: Coding { matrix: Matrix::Bt709, range: Range::Full },
    };

    fn grey_of(frame: Frame, background: Option<Rgba>) -> u8 {
        let mut planes = vec![7; 3];
        fill_planes(&mut planes, frame, &FORM, background);
        assert_eq!(planes.len(), FORM.layout.bytes());
        planes[0]
    }

    #[test]
    fn transparency_shows_the_background_if_there_is_one() {
        let size = FORM.layout.size;
        let grey = |value, alpha| {
            Frame::filled(size, [value, value, value, alpha]).expect("a small frame")
        };
        assert_eq!(grey_of(grey(200, 255), Some([10, 10, 10, 255])), 200);
        assert_eq!(grey_of(grey(9, 0), Some([10, 10, 10, 255])), 10);
        assert_eq!(grey_of(grey(255, 128), Some([10, 10, 10, 255])), 133);
        assert_eq!(grey_of(grey(9, 0), None), 9);
    }

    #[test]
    fn planes_of_the_same_form_are_not_converted() {
        let data: Vec<u8> = (0..12).collect();
        let frame = |form| {
            Frame::planar(Planes { form, data: data.clone() }, Vec::new()).expect("even sides")
        };
        let mut planes = vec![7; 3];
        let buffers = fill_planes(&mut planes, frame(FORM), &FORM, None);
        assert_eq!((planes, buffers.planes), (data.clone(), vec![7; 3]));
        let coding = Coding { matrix: Matrix::Bt709, range: Range::Limited };
        let mut planes = Vec::new();
        fill_planes(&mut planes, frame(Form { coding, ..FORM }), &FORM, None);
        assert_ne!(planes, data, "other codes");
    }
}
