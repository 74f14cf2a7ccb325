//! Refines to a target likeness, and finds the fewest points that reach it.

use super::mesh::Observer;
use crate::error::{Error, Result};
use crate::feature::Features;
use crate::frame::Frame;
use crate::mesh::Mesh;
use crate::metric::mse::{mse, psnr};
use crate::metric::over_white;
use crate::metric::ssim::ssim;
use crate::options::{Edges, FillMode, Options, Points, Target};
use crate::rasterise::filled;
use crate::refine::{RefineOptions, Refined, Refiner};
use crate::sample::Sampler;
use crate::triangulate::triangulate;

/// A lower bound of the squared error with smooth edges, as a share of that with hard ones. It was 0.75 to 1.17 on 16
/// stills.
const MIN_SMOOTH_SHARE: f64 = 0.5;

/// Likeness at which refinement stops.
#[derive(Clone, Copy, Debug)]
pub(super) struct Goal {
    target: Target,
    edges: Edges,
    fill: FillMode,
}

impl Goal {
    /// The goal of the `options`, if they have one.
    pub(super) fn of(options: &Options) -> Option<Self> {
        let Options { edges, fill, .. } = *options;
        options.error.map(|target| Self { target, edges, fill })
    }

    /// The likeness of the painted `mesh` to `source`, which is `frame` over white. Outlines are not
    /// drawn: they do not count as error.
    fn measure(self, source: &Frame, mesh: &Mesh, frame: &Frame) -> Result<f64> {
        let painted = over_white(&filled(mesh, frame, self.edges, self.fill).frame);
        match self.target {
            Target::Psnr(_) => Ok(psnr(mse(source, &painted)?)),
            Target::Ssim(_) => ssim(source, &painted),
        }
    }
}

/// Refines a fresh `mesh` until its rendering is as like `frame` as the `goal` requires, or `plan` ends. `observer`
/// gets the mesh and its squared error before every step.
///
/// # Errors
/// When the likeness cannot be measured on a frame of this size.
pub(super) fn reach(
    goal: Goal,
    refiner: &mut Refiner,
    mesh: &mut Mesh,
    frame: &Frame,
    plan: &RefineOptions,
    observer: Observer<'_>,
) -> Result<Refined> {
    let Goal { target, edges, .. } = goal;
    let source = over_white(frame);
    let samples = (3 * frame.size().pixels()) as f64;
    let min_share = if edges == Edges::Smooth { MIN_SMOOTH_SHARE } else { 1.0 };
    let mut failure = None;
    let mut watch = |mesh: &Mesh, error: f64| {
        observer(mesh, error);
        // Rounded colours have a larger error: most steps need not be painted.
        if let Target::Psnr(db) = target
            && frame.is_opaque()
            && psnr(min_share * error / samples) < db
        {
            return true;
        }
        match goal.measure(&source, mesh, frame) {
            Ok(likeness) => likeness < target.value(),
            Err(error) => {
                failure = Some(error);
                false
            }
        }
    };
    let mut refined = refiner.still(mesh, frame, plan, Some(&mut watch));
    if let Some(error) = failure {
        return Err(error);
    }
    refined.likeness = Some(goal.measure(&source, mesh, frame)?);
    Ok(refined)
}

/// The first number of points of the search.
const FIRST: u32 = 32;

/// Pixels for each point at least: with more points, triangles would have two pixels.
const PIXELS_A_POINT: usize = 4;

/// Relative precision of the search: one part in this many.
const PRECISION: u32 = 50;

/// The fewest points that reach the `goal` on `frame`, to 2 %: doubled until they do, then by bisection. At most a
/// quarter of the pixels.
///
/// # Errors
/// When that many do not reach it, or the likeness cannot be measured.
pub(super) fn fewest(
    options: &Options,
    goal: Goal,
    features: &Features,
    frame: &Frame,
) -> Result<u32> {
    let max = u32::try_from(frame.size().pixels() / PIXELS_A_POINT).unwrap_or(u32::MAX).max(1);
    let try_out = |count: u32| -> Result<f64> {
        let options = Options { points: Points::Count(count), ..options.clone() };
        let seeds = Sampler::new(&options).choose(features, frame);
        let mut mesh = triangulate(frame.size(), &seeds)?;
        let plan = RefineOptions::fresh(&options);
        // A new refiner: what is known of another mesh must not count.
        let refined =
            reach(goal, &mut Refiner::default(), &mut mesh, frame, &plan, &mut |_, _| ())?;
        Ok(refined.likeness.unwrap_or(f64::NEG_INFINITY))
    };
    let target = goal.target;
    let (mut low, mut high) = (0, FIRST.min(max));
    loop {
        let likeness = try_out(high)?;
        if likeness >= target.value() {
            break;
        }
        if high == max {
            return Err(Error::Unreachable {
                target: target.describe(target.value()),
                most: max as usize,
                pixels_a_point: PIXELS_A_POINT,
                likeness: target.describe(likeness),
            });
        }
        (low, high) = (high, high.saturating_mul(2).min(max));
    }
    while high - low > (high / PRECISION).max(1) {
        let middle = low + (high - low) / 2;
        if try_out(middle)? >= target.value() {
            high = middle;
        } else {
            low = middle;
        }
    }
    Ok(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use crate::render::{Rendered, Renderer};

    /// Soft waves with an edge through them.
    fn scene() -> Frame {
        let size = Size::new(96, 72);
        let pixel = |i: usize| {
            let (x, y) = ((i % 96) as f64, (i / 96) as f64);
            let wave = 110.0 + 60.0 * (x * 0.16).sin() * (y * 0.13).cos();
            let v = if x + 2.0 * y > 130.0 { 255.0 - wave } else { wave };
            [v as u8, (v * 0.7) as u8, (x * 2.0) as u8, 255]
        };
        Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("as many as it has")
    }

    fn rendered(points: Points, error: Option<Target>) -> Result<Rendered> {
        Renderer::new(&Options { points, error, ..Options::default() })?.render(&scene())
    }

    #[test]
    fn refinement_stops_at_the_first_step_that_reaches_the_target() {
        let points = Points::Count(150);
        let steps = |target| rendered(points, Some(target)).expect("measurable").refine_steps;
        let free = Options { points, refine: Some(0), coherence: 0.0, ..Options::default() };
        let free = Renderer::new(&free).expect("sound").render(&scene()).expect("renders");
        let before = psnr(mse(&scene(), &free.picture).expect("one size"));
        assert_eq!(steps(Target::Psnr(before - 0.1)), 0, "reached before the first step");
        let near = rendered(points, Some(Target::Psnr(before + 1.0))).expect("measurable");
        let likeness = near.likeness.expect("a target was given");
        assert!(likeness >= before + 1.0 && near.refine_steps > 0, "{likeness}");
        let painted = psnr(mse(&scene(), &near.picture).expect("one size"));
        assert_eq!(painted, likeness, "it is the likeness of the picture that comes out");
        assert!(steps(Target::Psnr(before + 2.0)) >= near.refine_steps);
    }

    #[test]
    fn a_target_out_of_reach_is_reported() {
        let far = rendered(Points::Count(40), Some(Target::Ssim(0.999))).expect("measurable");
        assert!(far.likeness.expect("a target was given") < 0.999);
        let error = rendered(Points::Auto, Some(Target::Psnr(90.0))).expect_err("out of reach");
        assert!(error.to_string().contains("cannot be reached"), "{error}");
        let tiny = Frame::filled(Size::new(5, 5), [9, 9, 9, 255]).expect("a sound size");
        let options = Options { error: Some(Target::Ssim(0.5)), ..Options::default() };
        assert!(Renderer::new(&options).expect("sound").render(&tiny).is_err(), "below the window");
    }

    #[test]
    fn auto_is_the_fewest_points_and_stays() {
        for target in [Target::Psnr(27.0), Target::Ssim(0.8)] {
            let options =
                Options { points: Points::Auto, error: Some(target), ..Options::default() };
            let mut renderer = Renderer::new(&options).expect("sound");
            let first = renderer.render(&scene()).expect("within reach");
            assert!(first.likeness.expect("a target was given") >= target.value());
            let count = first.mesh.seeds().len();
            let fewer = Points::Count((count - (count / 50).max(1)) as u32);
            let fewer = rendered(fewer, Some(target)).expect("measurable");
            assert!(fewer.likeness.expect("a target was given") < target.value(), "{count}");
            let second = renderer.render(&scene()).expect("within reach");
            assert_eq!(second.mesh.seeds().len(), count);
        }
    }
}
