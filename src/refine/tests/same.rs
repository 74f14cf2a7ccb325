//! The same mesh on any number of threads, and whatever the refiner did before.

use super::*;

/// The mesh and its error before every step and after the last, and what was done.
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
    let refined = refiner.refine_while(&mut mesh, frame, options, &mut watch);
    course.push((mesh, refined.error_after));
    (course, refined)
}

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
            refiner.resume(&mut mesh, &frame, &RefineOptions::live(), None);
        }
    }
    assert!(turn < 30, "nothing was re-placed in {turn} runs of 60");
}
