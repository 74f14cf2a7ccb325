//! `--focus faces` through the whole chain.

#[path = "../../crates/faces/tests/drawing/mod.rs"]
mod drawing;

use drawing::{Place, faces_at};
use polyreel::frame::{Frame, Rgba};
use polyreel::geom::Size;
use polyreel::options::{Focus, Options, Points};
use polyreel::render::{Rendered, Renderer};

const SIZE: Size = Size::new(640, 420);
const GROUP: [Place; 5] = [
    [90.0, 120.0, 24.0],
    [210.0, 90.0, 22.0],
    [330.0, 130.0, 26.0],
    [450.0, 100.0, 23.0],
    [560.0, 140.0, 25.0],
];

/// A group before a wall of bricks and behind a chequered table.
fn group(places: &[Place], shift: f64) -> Frame {
    let pixel = |i: u32| -> Rgba {
        let (x, y) = (i % SIZE.width, i / SIZE.width);
        if let Some(colour) = faces_at(places, f64::from(x) - shift, f64::from(y)) {
            return colour;
        }
        let is_table = y > 290;
        let (column, row) = ((x + 9 * (y / 12 % 2)) / 19, y / 12);
        match (is_table, (x / 16 + y / 16) % 2) {
            (true, 0) => [30, 34, 40, 255],
            (true, _) => [220, 214, 200, 255],
            _ if y % 12 < 2 || (x + 9 * (row % 2)) % 19 < 2 => [200, 190, 180, 255],
            _ => [150 + (column * 37 % 40) as u8, 80, 60 + (row * 29 % 30) as u8, 255],
        }
    };
    Frame::new(SIZE, (0..SIZE.pixels() as u32).map(pixel).collect()).expect("a frame")
}

fn renderer(focus: Option<Focus>) -> Renderer {
    let options = Options { points: Points::Count(1500), focus, ..Options::default() };
    Renderer::new(&options).expect("sound options")
}

/// The mean squared error of the pixels inside the faces.
fn error_inside(rendered: &Rendered, source: &Frame) -> f64 {
    let inside = |&i: &usize| {
        let (x, y) = ((i as u32 % SIZE.width) as f64, (i as u32 / SIZE.width) as f64);
        GROUP.iter().any(|[mid_x, mid_y, r]| (x - mid_x).hypot(y - mid_y) < 1.1 * r)
    };
    let pixels: Vec<usize> = (0..SIZE.pixels()).filter(inside).collect();
    let squares = pixels.iter().map(|&i| {
        let (a, b) = (rendered.picture.pixels()[i], source.pixels()[i]);
        (0..3).map(|k| (f64::from(a[k]) - f64::from(b[k])).powi(2)).sum::<f64>() / 3.0
    });
    squares.sum::<f64>() / pixels.len() as f64
}

#[test]
fn a_group_keeps_its_faces() {
    let source = group(&GROUP, 0.0);
    let of = |focus| renderer(focus).render(&source).expect("rendered");
    let (plain, focused) = (of(None), of(Some(Focus::Faces)));
    assert_eq!((plain.faces, focused.faces), (None, Some(GROUP.len())));
    assert_eq!(focused.mesh.seeds().len(), 1500);
    let (plain, focused) = (error_inside(&plain, &source), error_inside(&focused, &source));
    assert!(focused < 0.6 * plain, "{focused} and {plain}");
}

#[test]
fn without_faces_it_is_saliency() {
    let source = group(&[], 0.0);
    let of = |focus| renderer(Some(focus)).render(&source).expect("rendered");
    let (faces, saliency) = (of(Focus::Faces), of(Focus::Saliency));
    assert_eq!(faces.faces, Some(0));
    assert!(faces.picture == saliency.picture);
}

#[test]
fn faces_stay_in_focus_while_they_move() {
    let mut renderer = renderer(Some(Focus::Faces));
    let inside = |mesh: &polyreel::mesh::Mesh, shift: f64| {
        let near = |p: &&polyreel::geom::Point| {
            let (x, y) = p.to_pixels();
            GROUP.iter().any(|[mid_x, mid_y, r]| (x - mid_x - shift).hypot(y - mid_y) < 1.2 * r)
        };
        mesh.seeds().iter().filter(near).count()
    };
    let counts: Vec<usize> = (0..10)
        .map(|n| {
            let shift = f64::from(n) * 1.5;
            let rendered = renderer.render(&group(&GROUP, shift)).expect("rendered");
            assert_eq!(rendered.faces, Some(GROUP.len()), "frame {n}");
            inside(&rendered.mesh, shift)
        })
        .collect();
    let (least, most) = (counts.iter().min(), counts.iter().max());
    assert!(least.zip(most).is_some_and(|(least, most)| least * 4 >= most * 3), "{counts:?}");
}
