//! The same mesh on any number of threads, and whatever the refiner did before.

use super::*;

/// The mesh and its error before every step and after the last, and the result.
fn course(
    refiner: &mut Refiner,
    mut mesh: Mesh,
    frame: &Frame,
    options: &RefineOptions,
) -> (Vec<(Mesh, f64)>, Refined) {
    let mut course = Vec::new();
    let mut watch = |mesh: &Mesh, error: f64| {
        course.push((mesh.clone(), error));
        true
    };
    let refined = refiner.still(&mut mesh, frame, options, Some(&mut watch));
    course.push((mesh, refined.error_after));
    (course, refined)
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_gives_the_same_mesh_after_every_step() {
    for opaque in [true, false] {
        let frame = picture(Size::new(160, 120), 5, 80, opaque);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let options = RefineOptions { steps: 12, ..RefineOptions::best() };
            let mesh = scattered(frame.size(), 900);
            pool.expect("a pool")
                .install(|| course(&mut Refiner::default(), mesh, &frame, &options))
        };
        let (steps, refined) = run(1);
        assert!(
            refined.moved > 100 && refined.flipped > 100 && !refined.replaced.is_empty(),
            "{refined:?}"
        );
        for threads in [2, 8] {
            let (others, other) = run(threads);
            assert_eq!(other, refined, "{threads} threads");
            let same = steps.iter().zip(&others).position(|(a, b)| a != b);
            assert_eq!((same, steps.len()), (None, others.len()), "{threads} threads");
        }
    }
}

/// Which vertices may be re-placed goes by turns, and the turn of the mesh before used to be carried
/// on: `best`, which ends after any number of steps, gave another mesh then.
#[test]
fn a_refiner_takes_a_smaller_mesh_after_a_larger_one() {
    let mut refiner = Refiner::default();
    let mut turn = 0;
    for options in [RefineOptions::normal(), RefineOptions::best()] {
        let counts = [60, 12, 90, 30, 200, 1, 150, 40, 300, 80];
        let sizes = [(48, 40), (48, 40), (31, 77), (90, 20), (120, 90), (5, 4), (64, 64)];
        for (i, count) in counts.into_iter().cycle().take(30).enumerate() {
            let (width, height) = sizes[i % sizes.len()];
            let (size, seed) = (Size::new(width, height), i as u64);
            let frame = picture(size, seed, 20, i % 3 != 1);
            // Odd numbers of steps end between the turns.
            let options = RefineOptions { steps: options.steps - i as u32 % 4, ..options };
            let mut mesh = scattered(size, count);
            let again = course(&mut refiner, mesh.clone(), &frame, &options);
            let alone = course(&mut Refiner::default(), mesh.clone(), &frame, &options);
            assert!(again == alone, "run {i}: what came before leaves a trace");
            turn += usize::from(again.1.replaced.is_empty());
            // A frame of a video in between.
            refine(&mut mesh, &frame, &options);
            refiner.frame(&mut mesh, &frame, &RefineOptions::live(), None);
        }
    }
    assert!(turn < 30, "nothing was re-placed in {turn} runs of 60");
}

/// Numbers are names: the mesh, its links, its error and what is remembered of each triangle stay the same.
#[test]
fn new_numbers_change_nothing_but_the_order() {
    for opaque in [true, false] {
        let frame = picture(Size::new(240, 180), 3, 60, opaque);
        let mut mesh = scattered(frame.size(), 1500);
        let mut refiner = Refiner::default();
        let options = RefineOptions { replace: 0.3, ..RefineOptions::normal() };
        let refined = refiner.still(&mut mesh, &frame, &options, None);
        assert!(refined.replaced.len() > 80, "{}", refined.replaced.len());
        let Refiner { surface, rows, stepper, .. } = &mut refiner;
        let known = |surface: &Surface, stepper: &Stepper| {
            let triangles = (0..surface.triangles() as u32).map(|t| {
                let colour = stepper.activity.colour_of(t).map(f32::to_bits);
                (Mesh::smallest_first([0, 1, 2].map(|i| surface.from(3 * t + i))), colour)
            });
            let mut known: Vec<_> = triangles.collect();
            known.sort_unstable();
            known
        };
        // How far the triangles lie apart that have one number after the other.
        let way = |surface: &Surface| {
            let firsts: Vec<_> =
                (0..surface.triangles() as u32).map(|t| surface.place(3 * t)).collect();
            let apart = |p: &[Point]| f64::from(p[0].x - p[1].x).hypot(f64::from(p[0].y - p[1].y));
            firsts.windows(2).map(apart).sum::<f64>()
        };
        let (before, error, far) = (known(surface, stepper), surface.error(rows), way(surface));
        let fills = surface.stored_fills(rows);
        stepper.activity.renumber(surface.renumber());
        surface.measure(rows);
        assert_eq!(known(surface, stepper), before);
        assert!((surface.error(rows) / error - 1.0).abs() < 1e-9);
        assert!(way(surface) < 0.95 * far, "{} of {far}", way(surface));
        assert_eq!(surface.stored_fills(rows), fills);
        for h in 0..surface.origin.len() as u32 {
            let twin = surface.twin[h as usize];
            if let Some(&back) = surface.twin.get(twin as usize) {
                assert_eq!((back, surface.from(twin)), (h, surface.to(h)));
            }
        }
        for v in 0..surface.at.len() as u32 {
            assert_eq!(surface.from(surface.out[v as usize]), v);
        }
        let mut again = mesh.clone();
        surface.store(&mut again);
        assert_eq!(again, mesh);
    }
}
