//! Smooths the colours of triangles in time, so that flat areas do not shimmer.

use crate::frame::{Fill, Rgba};
use crate::mesh::Mesh;

/// The largest change of a channel that counts as shimmer, in 8-bit steps at coherence 1. Grain and compression
/// change the mean of sixty pixels by less than one step. A larger threshold delays slow changes of the picture, and
/// raises flicker and error (`docs/video.md`).
const SHIMMER: f64 = 2.0;

/// The colours of the last frame's triangles.
#[derive(Clone, Debug, Default)]
pub struct Colours {
    triangles: Vec<[u32; 3]>,
    colours: Vec<Rgba>,
    last: Vec<Rgba>,
}

impl Colours {
    /// Moves the colours of triangles that existed in the last frame (the same three vertices) towards their last
    /// colours. A change up to the shimmer threshold is undone, one of twice as much is halved, and one of four times
    /// as much or more stays, so that moving things do not smear. Stores the colours for the next frame. `coherence`
    /// 0 changes nothing.
    pub fn steady(&mut self, mesh: &Mesh, fills: &mut [Fill], coherence: f64) {
        self.steady_all(&mesh.triangles, fills, coherence);
    }

    /// The same of what is known by `keys`, ascending.
    pub(super) fn steady_all(&mut self, keys: &[[u32; 3]], fills: &mut [Fill], coherence: f64) {
        let shimmer = (SHIMMER * coherence).round() as i32;
        std::mem::swap(&mut self.colours, &mut self.last);
        self.colours.clear();
        let mut old = self.triangles.iter().zip(&self.last).peekable();
        for (triangle, fill) in keys.iter().zip(fills) {
            // Both lists are sorted: a merge finds the common triangles.
            while old.next_if(|(t, _)| *t < triangle).is_some() {}
            if let Some((_, &before)) = old.next_if(|(t, _)| *t == triangle) {
                fill.colour = approach(before, fill.colour, shimmer);
            }
            self.colours.push(fill.colour);
        }
        self.triangles.clear();
        self.triangles.extend_from_slice(keys);
    }

    /// The colour that each triangle of `mesh` had in the last frame, where it was there.
    pub(super) fn before(&self, mesh: &Mesh) -> Vec<Option<Rgba>> {
        let mut old = self.triangles.iter().zip(&self.colours).peekable();
        let before = mesh.triangles.iter().map(|triangle| {
            while old.next_if(|(t, _)| *t < triangle).is_some() {}
            old.next_if(|(t, _)| *t == triangle).map(|(_, &colour)| colour)
        });
        before.collect()
    }

    /// Forgets all colours, for a new shot.
    pub fn forget(&mut self) {
        self.triangles.clear();
        self.colours.clear();
    }
}

/// `now`, or a colour between `before` and `now`.
fn approach(before: Rgba, now: Rgba, shimmer: i32) -> Rgba {
    let difference = |c: usize| i32::from(now[c]) - i32::from(before[c]);
    let largest = (0..4).map(|c| difference(c).abs()).max().unwrap_or(0);
    if largest <= shimmer {
        return before;
    }
    if largest >= 4 * shimmer {
        return now;
    }
    // The share of the change that is kept: 0 at `shimmer`, 1 at four times as much.
    let (part, whole) = (largest - shimmer, 3 * shimmer);
    [0, 1, 2, 3].map(|c| {
        let step = difference(c) * part;
        let rounded = (2 * step + whole * step.signum()) / (2 * whole);
        (i32::from(before[c]) + rounded) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use crate::triangulate::triangulate;

    fn colours(steps: &[u8], coherence: f64) -> Vec<u8> {
        let mesh = triangulate(Size::new(4, 4), &[]).expect("corners");
        let mut memory = Colours::default();
        let paint = |&grey: &u8| {
            let mut fills = [Fill { colour: [grey, grey, grey, 255], area: 8 }; 2];
            memory.steady(&mesh, &mut fills, coherence);
            fills[0].colour[0]
        };
        steps.iter().map(paint).collect()
    }

    #[test]
    fn shimmer_is_held_and_leaps_are_made() {
        assert_eq!(colours(&[100, 101, 99, 100, 101], 0.5), [100; 5]);
        assert_eq!(colours(&[100, 140, 100], 0.5), [100, 140, 100]);
        assert_eq!(colours(&[100, 102, 99], 0.0), [100, 102, 99]);
    }

    #[test]
    fn what_stays_is_reached_and_then_held() {
        let seen = colours(&[100, 106, 106, 106, 106, 106, 106, 106], 0.5);
        assert!(seen.windows(2).all(|w| w[0] <= w[1]), "{seen:?}");
        assert!(seen[7].abs_diff(106) <= 2, "{seen:?}");
        assert_eq!(seen[6], seen[7]);
    }

    #[test]
    fn new_triangles_have_no_memory() {
        let size = Size::new(4, 4);
        let (a, b) = (
            triangulate(size, &[]).expect("two"),
            triangulate(size, &[crate::geom::Point::pixel_centre(1, 1)]).expect("four"),
        );
        let mut memory = Colours::default();
        let fill = |grey| Fill { colour: [grey, grey, grey, 255], area: 1 };
        memory.steady(&a, &mut [fill(10); 2], 1.0);
        let mut fills = [fill(11); 4];
        memory.steady(&b, &mut fills, 1.0);
        assert_eq!(fills, [fill(11); 4]);
    }
}
