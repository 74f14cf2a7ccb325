//! What holds of every refinement, whatever the picture and the seeds.

use proptest::prelude::*;

use super::ring::Ring;
use super::surface::{Cost, NONE, next};
use super::*;
use crate::chance::{Purpose, rank};
use crate::geom::{Point, SUBPIXEL, Size};
use crate::mesh::{CORNERS, Place};
use crate::rasterise::rasterise;
use crate::triangulate::triangulate;

#[test]
fn a_refiner_takes_a_smaller_mesh_after_a_larger_one() {
    let size = Size::new(48, 40);
    let frame = picture(size, 3, 20, true);
    let mut refiner = Refiner::default();
    let options = RefineOptions::normal();
    for count in [60, 12, 90, 30] {
        let (mut again, mut alone) = (scattered(size, count), scattered(size, count));
        let refined = refiner.refine(&mut again, &frame, &options);
        assert_eq!(refined, refine(&mut alone, &frame, &options));
        assert_eq!(again, alone, "what came before leaves no trace");
    }
}

/// A picture with flat areas, slanted edges, a disk, a ramp and some noise; `noise` 0..=255.
pub(super) fn picture(size: Size, seed: u64, noise: u8, opaque: bool) -> Frame {
    let pixel = |x: u32, y: u32| {
        let [n, a, ..] = rank(seed, Purpose::Noise, x, y).to_le_bytes();
        let (fx, fy) = (f64::from(x), f64::from(y));
        let turn = seed as f64 * 0.7;
        let side = (fx - 14.0) * turn.cos() + (fy - 11.0) * turn.sin();
        let disk = (fx - 20.0).hypot(fy - 18.0) < 9.0;
        let base = if disk {
            210.0
        } else if side > 0.0 {
            40.0 + fx
        } else {
            120.0
        };
        let value = base + f64::from(n) * f64::from(noise) / 255.0;
        let value = value.clamp(0.0, 255.0) as u8;
        let alpha = if opaque {
            255
        } else if disk {
            a
        } else {
            0
        };
        [value, value / 2 + (y % 64) as u8, 255 - value, alpha]
    };
    let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| pixel(x, y)));
    Frame::new(size, pixels.collect()).expect("a small frame")
}

fn mesh_of(size: Size, places: &[(f64, f64)], snap: i32) -> Mesh {
    let far = size.far();
    let on_grid = |share: f64, far: i32| (share * f64::from(far)) as i32 / snap * snap;
    let mut seeds: Vec<_> = places
        .iter()
        .map(|&(x, y)| Point::new(on_grid(x, far.x), on_grid(y, far.y)))
        .filter(|p| !Mesh::corners(size).contains(p))
        .collect();
    seeds.sort_unstable();
    seeds.dedup();
    triangulate(size, &seeds).expect("distinct seeds")
}

fn scattered(size: Size, count: u32) -> Mesh {
    let place = |i| {
        let bits = rank(9, Purpose::Keep, i, 0);
        ((bits >> 32) as f64 / 4_294_967_296.0, (bits & 0xffff_ffff) as f64 / 4_294_967_296.0)
    };
    mesh_of(size, &(0..count).map(place).collect::<Vec<_>>(), SUBPIXEL / 2)
}

/// The half-edges fit together, and what is kept beside them is what measuring anew would find.
fn audit(surface: &Surface, rows: &RowSums) {
    for h in 0..surface.origin.len() as u32 {
        let twin = surface.twin[h as usize];
        assert_eq!(surface.sums[h as usize], rows.edge(surface.place(h), surface.place(next(h))));
        if twin != NONE {
            assert_eq!(surface.twin[twin as usize], h, "twins disagree");
            assert_eq!(surface.from(twin), surface.to(h), "twins do not face each other");
        }
    }
    for t in 0..surface.triangles() as u32 {
        let [a, b, c] = surface.corners(t);
        let h = 3 * t as usize;
        let sums = surface.sums[h] + surface.sums[h + 1] + surface.sums[h + 2];
        let (kept, anew) = (surface.cost[t as usize], Cost::of(rows, &sums, a, b, c));
        assert!((kept.error - anew.error).abs() <= 1e-9 * anew.error.abs(), "{kept:?} {anew:?}");
        assert!((kept.shape - anew.shape).abs() <= 1e-9 * anew.shape.abs(), "{kept:?} {anew:?}");
    }
    for v in 0..surface.at.len() as u32 {
        let out = surface.out[v as usize];
        assert_eq!(surface.from(out), v);
        let on_border = surface.freedom(v) != Place::Interior;
        assert_eq!(surface.twin[out as usize] == NONE, on_border, "vertex {v} is entered wrongly");
        let mut fan = 0;
        surface.around(v, |_| fan += 1);
        assert_eq!(fan, surface.origin.iter().filter(|&&o| o == v).count());
    }
}

fn places(most: usize) -> impl Strategy<Value = Vec<(f64, f64)>> {
    let anywhere = (0.0f64..=1.0, 0.0f64..=1.0);
    let border = (0.0f64..=1.0, prop_oneof![Just(0.0), Just(1.0)]);
    let clustered = (0.4f64..=0.45, 0.4f64..=0.45);
    let collinear = (0.0f64..=1.0, Just(0.5));
    let place = prop_oneof![4 => anywhere, 1 => border, 1 => clustered, 1 => collinear];
    proptest::collection::vec((place, any::<bool>()), 0..most).prop_map(|all| {
        all.into_iter().map(|((x, y), turn)| if turn { (y, x) } else { (x, y) }).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(160))]

    #[test]
    fn every_step_keeps_the_mesh_sound_and_never_raises_the_error(
        (width, height) in prop_oneof![3 => (1u32..40, 1u32..40), 1 => (1u32..4, 1u32..40)],
        places in places(60),
        snap in prop_oneof![Just(1), Just(SUBPIXEL / 2), Just(SUBPIXEL)],
        (seed, noise, opaque) in (0u64..1000, any::<u8>(), any::<bool>()),
        regularity in prop_oneof![Just(0.0), Just(REGULARITY), Just(1.0), 0.0f64..=1.0],
        (replace, threshold) in (prop_oneof![Just(0.0), Just(0.05), Just(1.0)], prop_oneof![Just(0.0), Just(0.01)]),
    ) {
        let size = Size::new(width, height);
        let frame = picture(size, seed, noise, opaque);
        let mut mesh = mesh_of(size, &places, snap);
        let before = mesh.clone();
        let options = RefineOptions { steps: 1, regularity, replace, threshold };
        let mut refiner = Refiner::default();
        let mut error = f64::INFINITY;
        for step in 0..8 {
            let refined = if step < 4 {
                refiner.refine(&mut mesh, &frame, &options)
            } else {
                refiner.resume(&mut mesh, &frame, &options)
            };
            prop_assert_eq!(mesh.check(), Ok(()));
            audit(&refiner.surface, &refiner.rows);
            prop_assert!(refined.error_after <= refined.error_before);
            prop_assert!(refined.error_before <= error * (1.0 + 1e-9) + 1e-6, "{error} {refined:?}");
            error = refined.error_after;
            prop_assert_eq!(mesh.vertices.len(), before.vertices.len());
            prop_assert_eq!(mesh.triangles.len(), before.triangles.len());
            for (v, (&p, &old)) in mesh.vertices.iter().zip(&before.vertices).enumerate() {
                let place = Place::of(old, size);
                prop_assert_eq!(Place::of(p, size), place, "vertex {} left its place", v);
                match place {
                    Place::Corner => prop_assert_eq!(p, old),
                    Place::SideBorder => prop_assert_eq!(p.x, old.x),
                    Place::LevelBorder => prop_assert_eq!(p.y, old.y),
                    Place::Interior => {}
                }
            }
        }
    }
}

/// The force on a vertex and the error's slope there, on a smooth wave, by `chance` of it.
fn force_and_slope(chance: u32) -> ([f64; 2], [f64; 2]) {
    let unit = |purpose| crate::chance::unit(1, purpose, chance, 0);
    let (angle, phase) = (6.0 * unit(Purpose::Interior), 6.0 * unit(Purpose::Keep));
    let wave = 40.0 + 30.0 * unit(Purpose::Trim);
    let size = Size::new(240, 240);
    let pixel = |x: u32, y: u32| {
        let along = f64::from(x) * angle.cos() + f64::from(y) * angle.sin();
        let value = (127.5 + 120.0 * (along / wave + phase).sin()).round() as u8;
        [value, 255 - value, value / 2, 255]
    };
    let pixels = (0..240).flat_map(|y| (0..240).map(move |x| pixel(x, y))).collect();
    let frame = Frame::new(size, pixels).expect("a small frame");
    let mut seeds = vec![Point::from_pixels(
        100.0 + 40.0 * unit(Purpose::Phase),
        100.0 + 40.0 * unit(Purpose::Noise),
    )];
    seeds.extend((0..7).map(|i| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 7.0).sin_cos();
        Point::from_pixels(120.0 + 72.0 * cos, 120.0 + 72.0 * sin)
    }));
    let mesh = triangulate(size, &seeds).expect("distinct seeds");
    let mut refiner = Refiner::default();
    refiner.rows.load(&frame);
    refiner.surface.link(&mesh);
    refiner.surface.measure(&refiner.rows);
    let mut ring = Ring::default();
    ring.surround(&refiner.surface, CORNERS as u32);
    ring.sum_up(&refiner.surface);
    let mean = |i: usize| refiner.surface.mean[ring.links[i] as usize / 3].known();
    let (gx, gy) = super::force::gradient(&refiner.rows, seeds[0], &ring, mean);
    // Central differences over eight pixels even out that pixels change hands whole.
    let mut slope = |dx: i32, dy: i32| {
        let mut error = |way: i32| {
            let p = Point::new(seeds[0].x + dx * way, seeds[0].y + dy * way);
            ring.try_at(&refiner.rows, p).expect("a small way").error
        };
        (error(4 * SUBPIXEL) - error(-4 * SUBPIXEL)) / 8.0
    };
    ([gx, gy], [slope(1, 0), slope(0, 1)])
}

/// On pictures smooth enough to have one.
#[test]
fn the_force_is_the_gradient_of_the_error() {
    let (mut off, mut all) = (0.0, 0.0);
    for chance in 0..40 {
        let (force, slope) = force_and_slope(chance);
        for (f, s) in force.into_iter().zip(slope) {
            off += (f - s) * (f - s);
            all += s * s;
        }
    }
    let share = f64::sqrt(off / all);
    assert!(share < 0.05, "the force is off by {share} of the slope");
}

#[test]
fn the_error_is_that_of_the_painted_picture() {
    for opaque in [true, false] {
        let frame = picture(Size::new(90, 70), 3, 60, opaque);
        let mut mesh = scattered(frame.size(), 80);
        let refined = refine(&mut mesh, &frame, &RefineOptions::normal());
        let painted = rasterise(&mesh, &frame, None).frame;
        let premultiplied = |[r, g, b, a]: [u8; 4]| {
            let part = |v: u8| f64::from(v) * f64::from(a) / 255.0;
            let alpha = if opaque { 0.0 } else { f64::from(a) };
            [part(r), part(g), part(b), alpha]
        };
        let pairs = frame.pixels().iter().zip(painted.pixels());
        let error: f64 = pairs
            .flat_map(|(&a, &b)| premultiplied(a).into_iter().zip(premultiplied(b)))
            .map(|(a, b)| (a - b) * (a - b))
            .sum();
        // Painted colours are rounded to 8 bits: at most 1/2 off, twice when premultiplied.
        let rounding = frame.size().pixels() as f64 * 4.0;
        assert!((error - refined.error_after).abs() < rounding, "{error} {refined:?}");
        assert!(refined.error_after < 0.7 * refined.error_before, "{refined:?}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_mesh() {
    let frame = picture(Size::new(160, 120), 5, 80, true);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let mut mesh = scattered(frame.size(), 900);
        let options = RefineOptions { steps: 12, ..RefineOptions::best() };
        let refined = pool.install(|| refine(&mut mesh, &frame, &options));
        (mesh, refined)
    };
    let one = run(1);
    assert!(one.1.moved > 100 && one.1.flipped > 100 && !one.1.replaced.is_empty(), "{:?}", one.1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(8));
}

#[test]
fn a_still_settles_and_then_stays() {
    let frame = picture(Size::new(120, 90), 2, 40, true);
    let mut mesh = scattered(frame.size(), 300);
    let best = RefineOptions { steps: 500, ..RefineOptions::best() };
    let mut refiner = Refiner::default();
    let refined = refiner.refine(&mut mesh, &frame, &best);
    assert!(refined.steps < 200, "still busy after {} steps", refined.steps);
    let settled = mesh.clone();
    let again = refiner.resume(&mut mesh, &frame, &best);
    assert!(again.steps < 5, "{again:?}");
    assert_eq!((again.moved, again.flipped), (0, 0));
    assert!(mesh == settled && again.replaced.is_empty());
}

#[test]
fn a_still_video_stands_still_before_its_tenth_frame() {
    let frame = picture(Size::new(120, 90), 2, 40, true);
    let mut mesh = scattered(frame.size(), 300);
    let mut refiner = Refiner::default();
    refiner.refine(&mut mesh, &frame, &RefineOptions::normal());
    let live = RefineOptions { threshold: 0.0, replace: 0.02, ..RefineOptions::live() };
    let mut last = mesh.clone();
    for t in 1..30 {
        let refined = refiner.resume(&mut mesh, &frame, &live);
        assert_eq!(mesh.check(), Ok(()));
        if t == 1 {
            assert!(refined.moved > 0, "nothing is left to do: this proves nothing");
        }
        assert!(t < 9 || mesh == last, "frame {t} differs: {refined:?}");
        last.clone_from(&mesh);
    }
}

/// Noise of sigma 2 neither wakes a settled mesh nor moves it.
#[test]
fn noise_moves_nothing() {
    let size = Size::new(160, 120);
    let clean = picture(size, 4, 0, true);
    let noisy = |t: u32| {
        let mut at = 0;
        let noise = |v: u8| {
            at += 1;
            let bytes = rank(77, Purpose::Noise, at, t).to_le_bytes();
            // Four uniform bytes: sigma 148; over 74 it is 2.
            let sum: i32 = bytes[..4].iter().map(|&b| i32::from(b) * 2 - 255).sum();
            (i32::from(v) + (f64::from(sum) / 148.0).round() as i32).clamp(0, 255) as u8
        };
        let pixels: Vec<_> = clean.pixels().iter().flatten().copied().map(noise).collect();
        let (pixels, _) = pixels.as_chunks::<4>();
        let opaque = pixels.iter().map(|&[r, g, b, _]| [r, g, b, 255]).collect();
        Frame::new(size, opaque).expect("a small frame")
    };
    let mut mesh = scattered(size, 160);
    let mut refiner = Refiner::default();
    refiner.refine(&mut mesh, &noisy(0), &RefineOptions::normal());
    let mut moved = 0;
    for t in 1..30 {
        let refined = refiner.resume(&mut mesh, &noisy(t), &RefineOptions::live());
        if t >= 10 {
            moved += refined.moved + refined.flipped + refined.replaced.len();
        }
    }
    assert_eq!(moved, 0);
}

/// A frozen part wakes when the picture changes there, and only there.
#[test]
fn a_change_wakes_its_surroundings() {
    let size = Size::new(160, 120);
    let frame = picture(size, 4, 0, true);
    let mut mesh = scattered(size, 160);
    let mut refiner = Refiner::default();
    refiner.refine(&mut mesh, &frame, &RefineOptions::normal());
    for _ in 0..12 {
        refiner.resume(&mut mesh, &frame, &RefineOptions::live());
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
    let refined = refiner.resume(&mut mesh, &changed, &live);
    assert!(refined.moved > 0);
    for (a, b) in before.vertices.iter().zip(&mesh.vertices).filter(|(a, b)| a != b) {
        assert!(a.x > 80 * SUBPIXEL && a.y > 50 * SUBPIXEL, "{a:?} went to {b:?}");
    }
}

/// Infinite cost times a weight of nought is not a number: no hole could be closed.
#[test]
fn vertices_are_replaced_at_regularity_nought() {
    let frame = picture(Size::new(120, 90), 2, 0, true);
    let mut mesh = scattered(frame.size(), 200);
    let options = RefineOptions { regularity: 0.0, ..RefineOptions::normal() };
    assert!(!refine(&mut mesh, &frame, &options).replaced.is_empty());
}

/// A needle gains more in shape than any other opening does in all. It used to end the pass for all.
#[test]
fn needles_do_not_keep_vertices_from_being_replaced() {
    let size = Size::new(120, 90);
    let frame = picture(size, 2, 0, true);
    let mut seeds: Vec<_> = scattered(size, 200).seeds().to_vec();
    seeds.extend([Point::new(256 * 60, 1), Point::new(256 * 61, 1)]);
    let mut mesh = triangulate(size, &seeds).expect("distinct seeds");
    let options = RefineOptions { steps: 1, ..RefineOptions::normal() };
    assert!(!refine(&mut mesh, &frame, &options).replaced.is_empty());
}

/// A pass that re-places many vertices renumbers the half-edges of openings that it comes to later: one
/// was looked at that had become a border edge.
#[test]
fn openings_that_are_gone_are_passed_over() {
    for seed in 0..40 {
        let frame = picture(Size::new(28, 14), seed, 255, false);
        let mut mesh = scattered(frame.size(), 40);
        let options = RefineOptions { steps: 3, replace: 1.0, threshold: 0.0, regularity: 0.5 };
        refine(&mut mesh, &frame, &options);
        assert_eq!(mesh.check(), Ok(()));
    }
}

#[test]
fn few_large_triangles_are_summed_exactly() {
    // Triangles of some 40000 pixels, whose sums do not fit the packed fields.
    let frame = picture(Size::new(400, 300), 1, 200, true);
    let mut mesh = scattered(frame.size(), 2);
    let refined = refine(&mut mesh, &frame, &RefineOptions::best());
    assert_eq!(mesh.check(), Ok(()));
    assert!(refined.error_after < refined.error_before);
}

#[test]
fn draft_does_nothing() {
    let frame = picture(Size::new(40, 40), 1, 0, true);
    let mut mesh = scattered(frame.size(), 30);
    let before = mesh.clone();
    assert_eq!(refine(&mut mesh, &frame, &RefineOptions::draft()), Refined::default());
    assert_eq!(mesh, before);
    assert!(mesh.vertices.len() > CORNERS);
}
