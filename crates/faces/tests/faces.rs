//! Faces of ellipses, which the network takes for faces.

mod drawing;

use drawing::{Place, faces_at};
use polyreel_faces::{Detector, Face};

const SIZE: (usize, usize) = (320, 200);
const TWO: [Place; 2] = [[90.0, 90.0, 45.0], [230.0, 110.0, 30.0]];

fn picture(places: &[Place], (width, height): (usize, usize), scale: f64) -> Vec<[u8; 4]> {
    let pixel = |i: usize| {
        let (x, y) = ((i % width) as f64 / scale, (i / width) as f64 / scale);
        let ground = [(90.0 + x * 0.1) as u8, (110.0 + y * 0.1) as u8, 140, 255];
        faces_at(places, x, y).unwrap_or(ground)
    };
    (0..width * height).map(pixel).collect()
}

fn found(places: &[Place], scale: f64) -> Vec<Face> {
    let side = |side: usize| (side as f64 * scale) as usize;
    let size = (side(SIZE.0), side(SIZE.1));
    Detector::new().find(&picture(places, size, scale), size.0, size.1, 0.7)
}

/// The figures are those of onnxruntime 1.23 for the model with its parameters in half precision.
#[test]
fn faces_are_where_onnxruntime_finds_them() {
    let expected = [
        Face { left: 206.51, top: 78.81, width: 49.16, height: 65.53, score: 0.9011 },
        Face { left: 54.70, top: 46.58, width: 73.08, height: 96.98, score: 0.8988 },
    ];
    let found = found(&TWO, 1.0);
    assert_eq!(found.len(), 2, "{found:?}");
    for (found, expected) in found.iter().zip(&expected) {
        assert!(found.overlap(expected) > 0.99, "{found:?}, expected {expected:?}");
        assert!((found.score - expected.score).abs() < 1e-3, "{found:?}, expected {expected:?}");
    }
}

#[test]
fn a_large_picture_has_its_faces_at_its_own_size() {
    let small = found(&TWO, 1.0);
    for scale in [1.5, 4.0] {
        let large = found(&TWO, scale);
        assert_eq!(large.len(), 2, "{large:?}");
        for face in &large {
            let k = 1.0 / scale as f32;
            let face = Face {
                left: face.left * k,
                top: face.top * k,
                width: face.width * k,
                height: face.height * k,
                ..*face
            };
            assert!(small.iter().any(|small| small.overlap(&face) > 0.8), "{face:?}");
        }
    }
}

#[test]
fn a_picture_without_faces_has_none() {
    assert_eq!(found(&[], 1.0), []);
}

#[test]
fn pictures_of_any_shape_are_taken() {
    for size in [(1, 1), (1, 700), (2000, 3), (33, 31), (0, 5)] {
        let grey = vec![[90, 120, 60, 255]; size.0 * size.1];
        assert_eq!(Detector::new().find(&grey, size.0, size.1, 0.7), [], "{size:?}");
    }
}

/// The hidden colours of transparent pixels do not count.
#[test]
fn what_is_transparent_has_no_face() {
    let mut pixels = picture(&TWO, SIZE, 1.0);
    pixels.iter_mut().for_each(|pixel| pixel[3] = 0);
    assert_eq!(Detector::new().find(&pixels, SIZE.0, SIZE.1, 0.5), []);
}
