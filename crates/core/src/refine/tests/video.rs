//! From frame to frame: parts of the mesh become inactive where the picture is constant, and active where it changes.

use super::*;
use crate::options::Options;
use crate::rasterise::{PaintHints, Painter};
use crate::residual::ResidualRequest;

#[test]
fn a_still_settles_and_then_stays() {
    let frame = picture(Size::new(120, 90), 2, 40, true);
    let mut mesh = scattered(frame.size(), 300);
    let best = RefineOptions { steps: 500, ..RefineOptions::best() };
    let mut refiner = Refiner::default();
    let refined = refiner.still(&mut mesh, &frame, &best, None);
    assert!(refined.steps < 200, "still busy after {} steps", refined.steps);
    let settled = mesh.clone();
    let again = refiner.frame(&mut mesh, &frame, &best, None);
    assert!(again.steps < 5, "{again:?}");
    assert_eq!((again.moved, again.flipped), (0, 0));
    assert!(mesh == settled && again.replaced.is_empty());
}

#[test]
fn a_still_video_stands_still_before_its_tenth_frame() {
    let frame = picture(Size::new(120, 90), 2, 40, true);
    let mut mesh = scattered(frame.size(), 300);
    let mut refiner = Refiner::default();
    refiner.still(&mut mesh, &frame, &RefineOptions::normal(), None);
    let live = RefineOptions { threshold: 0.0, replace: 0.02, ..RefineOptions::live() };
    let mut last = mesh.clone();
    for t in 1..30 {
        let refined = refiner.frame(&mut mesh, &frame, &live, None);
        assert_eq!(mesh.check(), Ok(()));
        if t == 1 {
            assert!(refined.moved > 0, "nothing is left to do: this proves nothing");
        }
        assert!(t < 9 || mesh == last, "frame {t} differs: {refined:?}");
        last.clone_from(&mesh);
    }
}

/// In parts of a step a video gets as far as in whole ones, and its mesh becomes constant, in as many more frames as
/// there are parts. Activity once counted frames, and most vertices became inactive before their turn.
#[test]
fn parts_of_a_step_get_as_far_as_steps() {
    let frame = picture(Size::new(240, 180), 2, 40, true);
    let course = |steps: u32, part: u32, frames: u32| {
        let mut mesh = scattered(frame.size(), 1500);
        let mut refiner = Refiner::default();
        refiner.still(
            &mut mesh,
            &frame,
            &RefineOptions { steps: 1, ..RefineOptions::normal() },
            None,
        );
        let live = RefineOptions { steps, part, threshold: 0.0, ..RefineOptions::live() };
        let mut errors = Vec::new();
        let mut moved = 0;
        for _ in 0..frames {
            let refined = refiner.frame(&mut mesh, &frame, &live, None);
            assert_eq!((mesh.check(), refined.steps), (Ok(()), 1));
            moved = refined.moved + refined.flipped + refined.replaced.len();
            errors.push(refined.error_after);
        }
        assert_eq!(moved, 0, "{steps} {part}: still busy after {frames} frames");
        (errors[0], errors[frames as usize - 1])
    };
    let (first, last) = course(1, 0, 20);
    for (part, parts) in [(1, 8), (2, 4), (4, 2)] {
        let (first_part, last_part) = course(0, part, 20 * parts);
        assert!(first_part > first, "{part}: a part does less than all");
        assert!(last_part <= 1.05 * last, "{part}: {last_part} after parts, {last} after steps");
    }
}

/// A mesh that was not refined for lack of time is refined as a new one.
#[test]
fn a_prepared_mesh_is_refined_as_a_new_one() {
    let frame = picture(Size::new(160, 120), 2, 40, true);
    let mut refiner = Refiner::default();
    refine_in(&mut refiner, &frame, 200);
    let mut prepared = scattered(frame.size(), 900);
    let mut anew = prepared.clone();
    refiner.prepare(&prepared);
    let live = RefineOptions { steps: 1, ..RefineOptions::live() };
    let first = refiner.frame(&mut prepared, &frame, &live, None);
    assert!(first.moved > 100, "nothing to tell");
    assert_eq!(first, refine(&mut anew, &frame, &live));
    assert_eq!(prepared, anew);
}

/// The time of a step does not depend on how much of the picture moves.
#[test]
fn a_step_of_a_running_video_moves_at_most_a_share_of_the_vertices() {
    let frame = picture(Size::new(160, 120), 2, 40, true);
    let moved = |mode| {
        let mut mesh = scattered(frame.size(), 900);
        let live = RefineOptions { steps: 1, threshold: 0.0, mode, ..RefineOptions::live() };
        (refine(&mut mesh, &frame, &live).moved, mesh.vertices.len())
    };
    let (all, vertices) = moved(Mode::Quick);
    assert!(2 * all > vertices, "hardly any of {vertices} has a way to go: {all}");
    let (some, _) = moved(Mode::Stream);
    assert!(some > vertices / 8 && some <= (0.25 * vertices as f64).ceil() as usize, "{some}");
}

fn refine_in(refiner: &mut Refiner, frame: &Frame, count: u32) {
    refiner.still(&mut scattered(frame.size(), count), frame, &RefineOptions::normal(), None);
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_gives_the_same_mesh_after_parts_of_steps() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let mut refiner = Refiner::default();
        let mut mesh = scattered(Size::new(160, 120), 1400);
        let course = (0..12).map(|t| {
            let frame = picture(mesh.size, 5 + u64::from(t / 3), 80, true);
            let live =
                RefineOptions { steps: t / 10, part: (3 * t + 1) % 8, ..RefineOptions::live() };
            let refined = pool.install(|| refiner.frame(&mut mesh, &frame, &live, None));
            (refined, mesh.clone())
        });
        course.collect::<Vec<_>>()
    };
    let one = run(1);
    assert!(one.iter().filter(|(refined, _)| refined.moved > 20).count() > 8, "nothing to tell");
    for threads in [2, 8] {
        assert!(run(threads) == one, "{threads} threads");
    }
}

/// `clean` with the noise of frame `t`, nearly Gaussian, of a standard deviation of `sigma` steps.
fn with_noise(clean: &Frame, sigma: f64, t: u32) -> Frame {
    let mut at = 0;
    let noise = |v: u8| {
        at += 1;
        let bytes = rank(77, Purpose::Noise, at, t).to_le_bytes();
        // Four uniform bytes, twice: a standard deviation of 296.
        let sum: i32 = bytes[..4].iter().map(|&b| i32::from(b) * 2 - 255).sum();
        (i32::from(v) + (f64::from(sum) * sigma / 296.0).round() as i32).clamp(0, 255) as u8
    };
    let pixels: Vec<_> = clean.pixels().iter().flatten().copied().map(noise).collect();
    let (pixels, _) = pixels.as_chunks::<4>();
    let opaque = pixels.iter().map(|&[r, g, b, _]| [r, g, b, 255]).collect();
    Frame::new(clean.size(), opaque).expect("a small frame")
}

/// Noise of sigma 2 never activates a constant mesh.
#[test]
fn noise_moves_nothing() {
    let size = Size::new(160, 120);
    for seed in 0..24 {
        let clean = picture(size, seed, 0, true);
        let noisy = |t: u32| with_noise(&clean, 2.0, t + 100 * seed as u32);
        let mut mesh = scattered(size, 160);
        let mut refiner = Refiner::default();
        refiner.still(&mut mesh, &noisy(0), &RefineOptions::normal(), None);
        for t in 1..30 {
            let refined = refiner.frame(&mut mesh, &noisy(t), &RefineOptions::live(), None);
            let changes = refined.moved + refined.flipped + refined.replaced.len();
            assert!(t < 10 || changes == 0, "picture {seed}, frame {t}: {refined:?}");
        }
    }
}

/// An inactive part becomes active when the picture changes there, and only there.
#[test]
fn a_change_wakes_its_surroundings() {
    let size = Size::new(160, 120);
    let frame = picture(size, 4, 0, true);
    let mut mesh = scattered(size, 160);
    let mut refiner = Refiner::default();
    refiner.still(&mut mesh, &frame, &RefineOptions::normal(), None);
    for _ in 0..12 {
        refiner.frame(&mut mesh, &frame, &RefineOptions::live(), None);
    }
    let mut pixels = frame.pixels().to_vec();
    for y in 90..110 {
        for x in 120..140 {
            pixels[y * 160 + x] = [255, 0, 0, 255];
        }
    }
    let changed = Frame::new(size, pixels).expect("a small frame");
    let before = mesh.clone();
    let live = RefineOptions { replace: 0.0, ..RefineOptions::live() };
    let refined = refiner.frame(&mut mesh, &changed, &live, None);
    assert!(refined.moved > 0);
    for (a, b) in before.vertices.iter().zip(&mesh.vertices).filter(|(a, b)| a != b) {
        assert!(a.x > 80 * SUBPIXEL && a.y > 50 * SUBPIXEL, "{a:?} went to {b:?}");
    }
}

/// With a residual, squared error and squared flicker fall together.
#[test]
fn an_residual_lowers_flicker() {
    let size = Size::new(160, 120);
    let clean = picture(size, 4, 0, true);
    // Squares of 16 pixels that grow lighter and darker: edges that are gone in the next frame.
    let shaded = |t: u32| {
        let pixel = |(x, y): (u32, u32)| {
            let [shade, ..] = rank(5, Purpose::Noise, x / 16 + 100 * (y / 16), t).to_le_bytes();
            let [r, g, b, _] = clean.at(x, y).map(|v| v.saturating_add(shade / 8));
            [r, g, b, 255]
        };
        let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
        Frame::new(size, places.map(pixel).collect()).expect("a small frame")
    };
    let frames: Vec<Frame> = (0..12).map(shaded).collect();
    let changes = |coherence: f64| {
        let mut mesh = scattered(size, 200);
        let mut refiner = Refiner::default();
        refiner.still(&mut mesh, &frames[0], &RefineOptions::normal(), None);
        let mut painter = Painter::new(&Options::default());
        let mut residual = None;
        let mut flicker = 0.0;
        let mut last: Option<(Frame, &Frame)> = None;
        for frame in &frames {
            refiner.frame(&mut mesh, frame, &RefineOptions::live(), residual.take());
            assert_eq!(mesh.check(), Ok(()));
            let hints = PaintHints {
                residual: ResidualRequest::new(coherence, refiner.take_buffers()),
                ..PaintHints::default()
            };
            let painted =
                painter.paint(&mesh, frame, 1, hints, |reported| residual = reported).frame;
            if let Some((before, source)) = &last {
                let all = painted.pixels().iter().zip(before.pixels());
                let all = all.zip(frame.pixels().iter().zip(source.pixels())).flat_map(
                    |((o, p), (i, j))| {
                        (0..3).map(|c| {
                            let [o, p, i, j] = [o[c], p[c], i[c], j[c]].map(f64::from);
                            ((o - p) - (i - j)).powi(2)
                        })
                    },
                );
                flicker += all.sum::<f64>();
            }
            last = Some((painted, frame));
        }
        flicker
    };
    let (without, with) = (changes(0.0), changes(1.0));
    assert!(with < without, "{with} with an residual, {without} without");
}
