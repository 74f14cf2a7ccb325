//! Refinement of a 1 megapixel frame with 8,400 seeds: one step from nothing, one step of a video, and
//! to convergence; and what each [`Mode`] is for: its time, and the squared error that is left.

mod disks;

use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use disks::disks;
use polyreel::chance::{Purpose, rank};
use polyreel::geom::{Point, Size};
use polyreel::mesh::Mesh;
use polyreel::refine::{Mode, RefineOptions, Refiner, refine};
use polyreel::triangulate::triangulate;

const SIZE: Size = Size::new(1024, 1024);

/// Seeds on a jittered grid.
fn mesh() -> Mesh {
    let seed = |i: u32| {
        let bits = rank(2, Purpose::Keep, i, 0);
        let jitter = |bits: u64| (bits % 2600) as i32;
        let (x, y) = ((i % 92) as i32 * 2844, (i / 92) as i32 * 2844);
        Point::new(x + 1 + jitter(bits), y + 1 + jitter(bits >> 32))
    };
    let seeds: Vec<_> = (0..92 * 92).map(seed).filter(|p| SIZE.contains(*p)).collect();
    triangulate(SIZE, &seeds).expect("distinct seeds")
}

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("refine 1 MP");
    group.sample_size(10);
    let (frames, start) = ([disks(SIZE, 128, 0), disks(SIZE, 128, 1)], mesh());
    let one = RefineOptions { steps: 1, replace: 0.0, ..RefineOptions::normal() };
    let mut refiner = Refiner::default();
    group.bench_function("first step, in vain", |b| {
        let none = RefineOptions { threshold: 1e9, ..one };
        let run = |mut mesh| refiner.still(black_box(&mut mesh), &frames[0], &none, None);
        b.iter_batched(|| start.clone(), run, BatchSize::LargeInput);
    });
    group.bench_function("first step", |b| {
        let run = |mut mesh| refiner.still(black_box(&mut mesh), &frames[0], &one, None);
        b.iter_batched(|| start.clone(), run, BatchSize::LargeInput);
    });
    for (name, live) in [
        ("video, one step", RefineOptions { steps: 1, ..RefineOptions::live() }),
        ("video, three steps", RefineOptions::live()),
    ] {
        group.bench_function(name, |b| {
            let mut mesh = start.clone();
            refiner.still(&mut mesh, &frames[0], &RefineOptions::normal(), None);
            let mut turn = 0;
            b.iter(|| {
                turn = 1 - turn;
                refiner.frame(&mut mesh, &frames[turn], &live, None)
            });
        });
    }
    for (name, options) in [("normal", RefineOptions::normal()), ("best", RefineOptions::best())] {
        group.bench_function(name, |b| {
            let run = |mut mesh| refine(black_box(&mut mesh), &frames[0], &options);
            b.iter_batched(|| start.clone(), run, BatchSize::LargeInput);
        });
    }
    group.finish();
}

/// The modes with as many steps, on a still and on the second frame of a stream.
fn modes(c: &mut Criterion) {
    let mut group = c.benchmark_group("modes");
    group.sample_size(10);
    let (frames, start) = ([disks(SIZE, 128, 0), disks(SIZE, 128, 1)], mesh());
    let mut refiner = Refiner::default();
    for mode in [Mode::Quick, Mode::Thorough, Mode::Stream] {
        let still = RefineOptions { mode, steps: 10, ..RefineOptions::normal() };
        let left = refine(&mut start.clone(), &frames[0], &still).error_after;
        group.bench_function(format!("still, {mode:?}, squared error {left:.4e}"), |b| {
            let run = |mut mesh| refiner.still(black_box(&mut mesh), &frames[0], &still, None);
            b.iter_batched(|| start.clone(), run, BatchSize::LargeInput);
        });
        let next = RefineOptions { mode, ..RefineOptions::live() };
        let second = |refiner: &mut Refiner| {
            let mut mesh = start.clone();
            refiner.still(&mut mesh, &frames[0], &RefineOptions::normal(), None);
            refiner.frame(&mut mesh, &frames[1], &next, None).error_after
        };
        let left = second(&mut refiner);
        let mut mesh = start.clone();
        refiner.still(&mut mesh, &frames[0], &RefineOptions::normal(), None);
        let mut turn = 0;
        group.bench_function(format!("stream, {mode:?}, squared error {left:.4e}"), |b| {
            b.iter(|| {
                turn = 1 - turn;
                refiner.frame(&mut mesh, &frames[turn], &next, None)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, bench, modes);
criterion_main!(benches);
