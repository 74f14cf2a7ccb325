//! Outlines of pictures with transparent parts.

use polyreel::frame::{Frame, Rgba};
use polyreel::geom::Size;
use polyreel::options::{Colour, Edges, Options, Points};
use polyreel::render::Renderer;

const SIZE: Size = Size::new(72, 48);

/// A picture whose pixels have the alpha that `alpha` gives for their column.
fn picture(alpha: impl Fn(u32) -> u8) -> Frame {
    let pixel = |i: u32| -> Rgba {
        let (x, y) = (i % SIZE.width, i / SIZE.width);
        match alpha(x) {
            0 => [0; 4],
            a => [(x * 3) as u8, (y * 5) as u8, if (x / 9 + y / 9) % 2 == 0 { 200 } else { 30 }, a],
        }
    };
    Frame::new(SIZE, (0..SIZE.pixels() as u32).map(pixel).collect()).expect("a frame")
}

fn rendered(frame: &Frame, outline: Option<Colour>, contrast: u32) -> Frame {
    let options = Options {
        points: Points::Count(70),
        edges: Edges::Hard,
        outline,
        outline_contrast: contrast,
        ..Options::default()
    };
    let mut renderer = Renderer::new(&options).expect("sound options");
    renderer.render(frame).expect("a picture").picture
}

#[test]
fn nothing_is_drawn_over_what_is_transparent() {
    let frame = picture(|x| if x < 36 { 0 } else { 255 });
    let plain = rendered(&frame, None, 0);
    // Transparent with all that is around it: no line between two triangles of which one is seen.
    let clear = |x: u32, y: u32| {
        let (x, y) = (x.max(1)..x.min(SIZE.width - 2) + 1, y.max(1)..y.min(SIZE.height - 2) + 1);
        let near =
            (y.start - 1..y.end + 1).flat_map(|y| (x.start - 1..x.end + 1).map(move |x| (x, y)));
        near.into_iter().all(|(x, y)| plain.at(x, y)[3] == 0)
    };
    for contrast in [0, 10] {
        let lined = rendered(&frame, Some(Colour([0, 0, 0, 255])), contrast);
        let (mut seen, mut kept) = (0, 0);
        for y in 0..SIZE.height {
            for x in 0..SIZE.width {
                if clear(x, y) {
                    kept += 1;
                    assert_eq!(lined.at(x, y)[3], 0, "({x}, {y}) with contrast {contrast}");
                }
                seen += u32::from(lined.at(x, y) == [0, 0, 0, 255]);
            }
        }
        assert!(kept > 500 && seen > 50, "{kept} transparent, {seen} of lines");
    }
}

#[test]
fn a_line_is_as_opaque_as_what_it_runs_along() {
    let lined = rendered(&picture(|_| 128), Some(Colour([255, 0, 255, 255])), 0);
    assert!(lined.pixels().iter().all(|pixel| pixel[3] == 128));
    assert!(lined.pixels().contains(&[255, 0, 255, 128]));
    // The outline's own alpha counts as well.
    let lined = rendered(&picture(|_| 128), Some(Colour([255, 0, 255, 128])), 0);
    assert!(lined.pixels().contains(&[255, 0, 255, 64]));
}
