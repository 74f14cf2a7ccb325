//! Every step leaves a sound mesh and no larger error.

use proptest::prelude::*;

use super::*;
use crate::geom::orient;
use crate::mesh::Place;
use crate::options::{Edges, FacetSides};
use crate::rasterise::{self, rasterise};
use crate::refine::cost::Cost;
use crate::refine::mean::Mean;
use crate::refine::surface::{NONE, next};

/// The half-edges are consistent, and stored values equal new measurements.
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
        let (kept, anew) = (surface.cost[t as usize], Cost::of(rows, &sums, [a, b, c]));
        assert!((kept.error - anew.error).abs() <= 1e-9 * anew.error.abs(), "{kept:?} {anew:?}");
        assert!((kept.shape - anew.shape).abs() <= 1e-9 * anew.shape.abs(), "{kept:?} {anew:?}");
        let mean = Mean::of(&rows.total(&sums, orient(a, b, c), [a, b, c]));
        assert_eq!(surface.mean[t as usize], mean, "the mean of triangle {t} was not brought up");
    }
    for v in 0..surface.at.len() as u32 {
        let out = surface.out[v as usize];
        assert_eq!(surface.from(out), v);
        let on_border = surface.freedom(v) != Place::Interior;
        assert_eq!(surface.twin[out as usize] == NONE, on_border, "vertex {v} is entered wrongly");
        let fan = surface.around(v).count();
        assert_eq!(fan, surface.origin.iter().filter(|&&o| o == v).count());
    }
}

fn places(limit: usize) -> impl Strategy<Value = Vec<(f64, f64)>> {
    let anywhere = (0.0f64..=1.0, 0.0f64..=1.0);
    let border = (0.0f64..=1.0, prop_oneof![Just(0.0), Just(1.0)]);
    let clustered = (0.4f64..=0.45, 0.4f64..=0.45);
    let collinear = (0.0f64..=1.0, Just(0.5));
    let place = prop_oneof![4 => anywhere, 1 => border, 1 => clustered, 1 => collinear];
    proptest::collection::vec((place, any::<bool>()), 0..limit).prop_map(|all| {
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
        (steps, part) in prop_oneof![Just((1, 0)), (0u32..2, 1u32..8)],
    ) {
        let size = Size::new(width, height);
        let frame = picture(size, seed, noise, opaque);
        let mut mesh = mesh_of(size, &places, snap);
        let before = mesh.clone();
        let options = RefineOptions {
            steps,
            part,
            regularity,
            replace,
            threshold,
            mode: if opaque { Mode::Thorough } else { Mode::Stream },
            unrefined: Unrefined::Forget,
            planes: false,
            facets: FacetSides::FREE,
        };
        let mut refiner = Refiner::default();
        let mut error = f64::INFINITY;
        // What rounding makes of sums as large as that.
        let rounding = 1e-9 * frame.size().pixels() as f64 * 4.0 * 255.0 * 255.0;
        for step in 0..8 {
            let refined = if step < 4 {
                refiner.still(&mut mesh, &frame, &options, None)
            } else {
                refiner.frame(&mut mesh, &frame, &options, None)
            };
            prop_assert_eq!(mesh.check(), Ok(()));
            audit(&refiner.surface, &refiner.rows);
            let means = rasterise::means(&mesh, &frame);
            prop_assert_eq!(refined.fills.len(), if opaque { means.len() } else { 0 });
            for (known, mean) in refined.fills.iter().zip(means) {
                prop_assert!(known == &mean || (mean.area == 0 && known.area == 0));
            }
            prop_assert!(refined.error_after <= refined.error_before);
            let exact = error_of(&mesh, &frame);
            prop_assert!((refined.error_after - exact).abs() <= rounding, "{exact} {refined:?}");
            prop_assert!(refined.error_before <= error * (1.0 + 1e-9) + 1e-6, "{error} {refined:?}");
            error = refined.error_after;
            prop_assert_eq!(mesh.vertices.len(), before.vertices.len());
            prop_assert_eq!(mesh.triangles.len(), before.triangles.len());
            prop_assert_eq!(&mesh.vertices[..CORNERS], &before.vertices[..CORNERS]);
            let inside = |mesh: &Mesh| {
                let is_inside = |p: &&Point| Place::of(**p, size) == Place::Interior;
                mesh.vertices.iter().filter(is_inside).count()
            };
            prop_assert_eq!(inside(&mesh), inside(&before));
        }
    }

    /// As one run, in which vertices remember how far to step and whose turn it is to be re-placed.
    #[test]
    fn every_step_of_a_run_keeps_the_mesh_sound_and_never_raises_the_error(
        (width, height) in (1u32..48, 1u32..48),
        places in places(80),
        (seed, noise, opaque) in (0u64..1000, any::<u8>(), any::<bool>()),
        regularity in prop_oneof![Just(0.0), Just(REGULARITY), Just(1.0)],
        (replace, threshold) in (prop_oneof![Just(0.05), Just(0.5)], prop_oneof![Just(0.0), Just(0.001)]),
    ) {
        let frame = picture(Size::new(width, height), seed, noise, opaque);
        let mut mesh = mesh_of(frame.size(), &places, 1);
        let options = RefineOptions {
            steps: 20,
            regularity,
            replace,
            threshold,
            mode: if opaque { Mode::Thorough } else { Mode::Quick },
            ..RefineOptions::draft()
        };
        let mut seen = Vec::new();
        let mut watch = |mesh: &Mesh, error: f64| {
            seen.push((mesh.check(), error, error_of(mesh, &frame)));
            true
        };
        let refined = Refiner::default().still(&mut mesh, &frame, &options, Some(&mut watch));
        seen.push((mesh.check(), refined.error_after, error_of(&mesh, &frame)));
        prop_assert_eq!(seen.len() as u32, refined.steps + 1);
        // What rounding makes of sums as large as that.
        let rounding = 1e-9 * frame.size().pixels() as f64 * 4.0 * 255.0 * 255.0;
        for (step, (check, error, exact)) in seen.iter().enumerate() {
            prop_assert_eq!(check, &Ok(()), "step {}", step);
            prop_assert!((error - exact).abs() <= rounding, "step {step}: {error} {exact}");
            prop_assert!(step == 0 || *exact <= seen[step - 1].2 + rounding, "step {step}: {exact}");
        }
    }
}

#[test]
fn the_error_is_that_of_the_painted_picture() {
    for opaque in [true, false] {
        // No triangle of it is painted clear for being hardly seen.
        let frame = picture(Size::new(90, 70), 2, 60, opaque);
        let mut mesh = scattered(frame.size(), 120);
        let refined = refine(&mut mesh, &frame, &RefineOptions::normal());
        let painted = rasterise(&mesh, &frame, Edges::Hard, None).frame;
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
