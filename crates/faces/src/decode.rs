//! Faces from what the network says of each place.

use crate::Face;
use crate::net::Reading;

/// Faces that overlap by more are one.
const OVERLAP: f32 = 0.3;

/// The faces that are as certain as `least`, the most certain first, in a picture of which `scale` pixels along each side
/// are one of the network's.
pub(crate) fn faces(readings: &[Reading], scale: [f32; 2], least: f32) -> Vec<Face> {
    let mut found: Vec<Face> = readings.iter().flat_map(|r| places(r, scale, least)).collect();
    // Equal ones stay in the order of places.
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut faces: Vec<Face> = Vec::new();
    for face in found {
        if faces.iter().all(|other| other.overlap(&face) <= OVERLAP) {
            faces.push(face);
        }
    }
    faces
}

fn places(reading: &Reading, scale: [f32; 2], least: f32) -> impl Iterator<Item = Face> + use<'_> {
    let Reading { stride, is_face, fits, bounds } = reading;
    let (columns, stride) = (is_face.width, *stride as f32);
    let each = is_face.values.iter().zip(&fits.values).zip(bounds.values.as_chunks::<4>().0);
    each.enumerate().filter_map(move |(i, ((is_face, fits), [dx, dy, width, height]))| {
        let score = (sigmoid(*is_face) * sigmoid(*fits)).sqrt();
        let (x, y) = ((i % columns) as f32 + dx, (i / columns) as f32 + dy);
        let (width, height) = (width.exp(), height.exp());
        let [left, top] = [(x - width / 2.0) * scale[0], (y - height / 2.0) * scale[1]];
        let sides = [left, top, width * scale[0], height * scale[1]];
        // Whole quarters of pixels, so that the last bits of `exp`, which differ among systems, do not matter.
        let [left, top, width, height] = sides.map(|side| (side * stride * 4.0).round() / 4.0);
        (score >= least).then_some(Face { left, top, width, height, score })
    })
}

fn sigmoid(value: f32) -> f32 {
    1.0 / (1.0 + (-value).exp())
}
