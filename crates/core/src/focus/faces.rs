//! Where the faces of a frame are, found by the crate `polyreel-faces`.

use polyreel_faces::{Detector, Face};

use super::FocusMap;
use crate::frame::Frame;
use crate::geom::Size;

/// A face is one from this certainty on. On 26 stills and clips, of 19 faces, eight of them drawn, all but those below 24
/// pixels in 640 are more certain than that, and three things that are no faces.
const CERTAIN: f32 = 0.7;

/// One that was there before stays one down to this.
const STAYS: f32 = 0.5;

/// The overlap from which on it is the same.
const SAME: f32 = 0.3;

/// Frames of a shot from one search for faces to the next: within 4 of them the map has changed by half.
const EVERY: u32 = 4;

/// How far a face reaches beyond its box, as a share of that, so that its outline belongs to it.
const REACH: f64 = 1.25;

/// What a place is worth that is in no face, 0 to 1: less than by default, as faces have more.
const ELSEWHERE: f64 = 0.35;

/// The faces of a stream of frames.
#[derive(Debug, Default)]
pub(super) struct Faces {
    detector: Detector,
    found: Vec<Face>,
    /// Frames since the shot began.
    age: u32,
}

impl Faces {
    /// The number that was found last.
    pub(super) fn count(&self) -> usize {
        self.found.len()
    }

    /// Where the faces of the next `frame` are; `None` without any. `is_fresh` says that it does not continue the last
    /// one.
    pub(super) fn map(&mut self, frame: &Frame, is_fresh: bool) -> Option<FocusMap> {
        if is_fresh {
            (self.age, self.found) = (0, Vec::new());
        }
        if self.age.is_multiple_of(EVERY) {
            self.look(frame);
        }
        self.age = self.age.wrapping_add(1);
        (!self.found.is_empty()).then(|| of(&self.found, frame.size()))
    }

    fn look(&mut self, frame: &Frame) {
        let size = frame.size();
        let mut found =
            self.detector.find(frame.pixels(), size.width as usize, size.height as usize, STAYS);
        let was_there = |face: &Face| self.found.iter().any(|last| last.overlap(face) > SAME);
        found.retain(|face| face.score >= CERTAIN || was_there(face));
        self.found = found;
    }
}

/// The map of `faces`: all within their ellipses, falling to what is elsewhere over half as much again.
fn of(faces: &[Face], size: Size) -> FocusMap {
    FocusMap::new(size, |x, y| {
        let values = faces.iter().map(|face| {
            let along = |v: f64, from: f32, long: f32| {
                let half = f64::from(long.max(1.0)) / 2.0;
                (v - f64::from(from) - half) / (half * REACH)
            };
            let (x, y) = (along(x, face.left, face.width), along(y, face.top, face.height));
            3.0 - 2.0 * (x * x + y * y).sqrt()
        });
        values.fold(ELSEWHERE, f64::max)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Point;

    #[test]
    fn faces_matter_most_and_the_rest_a_little_less_than_by_default() {
        let face = Face { left: 40.0, top: 20.0, width: 40.0, height: 60.0, score: 0.9 };
        let map = of(&[face], Size::new(200, 100));
        assert_eq!(map.at(Point::pixel_centre(60, 50)), 4.0);
        assert_eq!(map.at(Point::pixel_centre(60, 80)), 4.0, "the chin");
        let away = map.at(Point::pixel_centre(180, 50));
        assert!((0.5..1.0).contains(&away), "{away}");
    }

    #[test]
    fn frames_without_faces_have_no_map() {
        let frame = Frame::filled(Size::new(90, 60), [120, 90, 40, 255]).expect("a sound size");
        let mut faces = Faces::default();
        assert_eq!(faces.map(&frame, true), None);
        assert_eq!((faces.map(&frame, false), faces.count()), (None, 0));
    }
}
