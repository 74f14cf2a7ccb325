//! The bytes of the output do not depend on whether threads share the work: both feature sets are held
//! against the same stored values.
//!
//! ```text
//! cargo test -p polyreel-core --test same_bytes --features unstable
//! cargo test -p polyreel-core --test same_bytes --no-default-features --features unstable
//! ```

use polyreel_core::unstable::colour::{Coding, Form, Layout, Matrix, Planes, Range, from_rgba};
use polyreel_core::{
    Colour, Edges, Frame, FrontEnd, Method, Options, Points, Quality, Renderer, Size,
};

const SIZE: Size = Size::new(160, 120);
const FRAMES: u32 = 6;

/// A disc that wanders over stripes; with `clear`, part of the ground is transparent. Whole numbers only.
fn frame(t: u32, clear: bool) -> Frame {
    let pixels = (0..SIZE.pixels() as u32).map(|i| {
        let (x, y) = (i % SIZE.width, i / SIZE.width);
        let (dx, dy) = (x.abs_diff(30 + 6 * t), y.abs_diff(50 + 2 * t));
        let grain = (x.wrapping_mul(2_654_435_761) ^ y.wrapping_mul(40_503)) >> 13 & 7;
        if dx * dx + dy * dy < 900 {
            [220, (y + grain) as u8, 40, 255]
        } else if clear && x < 40 && y > 80 {
            [9, 9, 9, 0]
        } else {
            [(x + grain) as u8, ((x / 20 % 2) * 120 + grain) as u8, (2 * y) as u8, 255]
        }
    });
    Frame::new(SIZE, pixels.collect()).expect("a small frame")
}

const FORM: Form = Form {
    layout: Layout::of_video(SIZE),
    coding: Coding { matrix: Matrix::Bt601, range: Range::Limited },
};

/// The same as video has it.
fn planar(t: u32) -> Frame {
    let mut data = Vec::new();
    from_rgba(SIZE, frame(t, false).pixels(), &FORM.layout, FORM.coding, &mut data);
    Frame::planar(Planes { form: FORM, data }, Vec::new()).expect("a small frame")
}

/// FNV-1a over all pixels of all frames, and over the meshes behind them.
fn hash(mut renderer: Renderer, frame: impl Fn(u32) -> Frame) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |byte: u8| hash = (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
    for t in 0..FRAMES {
        let rendered = renderer.render(&frame(t)).expect("a frame");
        rendered.picture.pixels().as_flattened().iter().for_each(|&byte| add(byte));
        let triangles = rendered.mesh.triangles.as_flattened();
        triangles.iter().flat_map(|v| v.to_le_bytes()).for_each(&mut add);
    }
    hash
}

fn base() -> Options {
    Options { points: Points::Count(300), ..Options::default() }
}

#[test]
fn both_feature_sets_give_the_stored_bytes() {
    let outline = Some(Colour([20, 30, 40, 255]));
    let alone = Options { quality: Quality::Best, coherence: 0.0, ..base() };
    let cases = [
        ("defaults", base()),
        ("each frame alone", alone),
        ("outline, hard edges", Options { outline, edges: Edges::Hard, ..base() }),
        ("entropy", Options { method: Method::Help, ..base() }),
        ("saliency", Options { method: Method::Hslp, ..base() }),
        ("superpixels", Options { features: Some(FrontEnd::Slic), ..base() }),
    ];
    let renderer = |options: &Options| Renderer::new(options).expect("options in range");
    let of_pixels =
        cases.map(|(name, options)| (name, hash(renderer(&options), |t| frame(t, false))));
    let clear = hash(renderer(&base()), |t| frame(t, true));
    let planes = hash(renderer(&base()).with_form(Some(FORM)), planar);
    let found = [&of_pixels[..], &[("transparent ground", clear), ("planes", planes)]].concat();
    let lines = found.iter().map(|(name, hash)| format!("{hash:016x} {name}\n"));
    assert_eq!(lines.collect::<String>(), include_str!("same_bytes.txt"));
}
