//! The maps of level one and the metrics against the field's references, whose figures are stored in
//! `tests/reference` with their origin.

use polyreel::feature::bilateral::Bilateral;
use polyreel::feature::canny::Canny;
use polyreel::feature::diffusion::Diffusion;
use polyreel::feature::edge_drawing::EdgeDrawing;
use polyreel::feature::edges::{laplacian, sobel};
use polyreel::feature::entropy::entropy;
use polyreel::feature::saliency::saliency;
use polyreel::frame::Frame;
use polyreel::geom::Size;
use polyreel::metric::mse::mse;
use polyreel::metric::ssim::{ssim, ssim_gaussian};
use polyreel::plane::Plane;

const PICTURES: [(&str, u32, u32); 4] =
    [("ramps", 32, 24), ("blocks", 61, 47), ("noise", 33, 40), ("disk", 61, 47)];

/// A larger one, for edges.
const SHAPES: (&str, u32, u32) = ("shapes", 200, 150);

/// The inputs, by the formulas of `tests/reference/make.py` and `make_edges.py`.
fn pixel(name: &str, x: i64, y: i64) -> u8 {
    let value = match name {
        "ramps" => x * 7 + y * 3 + ((x * y) >> 2),
        "blocks" => ((x >> 3) * 37) ^ ((y >> 3) * 91),
        "noise" => (((x * 374_761_393 + y * 668_265_263) & 0xffff_ffff) * 1_274_126_177) >> 20,
        "shapes" => {
            let grain = ((((x * 7919 + y * 104_729) & 0xff_ffff) * 613) >> 9) & 7;
            let tone = if (x - 60).pow(2) + (y - 70).pow(2) < 2025 {
                190 - (y >> 1)
            } else if x + 2 * y > 320 {
                30 + (x >> 5) * 23
            } else {
                70 + (x >> 1)
            };
            tone + grain
        }
        _ if (x - 30).pow(2) + (y - 22).pow(2) < 196 => 200 - y,
        _ => 40 + x + (x * y) % 7,
    };
    (value & 255) as u8
}

fn picture(name: &str, shift: i64) -> Plane<u8> {
    let mut all = PICTURES.iter().chain([&SHAPES]);
    let &(_, width, height) = all.find(|p| p.0 == name).expect("a known picture");
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (i64::from(x), i64::from(y))));
    let values = places.map(|(x, y)| pixel(name, x + shift, y)).collect();
    Plane::new(Size::new(width, height), values).expect("as many as pixels")
}

/// The same as a frame of greys, whose luma it is.
fn frame(name: &str, shift: i64) -> Frame {
    let plane = picture(name, shift);
    let pixels = plane.values().iter().map(|&v| [v, v, v, 255]).collect();
    Frame::new(plane.size(), pixels).expect("as many as pixels")
}

fn reference(file: &str) -> Vec<f32> {
    let path = format!("{}/tests/reference/{file}.txt", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).expect(&path);
    text.split_whitespace().map(|v| v.parse().expect(&path)).collect()
}

/// The largest difference between a map and the figures of `file`.
fn difference(map: &Plane<f32>, file: &str) -> f32 {
    let right = reference(file);
    assert_eq!(map.values().len(), right.len(), "{file}");
    map.values().iter().zip(&right).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn correlation(a: &[f32], b: &[f32]) -> f64 {
    let mean = |v: &[f32]| v.iter().map(|&v| f64::from(v)).sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (&a, &b) in a.iter().zip(b) {
        let (a, b) = (f64::from(a) - ma, f64::from(b) - mb);
        (ab, aa, bb) = (ab + a * b, aa + a * a, bb + b * b);
    }
    ab / (aa * bb).sqrt()
}

#[test]
fn entropy_is_that_of_scikit_image() {
    for (name, ..) in PICTURES {
        let map = entropy(&picture(name, 0), 5).expect("a radius in range");
        let off = difference(&map, &format!("entropy-{name}"));
        assert!(off < 1e-4, "{name}: {off} bits");
    }
    let map = entropy(&picture("blocks", 0), 9).expect("a radius in range");
    let off = difference(&map, "entropy-radius-9");
    assert!(off < 1e-4, "radius 9: {off} bits");
}

#[test]
fn diffusion_is_that_of_medpy() {
    let range = 255.0;
    for (name, ..) in PICTURES {
        let map = Diffusion::default().diffuse(&picture(name, 0)).expect("the defaults are sound");
        let off = difference(&map, &format!("diffusion-{name}"));
        assert!(off < 1e-5 * range, "{name}: {off} of 255");
    }
    let harsh = Diffusion { iterations: 25, kappa: 15.0, gamma: 0.25 };
    let map = harsh.diffuse(&picture("disk", 0)).expect("fields in range");
    let off = difference(&map, "diffusion-harsh");
    assert!(off < 1e-5 * range, "harsh: {off} of 255");
}

#[test]
fn saliency_is_that_of_opencv() {
    for (name, ..) in PICTURES {
        let map = saliency(&picture(name, 0));
        let like = correlation(map.values(), &reference(&format!("saliency-{name}")));
        assert!(like >= 0.995, "{name}: correlation {like}");
    }
}

#[test]
fn edge_strengths_are_those_of_scikit_image() {
    for (name, ..) in PICTURES {
        let luma = picture(name, 0);
        let off = difference(&sobel(&luma), &format!("sobel-{name}"));
        assert!(off < 1e-3, "sobel of {name}: {off}");
        let off = difference(&laplacian(&luma), &format!("laplacian-{name}"));
        assert!(off == 0.0, "laplacian of {name}: {off}");
    }
}

#[test]
fn canny_edges_are_those_of_scikit_image() {
    let canny = Canny { thresholds: Some((20.0, 60.0)), ..Canny::default() };
    for (name, ..) in PICTURES {
        let edges = canny.edges(&picture(name, 0)).expect("fields in range");
        let right = reference(&format!("canny-{name}"));
        let width = edges.size().width as usize;
        let at = |i: usize| edges.contains((i % width) as u32, (i / width) as u32);
        let wrong = (0..right.len()).filter(|&i| at(i) != (right[i] == 1.0)).count();
        let edges = right.iter().filter(|&&v| v == 1.0).count();
        // A step between two pixels gives both the same length: rounding decides which is the peak.
        assert!(edges > 20 && wrong * 20 <= edges, "{name}: {wrong} pixels differ of {edges}");
    }
}

/// Whether a pixel of the row `y` of a reference of edges is one.
fn edge_rows(file: &str) -> Vec<String> {
    let path = format!("{}/tests/reference/{file}.txt", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).expect(&path);
    let bits = |line: &str| {
        line.chars()
            .map(|digit| format!("{:04b}", digit.to_digit(16).expect("hexadecimal")))
            .collect::<String>()
    };
    text.lines().map(bits).collect()
}

#[test]
fn drawn_edges_are_those_of_opencv() {
    for name in ["blocks", "disk", "shapes"] {
        for (gradient_threshold, anchor_threshold) in [(36, 8), (20, 0)] {
            let detector =
                EdgeDrawing { gradient_threshold, anchor_threshold, ..EdgeDrawing::default() };
            let found = detector.draw(&picture(name, 0)).expect("fields in range").edges;
            let right = edge_rows(&format!("edge-drawing-{name}-{gradient_threshold}"));
            let size = found.size();
            let is_right = |x: u32, y: u32| right[y as usize].as_bytes()[x as usize] == b'1';
            let all = || (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
            let near = |(x, y): (u32, u32), is_edge: &dyn Fn(u32, u32) -> bool| {
                let rows = y.saturating_sub(1)..=(y + 1).min(size.height - 1);
                let columns = x.saturating_sub(1)..=(x + 1).min(size.width - 1);
                rows.into_iter().any(|y| columns.clone().any(|x| is_edge(x, y)))
            };
            let is_found = |x: u32, y: u32| found.contains(x, y);
            let share = |of: &dyn Fn(u32, u32) -> bool, among: &dyn Fn(u32, u32) -> bool| {
                let pixels: Vec<_> = all().filter(|&(x, y)| of(x, y)).collect();
                let hits = pixels.iter().filter(|&&at| near(at, among)).count();
                (hits as f64 / pixels.len() as f64, pixels.len())
            };
            let ((ours, count), (theirs, expected)) =
                (share(&is_found, &is_right), share(&is_right, &is_found));
            println!(
                "{name} {gradient_threshold}: {ours:.4} of {count}, {theirs:.4} of {expected}"
            );
            assert!(
                ours >= 0.95 && theirs >= 0.95,
                "{name}, {gradient_threshold}: {ours} of {count}, {theirs} of {expected}"
            );
        }
    }
}

#[test]
fn bilateral_filter_is_that_of_opencv() {
    for (name, sigma_colour) in [("blocks", 75.0), ("disk", 30.0)] {
        let grey = picture(name, 0);
        let pixels = grey.values().iter().map(|&v| [v, 255 - v, (v >> 1) + 60, 255]).collect();
        let frame = Frame::new(grey.size(), pixels).expect("as many as pixels");
        let filter = Bilateral { sigma_colour, ..Bilateral::default() };
        let smooth = filter.smooth(&frame).expect("fields in range");
        let values = smooth.pixels().iter().flat_map(|p| [p[0], p[1], p[2]].map(f32::from));
        let (values, right) = (values.collect::<Vec<_>>(), reference(&format!("bilateral-{name}")));
        let like = correlation(&values, &right);
        let off = values.iter().zip(&right).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(like >= 0.9999 && off <= 1.0, "{name}: correlation {like}, {off} of 255 off");
    }
}

#[test]
fn similarity_and_squared_error_are_those_of_scikit_image() {
    // structural_similarity(a, b, data_range=255), the same with gaussian_weights=True, sigma=1.5,
    // use_sample_covariance=False, and mean_squared_error(a, b); scikit-image 0.26.0.
    for (name, uniform, gaussian, squared) in [
        ("ramps", 0.811992471, 0.774643581, 1748.0),
        ("blocks", 0.790160257, 0.785115806, 920.589117544),
        ("noise", -0.420160078, -0.424384806, 15546.465909091),
        ("disk", 0.833496908, 0.802010023, 220.048133938),
    ] {
        let (a, b) = (frame(name, 0), frame(name, 1));
        let close = |found: f64, right: f64| (found - right).abs() < 1e-8;
        let found = ssim(&a, &b).expect("one size");
        assert!(close(found, uniform), "{name}: SSIM {found}, not {uniform}");
        let found = ssim_gaussian(&a, &b).expect("one size");
        assert!(close(found, gaussian), "{name}: Gaussian SSIM {found}, not {gaussian}");
        let found = mse(&a, &b).expect("one size");
        assert!(close(found, squared), "{name}: MSE {found}, not {squared}");
    }
}

#[test]
fn maps_are_the_same_on_any_number_of_threads() {
    let luma = picture("disk", 0);
    let maps = || {
        let diffused = Diffusion::default().diffuse(&luma).expect("the defaults are sound");
        let bits = entropy(&diffused.to_bytes(), 5).expect("a radius in range");
        let edges = Canny::default().edges(&luma).expect("the defaults are sound");
        (diffused, bits, saliency(&luma), edges)
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a small pool").install(maps)
    };
    assert!(with(1) == with(3));
}
