//! Insertion of vertices.

use super::*;

/// Infinite cost times a weight of zero is not a number: no hole could be closed.
#[test]
fn vertices_are_replaced_at_regularity_zero() {
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
        let options =
            RefineOptions { steps: 3, replace: 1.0, threshold: 0.0, ..RefineOptions::draft() };
        refine(&mut mesh, &frame, &options);
        assert_eq!(mesh.check(), Ok(()));
    }
}
