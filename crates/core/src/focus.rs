//! How much each part of a frame matters: sampling and refinement put their vertices accordingly.

#[cfg(feature = "faces")]
mod faces;

use crate::feature::saliency::saliency;
use crate::frame::Frame;
use crate::geom::{Point, SUBPIXEL, Size};
use crate::options::{Focus, FocusMask, Spot};
use crate::plane::Plane;

/// What matters most weighs this many times what is neutral, and that as many times what matters least.
const STRENGTH: f64 = 4.0;

/// Places along the longer side of a frame.
const ALONG: u32 = 96;

/// How much of the last frame's map is kept, so that facets do not wander with the noise of saliency.
const KEPT: f32 = 0.85;

/// What a place weighs of which a mask says `value`, 0 to 1: in two straight lines, which are the same on all machines.
fn weight(value: f64) -> f64 {
    let least = 1.0 / STRENGTH;
    if value < 0.5 {
        least + 2.0 * value * (1.0 - least)
    } else {
        1.0 + (2.0 * value - 1.0) * (STRENGTH - 1.0)
    }
}

/// How much each place of a frame matters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FocusMap {
    size: Size,
    columns: usize,
    rows: usize,
    weights: Vec<f32>,
}

impl FocusMap {
    /// A map of a frame of `size` by what `value`, 0 to 1, says of places in pixels.
    fn new(size: Size, value: impl Fn(f64, f64) -> f64) -> Self {
        let longer = size.width.max(size.height).max(1);
        let places = |side: u32| (u64::from(side) * u64::from(ALONG)).div_ceil(u64::from(longer));
        let (columns, rows) =
            (places(size.width).max(1) as usize, places(size.height).max(1) as usize);
        let at =
            |i: usize, count: usize, side: u32| (i as f64 + 0.5) / count as f64 * f64::from(side);
        let weights = (0..rows * columns).map(|i| {
            let (x, y) = (at(i % columns, columns, size.width), at(i / columns, rows, size.height));
            weight(value(x, y).clamp(0.0, 1.0)) as f32
        });
        Self { size, columns, rows, weights: weights.collect() }
    }

    /// How much the place `p` matters: above 1 more, below 1 less than others.
    pub(crate) fn at(&self, p: Point) -> f64 {
        let place = |v: i32, side: u32, count: usize| {
            let far = i64::from(side) * i64::from(SUBPIXEL);
            (i64::from(v.max(0)) * count as i64 / far.max(1)).clamp(0, count as i64 - 1) as usize
        };
        let x = place(p.x, self.size.width, self.columns);
        let y = place(p.y, self.size.height, self.rows);
        f64::from(self.weights[y * self.columns + x])
    }

    fn spot(size: Size, Spot { x, y, radius }: Spot) -> Self {
        let (x, y) = (x.of(size.width), y.of(size.height));
        let radius = radius.of(size.width.min(size.height)).max(1.0);
        // From the radius on it falls, over as much again.
        let squared = |px: f64, py: f64| (px - x) * (px - x) + (py - y) * (py - y);
        Self::new(size, |px, py| 2.0 - squared(px, py).sqrt() / radius)
    }

    fn mask(size: Size, mask: &FocusMask) -> Self {
        let pick = |v: f64, side: u32, own: u32| {
            ((v / f64::from(side) * f64::from(own)) as u32).min(own.saturating_sub(1)) as usize
        };
        Self::new(size, |x, y| {
            let (x, y) =
                (pick(x, size.width, mask.size.width), pick(y, size.height, mask.size.height));
            f64::from(mask.weights[y * mask.size.width as usize + x]) / 255.0
        })
    }

    fn saliency(frame: &Frame) -> Self {
        let size = frame.size();
        let map = saliency(&Plane::luma(frame));
        let mut sorted: Vec<f32> = map.values().iter().step_by(61).copied().collect();
        sorted.sort_unstable_by(f32::total_cmp);
        // The map is steep: its 95th per cent counts as all.
        let all = f64::from(sorted[sorted.len() * 95 / 100]).max(1e-9);
        let mut focus = Self::new(size, |x, y| {
            let value = map.at((x as u32).min(size.width - 1), (y as u32).min(size.height - 1));
            (f64::from(value) / all).sqrt()
        });
        for _ in 0..3 {
            focus.soften();
        }
        focus
    }

    /// The same with most of the `last` frame's, if there is one.
    fn follow(mut self, last: Option<Self>) -> Self {
        for (now, last) in self.weights.iter_mut().zip(last.iter().flat_map(|last| &last.weights)) {
            *now += KEPT * (last - *now);
        }
        self
    }

    /// Each place becomes the mean of itself and those around it.
    fn soften(&mut self) {
        let (columns, rows) = (self.columns, self.rows);
        let old = &self.weights;
        let near = |v: usize, d: usize, most: usize| (v + d).saturating_sub(1).min(most - 1);
        let mean = |i: usize| {
            let (x, y) = (i % columns, i / columns);
            let around =
                (0..9).map(|k| old[near(y, k / 3, rows) * columns + near(x, k % 3, columns)]);
            around.sum::<f32>() / 9.0
        };
        self.weights = (0..columns * rows).map(mean).collect();
    }
}

/// The maps of a stream of frames.
#[derive(Debug, Default)]
pub(crate) struct FocusKeeper {
    wanted: Option<Focus>,
    last: Option<FocusMap>,
    #[cfg(feature = "faces")]
    faces: faces::Faces,
}

impl FocusKeeper {
    pub(crate) fn new(wanted: Option<&Focus>) -> Self {
        Self { wanted: wanted.cloned(), ..Self::default() }
    }

    /// The number of faces that the last map is of, if they were asked for.
    pub(crate) fn faces(&self) -> Option<usize> {
        #[cfg(feature = "faces")]
        return matches!(self.wanted, Some(Focus::Faces)).then(|| self.faces.count());
        #[cfg(not(feature = "faces"))]
        return None;
    }

    /// Where the faces are; `None` where there are none.
    #[cfg(feature = "faces")]
    fn faces_of(&mut self, frame: &Frame, is_fresh: bool) -> Option<FocusMap> {
        self.faces.map(frame, is_fresh)
    }

    /// A build without the feature has refused such options: see [`Focus::validate`].
    #[cfg(not(feature = "faces"))]
    fn faces_of(&mut self, _: &Frame, _: bool) -> Option<FocusMap> {
        None
    }

    /// The map of the next `frame`; `is_fresh` says that it does not continue the last one.
    pub(crate) fn map(&mut self, frame: &Frame, is_fresh: bool) -> Option<&FocusMap> {
        let size = frame.size();
        let last = self.last.take().filter(|last| last.size == size);
        // What is the same in every frame outlives cuts.
        let found = match (self.wanted.as_ref()?, last) {
            (Focus::Spot(_) | Focus::Mask(_), Some(last)) => last,
            (Focus::Spot(spot), None) => FocusMap::spot(size, *spot),
            (Focus::Mask(mask), None) => FocusMap::mask(size, mask),
            (Focus::Saliency, last) => FocusMap::saliency(frame).follow(last.filter(|_| !is_fresh)),
            (Focus::Faces, last) => {
                let last = last.filter(|_| !is_fresh);
                let faces = self.faces_of(frame, last.is_none());
                faces.unwrap_or_else(|| FocusMap::saliency(frame)).follow(last)
            }
        };
        self.last = Some(found);
        self.last.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::{Options, Points};
    use crate::render::Renderer;

    fn disks(size: Size) -> Frame {
        let pixel = |i: usize| {
            let (x, y) = ((i % size.width as usize) as i32, (i / size.width as usize) as i32);
            let v = ((x / 6 + y / 6) % 2 * 90 + x % 6 * 9) as u8;
            [v, 255 - v, 90, 255]
        };
        Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("small")
    }

    #[test]
    fn a_spot_has_more_seeds_than_the_rest() {
        let size = Size::new(160, 120);
        let within = |focus: Option<&str>| {
            let focus = focus.map(|text| text.parse().expect(text));
            let options = Options { points: Points::Count(200), focus, ..Options::default() };
            let mut renderer = Renderer::new(&options).expect("sound");
            let mesh = renderer.render(&disks(size)).expect("rendered").mesh;
            assert_eq!(mesh.seeds().len(), 200);
            let near = |p: &&Point| {
                let (x, y) = p.to_pixels();
                (x - 40.0).hypot(y - 60.0) < 30.0
            };
            mesh.seeds().iter().filter(near).count()
        };
        let (plain, focused) = (within(None), within(Some("25%,50%,25%")));
        assert!(focused * 10 >= plain * 16, "{focused} and {plain}");
        assert_eq!(within(Some("40,60,30")), focused);
    }

    #[test]
    fn masks_are_stretched_and_what_matters_most_weighs_most() {
        let (size, weights) = (Size::new(2, 1), std::sync::Arc::from([0, 255]));
        let mask = FocusMask { name: "a.png".into(), size, weights };
        let map = FocusMap::mask(Size::new(300, 100), &mask);
        assert_eq!(map.at(Point::pixel_centre(10, 50)), 0.25);
        assert_eq!(map.at(Point::pixel_centre(290, 50)), 4.0);
        let last = FocusMap::saliency(&disks(Size::new(90, 70)));
        assert!(last.weights.iter().all(|w| (0.24..=4.01).contains(w)));
    }
}
