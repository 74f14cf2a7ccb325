//! A film to measure on, made here: a sunset with hills and drifting clouds, with the grain that
//! generated video has.

use polyreel::chance::{Purpose, unit};
use polyreel::colour::{Coding, Form, Layout, Matrix, Planes, Range, Sampling, Siting, from_rgba};
use polyreel::frame::{Frame, Rgba};
use polyreel::geom::Size;

/// Levels from the least to the most that grain adds, in pictures that are rendered as they are.
pub(crate) const GRAIN: f64 = 10.0;

/// Frame `number` of the video, with this amplitude of `grain`.
pub(crate) fn paint(size: Size, number: u64, grain: f64) -> Frame {
    let t = number as f64 * 0.08;
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    let pixels = (0..size.pixels()).map(|i| {
        let (px, py) = (i as u32 % size.width, i as u32 / size.width);
        let (x, y) = (f64::from(px) / width, f64::from(py) / height);
        let sun = (x - 0.3).hypot((y - 0.35) * height / width);
        let cloud = (9.0 * x + t).sin() * (21.0 * y - 3.0 * x).cos() + (17.0 * x - 2.0 * t).sin();
        let hill = 0.7 + 0.06 * (7.0 * x + 0.2).sin() + 0.02 * (31.0 * x).sin();
        let [r, g, b] = if y > hill {
            [30.0 + 60.0 * (y - hill), 50.0 + 90.0 * (1.0 - y), 45.0]
        } else if sun < 0.06 {
            [255.0, 235.0, 170.0]
        } else {
            [250.0 - 130.0 * y + 18.0 * cloud, 120.0 + 60.0 * y + 18.0 * cloud, 90.0 + 120.0 * y]
        };
        let grain = grain * (unit(number, Purpose::Noise, px, py) - 0.5);
        let channel = |v: f64| (v + grain).clamp(0.0, 255.0) as u8;
        [channel(r), channel(g), channel(b), 255] as Rgba
    });
    Frame::new(size, pixels.collect()).expect("a frame of this size")
}

/// The form of video of `size`, which has even sides.
pub(crate) fn form(size: Size) -> Form {
    let (sampling, siting) = (Sampling::Yuv420, Siting::Left);
    let coding = Coding { matrix: Matrix::Bt709, range: Range::Limited };
    Form { layout: Layout { size, sampling, siting, alpha: false }, coding }
}

/// The first frames of the film as video has them, planes, to be shown over and over where a run shall not
/// wait for the painter.
pub(crate) fn shot(size: Size, frames: u64) -> Vec<Frame> {
    let form = form(size);
    let planar = |number| {
        let mut data = Vec::new();
        let pixels = paint(size, number, GRAIN).into_pixels();
        from_rgba(size, &pixels, &form.layout, form.coding, &mut data);
        Frame::planar(Planes { form, data }, Vec::new()).expect("even sides")
    };
    (0..frames).map(planar).collect()
}
