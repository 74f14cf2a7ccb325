//! The maps of level one and the metrics at 2.8 megapixels (the paper's largest picture).

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use polyreel::chance::{Purpose, rank};
use polyreel::feature::canny::Canny;
use polyreel::feature::diffusion::Diffusion;
use polyreel::feature::edges::{laplacian, sobel};
use polyreel::feature::entropy::entropy;
use polyreel::feature::saliency::saliency;
use polyreel::feature::slic::{Slic, corners};
use polyreel::flow::flow;
use polyreel::frame::Frame;
use polyreel::geom::Size;
use polyreel::metric::mse::mse;
use polyreel::metric::ssim::{ssim, ssim_gaussian};
use polyreel::plane::Plane;

/// Disks of colour on a gradient, with a little noise, as a photograph has it.
fn picture(size: Size, shift: u32) -> Frame {
    let pixel = |i: u32| {
        let (x, y) = (i % size.width + shift, i / size.width);
        let (u, v) = (x % 256, y % 256);
        let disk = u.abs_diff(128).pow(2) + v.abs_diff(128).pow(2) < 90 * 90;
        let noise = (rank(1, Purpose::Noise, x, y) % 9) as u32;
        let tone = if disk { (x / 256 * 47 + y / 256 * 91) % 200 } else { (x + y) / 16 };
        [tone + noise, tone / 2 + 60, 200 - tone / 2 + noise, 255].map(|c| c.min(255) as u8)
    };
    let pixels = (0..size.pixels() as u32).map(pixel).collect();
    Frame::new(size, pixels).expect("as many as pixels")
}

fn maps(c: &mut Criterion) {
    let mut group = c.benchmark_group("maps 2.8 MP");
    group.sample_size(10);
    let frame = picture(Size::new(2048, 1367), 0);
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
    let (a, b) = (picture(size, 0), picture(size, 3));
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
