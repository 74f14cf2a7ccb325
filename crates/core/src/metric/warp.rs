//! Warping error: flicker along the motion of the picture (Lai, Huang, Wang, Shechtman, Yumer and
//! Yang, "Learning Blind Video Temporal Consistency", ECCV 2018, section 4.2).

use crate::parallel::prelude::*;

use super::same_size;
use crate::error::Result;
use crate::flow::{Flow, between, flow};
use crate::frame::Frame;
use crate::geom::Size;
use crate::plane::Plane;

/// `E_warp`: the mean over pairs of successive frames of the mean over unoccluded pixels and channels
/// of the squared difference, in RGB of 0..1, between `O_t` and `O_t-1` moved along the flow of the
/// source from t to t-1; 0..1. Fed frame by frame; keeps one frame of the source and of the rendering.
///
/// The paper's formula has the sum over the channels; the authors' own evaluation, and so what is
/// published, divides by three times the pixels (`evaluate_WarpError.py` of
/// `phoenix104104/fast_blind_video_consistency`: its mask has three channels).
///
/// A pixel is occluded where the flows there and back disagree, at edges of motion, and where it
/// comes from outside the frame (Ruder, Dosovitskiy and Brox, "Artistic Style Transfer for Videos",
/// 2016, section 4.2).
#[derive(Clone, Debug, Default)]
pub struct WarpError {
    last: Option<(Plane<u8>, Plane<[f32; 3]>)>,
    sum: f64,
    pairs: u64,
}

impl WarpError {
    /// A clip of which nothing was seen yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The next frame of the source and its rendering.
    ///
    /// # Errors
    /// When the two differ in size, or from the frames before.
    pub fn push(&mut self, input: &Frame, output: &Frame) -> Result<()> {
        same_size(input.size(), output.size())?;
        let luma = Plane::luma(input);
        let colours = output.pixels().iter().map(|p| [0, 1, 2].map(|c| f32::from(p[c]) / 255.0));
        let colours = Plane::new(output.size(), colours.collect());
        let colours = colours.expect("a frame holds exactly width x height pixels");
        if let Some((before, painted)) = &self.last {
            let back = flow(&luma, before)?;
            let forth = flow(before, &luma)?;
            // A pair without visible pixels does not count.
            if let Some(error) = warped_difference(&colours, painted, &back, &seen(&back, &forth)) {
                self.sum += error;
                self.pairs += 1;
            }
        }
        self.last = Some((luma, colours));
        Ok(())
    }

    /// The mean so far; `None` before the second frame, or while all was occluded.
    pub fn value(&self) -> Option<f64> {
        (self.pairs > 0).then(|| self.sum / self.pairs as f64)
    }
}

/// Which pixels of the later frame were seen in the earlier one too. `back` leads from the later
/// frame to the earlier, `forth` from the earlier to the later.
pub fn seen(back: &Flow, forth: &Flow) -> Plane<bool> {
    let Size { width, height } = back.size();
    let inside = |v: f32, side: u32| (0.0..=side as f32 - 1.0).contains(&v);
    let square = |v: [f32; 2]| v[0] * v[0] + v[1] * v[1];
    let difference = |a: [f32; 2], b: [f32; 2]| square([a[0] - b[0], a[1] - b[1]]);
    let judge = |i: usize| {
        let (x, y) = (i as u32 % width, i as u32 / width);
        let here = back.values()[i];
        let (u, v) = (x as f32 + here[0], y as f32 + here[1]);
        if !inside(u, width) || !inside(v, height) {
            return false;
        }
        // Ruder et al., equations 5 and 6, with their constants.
        let there = between(forth, u, v);
        let returns = square([there[0] + here[0], there[1] + here[1]])
            <= 0.01 * (square(there) + square(here)) + 0.5;
        let right = back.at((x + 1).min(width - 1), y);
        let below = back.at(x, (y + 1).min(height - 1));
        let slope = difference(right, here) + difference(below, here);
        returns && slope <= 0.01 * square(here) + 0.002
    };
    let values = (0..back.values().len()).into_par_iter().with_min_len(1 << 12).map(judge);
    Plane::new(back.size(), values.collect()).expect("one judgement a pixel")
}

/// Mean over the pixels `seen` and their channels of the squared difference between `now` and `before`
/// moved along `back`; `None` when there are none.
fn warped_difference(
    now: &Plane<[f32; 3]>,
    before: &Plane<[f32; 3]>,
    back: &Flow,
    seen: &Plane<bool>,
) -> Option<f64> {
    let row = |y: u32| {
        let (mut sum, mut count) = (0.0, 0_u64);
        for x in (0..back.size().width).filter(|&x| seen.at(x, y)) {
            let [u, v] = back.at(x, y);
            let (a, b) = (now.at(x, y), between(before, x as f32 + u, y as f32 + v));
            sum += (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>();
            count += 1;
        }
        (sum, count)
    };
    // Rows are added in their order, so that the sum is one on any number of threads.
    let rows: Vec<(f64, u64)> = (0..back.size().height).into_par_iter().map(row).collect();
    let (sum, count) = rows.iter().fold((0.0, 0), |(s, n), row| (s + row.0, n + row.1));
    (count > 0).then(|| sum / (3 * count) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A soft pattern, moved to the right by `shift`.
    fn scene(shift: u32, tint: u8) -> Frame {
        let size = Size::new(120, 90);
        let pixel = |i: u32| {
            let (x, y) = (f64::from(i % 120) - f64::from(shift), f64::from(i / 120));
            let v = 120.0
                + 50.0 * (x * 0.3).sin() * (y * 0.25).cos()
                + 30.0 * (x * 0.1 + y * 0.13).sin();
            [v as u8, v as u8 / 2, tint, 255]
        };
        Frame::new(size, (0..120 * 90).map(pixel).collect()).expect("120 x 90")
    }

    #[test]
    fn a_rendering_that_moves_along_has_next_to_no_error() {
        let mut error = WarpError::new();
        assert_eq!(error.value(), None);
        for t in 0..3 {
            error.push(&scene(2 * t, 9), &scene(2 * t, 9)).expect("one size");
        }
        let moving = error.value().expect("two pairs");
        assert!(moving < 1e-4, "{moving}");
    }

    #[test]
    fn a_change_of_colour_is_its_square() {
        let mut error = WarpError::new();
        for (t, tint) in [(0, 0), (1, 51), (2, 0)] {
            error.push(&scene(3 * t, 0), &scene(3 * t, tint)).expect("one size");
        }
        let value = error.value().expect("two pairs");
        assert!((value - 0.04 / 3.0).abs() < 4e-4, "{value}, not a third of (51 / 255)^2");
    }

    #[test]
    fn a_rendering_that_stands_still_in_a_moving_scene_is_wrong() {
        let mut error = WarpError::new();
        for t in 0..3 {
            error.push(&scene(3 * t, 0), &scene(0, 0)).expect("one size");
        }
        assert!(error.value().expect("two pairs") > 2e-3);
    }

    #[test]
    fn what_comes_from_outside_was_not_seen() {
        let size = Size::new(30, 20);
        let (back, forth) = (Plane::filled(size, [-4.0, 0.0]), Plane::filled(size, [4.0, 0.0]));
        let seen = seen(&back, &forth);
        let rows = (0..20).all(|y| (0..30).all(|x| seen.at(x, y) == (x >= 4)));
        assert!(rows, "the four columns that came in from the left");
        let apart = super::seen(&back, &Plane::filled(size, [0.0, 0.0]));
        assert!(apart.values().iter().all(|&s| !s), "there and not back again");
    }
}
