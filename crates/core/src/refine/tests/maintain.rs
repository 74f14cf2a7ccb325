//! Without steps, seeds are still removed and inserted.

use super::*;

const SIZE: Size = Size::new(240, 180);

fn plan() -> RefineOptions {
    RefineOptions { steps: 0, ..RefineOptions::live() }
}

#[test]
fn a_still_that_is_tended_stays_as_it_is() {
    let frame = picture(SIZE, 2, 40, true);
    let mut mesh = scattered(SIZE, 700);
    let before = mesh.clone();
    let mut refiner = Refiner::default();
    refiner.adopt(&mesh, &frame);
    for t in 0..70 {
        assert_eq!(refiner.maintain(&mut mesh, &frame, &plan()), Refined::default(), "frame {t}");
    }
    assert_eq!(mesh, before);
}

/// Opaque or not: of opaque frames only the rows of the strip are summed.
#[test]
fn a_picture_that_has_changed_is_mended_strip_by_strip() {
    for opaque in [true, false] {
        let (before, after) = (picture(SIZE, 2, 40, opaque), picture(SIZE, 5, 40, opaque));
        let mut mesh = scattered(SIZE, 700);
        let mut refiner = Refiner::default();
        refiner.adopt(&mesh, &before);
        let first = error_of(&mesh, &after);
        let (mut last, mut born) = (first, 0);
        for t in 0..70 {
            let vertices = mesh.vertices.len();
            let refined = refiner.maintain(&mut mesh, &after, &plan());
            assert_eq!((mesh.check(), mesh.vertices.len()), (Ok(()), vertices));
            let error = error_of(&mesh, &after);
            assert!(error <= last, "frame {t}: {error} after {last}");
            (last, born) = (error, born + refined.replaced.len());
        }
        assert!(last < 0.9 * first && born > 0, "opaque {opaque}: {first} {last} {born}");
    }
}

/// Strips and steps may follow each other in any order: what one has left alone the other measures.
#[test]
fn strips_and_steps_take_turns() {
    let mut mesh = scattered(SIZE, 700);
    let mut refiner = Refiner::default();
    refiner.still(&mut mesh, &picture(SIZE, 0, 40, true), &RefineOptions::normal(), None);
    let step = RefineOptions { steps: 1, ..RefineOptions::live() };
    for t in 1..40 {
        let frame = picture(SIZE, t / 3, 40, true);
        if t % 5 < 3 {
            refiner.maintain(&mut mesh, &frame, &plan());
        } else {
            let refined = refiner.frame(&mut mesh, &frame, &step, None);
            let (reported, found) = (refined.error_after, error_of(&mesh, &frame));
            assert!((reported - found).abs() <= 1e-6 * found, "frame {t}: {reported}, not {found}");
        }
        assert_eq!(mesh.check(), Ok(()), "frame {t}");
    }
}
