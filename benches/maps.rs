//! The maps of level one and the metrics at 2.8 megapixels (the paper's largest picture).

mod disks;

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use disks::disks;
use polyreel::feature::canny::Canny;
use polyreel::feature::diffusion::Diffusion;
use polyreel::feature::edges::{laplacian, sobel};
use polyreel::feature::entropy::entropy;
use polyreel::feature::saliency::saliency;
use polyreel::feature::slic::{Slic, corners};
use polyreel::flow::flow;
use polyreel::geom::Size;
use polyreel::metric::mse::mse;
use polyreel::metric::ssim::{ssim, ssim_gaussian};
use polyreel::plane::Plane;

fn maps(c: &mut Criterion) {
    let mut group = c.benchmark_group("maps 2.8 MP");
    group.sample_size(10);
    let frame = disks(Size::new(2048, 1367), 256, 0);
    let luma = Plane::luma(&frame);
    group.bench_function("luma", |b| b.iter(|| Plane::luma(black_box(&frame))));
    group.bench_function("saliency", |b| b.iter(|| saliency(black_box(&luma))));
    group.bench_function("entropy", |b| b.iter(|| entropy(black_box(&luma), 5)));
    group.bench_function("diffusion", |b| {
        b.iter(|| Diffusion::default().diffuse(black_box(&luma)));
    });
    group.bench_function("sobel", |b| b.iter(|| sobel(black_box(&luma))));
    group.bench_function("laplacian", |b| b.iter(|| laplacian(black_box(&luma))));
    group.bench_function("canny", |b| b.iter(|| Canny::default().edges(black_box(&luma))));
    group.bench_function("slic", |b| {
        b.iter(|| Slic::new(11_000).segment(black_box(&frame)).map(|labels| corners(&labels)));
    });
    group.finish();
}

fn metrics(c: &mut Criterion) {
    let mut group = c.benchmark_group("metrics 1 MP");
    group.sample_size(10);
    let size = Size::new(1024, 1024);
    let (a, b) = (disks(size, 256, 0), disks(size, 256, 3));
    group.bench_function("ssim", |t| t.iter(|| ssim(black_box(&a), black_box(&b))));
    group.bench_function("ssim gaussian", |t| {
        t.iter(|| ssim_gaussian(black_box(&a), black_box(&b)));
    });
    group.bench_function("mse", |t| t.iter(|| mse(black_box(&a), black_box(&b))));
    let (a, b) = (Plane::luma(&a), Plane::luma(&b));
    group.bench_function("flow", |t| t.iter(|| flow(black_box(&a), black_box(&b))));
    group.finish();
}

criterion_group!(benches, maps, metrics);
criterion_main!(benches);
