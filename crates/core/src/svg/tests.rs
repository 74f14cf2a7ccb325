use super::*;
use crate::chance::{Purpose, rank};
use crate::frame::Frame;
use crate::geom::{Point, Size};
use crate::options::Edges;
use crate::rasterise::{means, rasterise};
use crate::triangulate::triangulate;

const SIZE: Size = Size::new(160, 120);

/// A mesh over a coloured picture, its triangles some `side` pixels wide.
fn sample(seeds: u32, alpha: impl Fn(u32, u32) -> u8) -> (Mesh, Frame) {
    let pixel = |i: u32| {
        let (x, y) = (i % SIZE.width, i / SIZE.width);
        [(x * 3 / 2) as u8, (y * 2) as u8, ((x / 16 + y / 16) % 2 * 200) as u8, alpha(x, y)]
    };
    let frame =
        Frame::new(SIZE, (0..SIZE.pixels() as u32).map(pixel).collect()).expect("a picture");
    let far = SIZE.far();
    let mut points: Vec<_> = (0..seeds)
        .map(|i| {
            let bits = rank(7, Purpose::Noise, i, 1);
            let (x, y) = (bits as u32 as i32, (bits >> 32) as i32);
            let mut p = Point::new(x.rem_euclid(far.x + 1), y.rem_euclid(far.y + 1));
            if i % 9 == 0 {
                p.x = if i % 2 == 0 { 0 } else { far.x };
            }
            p
        })
        .filter(|p| !Mesh::corners(SIZE).contains(p))
        .collect();
    points.sort_unstable();
    points.dedup();
    (triangulate(SIZE, &points).expect("distinct"), frame)
}

fn opaque(_: u32, _: u32) -> u8 {
    255
}

fn colours(mesh: &Mesh, frame: &Frame) -> Vec<Rgba> {
    means(mesh, frame).iter().map(|fill| fill.colour).collect()
}

/// The document drawn at `zoom` on `ground`.
fn drawn(svg: &str, zoom: f32, ground: Rgba) -> (u32, Vec<Rgba>) {
    let tree = resvg::usvg::Tree::from_str(svg, &resvg::usvg::Options::default()).expect("an SVG");
    let [w, h] = [SIZE.width, SIZE.height].map(|side| (side as f32 * zoom).ceil() as u32);
    let mut pixmap = resvg::tiny_skia::Pixmap::new(w, h).expect("a size");
    let [r, g, b, a] = ground;
    pixmap.fill(resvg::tiny_skia::Color::from_rgba8(r, g, b, a));
    let scale = resvg::tiny_skia::Transform::from_scale(zoom, zoom);
    resvg::render(&tree, scale, &mut pixmap.as_mut());
    let pixels = pixmap.pixels().iter().map(|p| {
        let p = p.demultiply();
        [p.red(), p.green(), p.blue(), p.alpha()]
    });
    (w, pixels.collect())
}

const MAGENTA: Rgba = [255, 0, 255, 255];

#[test]
fn no_ground_shows_at_any_size() {
    for seeds in [12, 150, 1200] {
        let (mesh, frame) = sample(seeds, opaque);
        let svg = to_svg(&mesh, &colours(&mesh, &frame), &SvgOptions::default());
        for zoom in [1.0, 1.7, 4.0] {
            let on = |ground| drawn(&svg, zoom, ground).1;
            assert!(on(MAGENTA) == on([0, 255, 0, 255]), "{seeds} seeds at {zoom}: ground shows");
            assert!(on([0; 4]).iter().all(|p| p[3] == 255), "{seeds} seeds at {zoom}: a gap");
        }
    }
}

/// How much of the ground shows through the facets themselves, in whole pixels, and how many pixels show any.
fn leak(seams: Seams, seeds: u32) -> (f64, usize) {
    let (mesh, frame) = sample(seeds, opaque);
    let colours = colours(&mesh, &frame);
    let mut svg = Document::begin(&mesh, "");
    svg.facets(&mesh, &colours, seams);
    let svg = svg.end();
    let without: String =
        svg.lines().filter(|line| !line.contains("\"m-")).map(|line| format!("{line}\n")).collect();
    let (_, pixels) = drawn(&without, 1.7, [0; 4]);
    // The last row and column reach beyond the picture.
    let inside = pixels.iter().enumerate().filter(|(i, _)| i % 272 < 271 && i / 272 < 203);
    let gaps: Vec<f64> =
        inside.map(|(_, p)| 1.0 - f64::from(p[3]) / 255.0).filter(|&gap| gap > 0.02).collect();
    (gaps.iter().sum(), gaps.len())
}

#[test]
fn facets_reach_under_each_other() {
    let (none, _) = leak(Seams::None, 150);
    let (some, pixels) = leak(Seams::Underlap, 150);
    assert!(none > 500.0, "triangles that only touch leave gaps: {none}");
    assert!(some < none / 200.0, "{some} of {none} in {pixels} pixels");
}

#[test]
fn edges_lie_where_the_rasteriser_has_them() {
    for seams in Seams::ALL {
        let (mesh, frame) = sample(150, opaque);
        let options = SvgOptions { seams, ..SvgOptions::default() };
        let svg = to_svg(&mesh, &colours(&mesh, &frame), &options);
        let hard = rasterise(&mesh, &frame, Edges::Hard, None).frame;
        let (_, pixels) = drawn(&svg, 1.0, MAGENTA);
        let squares = pixels.iter().zip(hard.pixels()).flat_map(|(a, b)| {
            (0..3).map(|c| (f64::from(a[c]) - f64::from(b[c])).powi(2)).collect::<Vec<_>>()
        });
        let error = squares.sum::<f64>() / (3.0 * pixels.len() as f64);
        let psnr = 10.0 * (255.0f64.powi(2) / error).log10();
        let least = if seams == Seams::Underlap { 26.0 } else { 20.0 };
        assert!(psnr > least, "{}: {psnr} dB", seams.name());
    }
}

/// Facets that are not opaque, scattered, so that at many vertices opaque ones lie in several patches.
#[test]
fn opaque_facets_between_others_have_no_seams() {
    let (mesh, frame) = sample(600, opaque);
    let mut colours = colours(&mesh, &frame);
    for (t, colour) in (0u32..).zip(&mut colours) {
        if rank(5, Purpose::Noise, t, 3).is_multiple_of(3) {
            colour[3] = 0;
        }
    }
    let svg = to_svg(&mesh, &colours, &SvgOptions::default());
    let zoom = 4;
    let (width, pixels) = drawn(&svg, zoom as f32, [0; 4]);
    // Pixels whose surroundings belong to opaque facets alone.
    let scale = |v: u32| i64::from(v) * i64::from(crate::geom::SUBPIXEL) / i64::from(zoom);
    let opaque_at = |x: u32, y: u32| {
        let p = Point::new(scale(x) as i32 + 32, scale(y) as i32 + 32);
        (0..colours.len()).any(|t| {
            let [a, b, c] = mesh.triangle(t);
            let inside = |from, to| crate::geom::orient(from, to, p) >= 0;
            colours[t][3] == 255 && inside(a, b) && inside(b, c) && inside(c, a)
        })
    };
    let faint: Vec<(u32, u32)> = (0u32..)
        .zip(&pixels)
        .filter(|(_, p)| (40..235).contains(&p[3]))
        .map(|(i, _)| (i % width, i / width))
        .filter(|&(x, y)| x > 1 && y > 1 && x < width - 2 && y < SIZE.height * zoom - 2)
        .filter(|&(x, y)| (0..25).all(|k| opaque_at(x + k % 5 - 2, y + k / 5 - 2)))
        .collect();
    // Slivers that are not seen, thinner than a pixel, lie between the centres of pixels.
    assert!(faint.len() < 12, "{} pixels, {:?}", faint.len(), &faint[..faint.len().min(5)]);
}

#[test]
fn a_triangle_takes_few_bytes() {
    let (mesh, frame) = sample(600, opaque);
    let svg = to_svg(&mesh, &colours(&mesh, &frame), &SvgOptions::default());
    let each = svg.len() as f64 / mesh.triangles.len() as f64;
    assert!(each <= 66.0, "{each} bytes a triangle");
}

#[test]
fn what_is_clear_is_left_out_and_what_is_faint_stays_faint() {
    let (mesh, frame) = sample(150, |x, _| {
        if x < 60 {
            0
        } else if x < 110 {
            128
        } else {
            255
        }
    });
    let svg = to_svg(&mesh, &colours(&mesh, &frame), &SvgOptions::default());
    let painted = rasterise(&mesh, &frame, Edges::Hard, None).frame;
    let (_, pixels) = drawn(&svg, 1.0, [0; 4]);
    for (drawn, painted) in pixels.iter().zip(painted.pixels()) {
        match painted[3] {
            0 => {}
            255 => assert!(drawn[3] > 60, "{drawn:?}, not {painted:?}"),
            _ => assert!(drawn[3] > 0, "{drawn:?}, not {painted:?}"),
        }
    }
    let mean =
        |alphas: Vec<u8>| alphas.iter().map(|&a| f64::from(a)).sum::<f64>() / SIZE.pixels() as f64;
    let found = mean(pixels.iter().map(|p| p[3]).collect());
    let wanted = mean(painted.pixels().iter().map(|p| p[3]).collect());
    assert!((found - wanted).abs() < 6.0, "{found}, not {wanted}");
}

#[test]
fn lines_and_titles_are_written() {
    let (mesh, frame) = sample(30, opaque);
    let edges: Vec<[u32; 2]> = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .filter(|[a, b]| a < b)
        .collect();
    let lines = Lines { edges: &edges, colour: [255, 0, 0, 255], width: 2.0, strength: 1.0 };
    let options = SvgOptions { title: "a < b & c\u{1}", lines: &[lines], ..SvgOptions::default() };
    let svg = to_svg(&mesh, &colours(&mesh, &frame), &options);
    assert!(svg.contains("<title>a &lt; b &amp; c</title>"), "{svg}");
    assert!(svg.contains("id=\"outline\""));
    let (_, pixels) = drawn(&svg, 1.0, MAGENTA);
    let red = pixels.iter().filter(|p| p[0] > 240 && p[1] < 15 && p[2] < 15).count();
    assert!(red > 500, "{red} red pixels");
}

#[test]
fn lines_that_are_not_opaque_are_as_opaque_as_asked() {
    let (mesh, frame) = sample(12, opaque);
    let colours = colours(&mesh, &frame);
    let edges: Vec<[u32; 2]> =
        mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    let lines = [Lines { edges: &edges, colour: [255, 0, 0, 100], width: 5.0, strength: 1.0 }];
    let options = SvgOptions { lines: &lines, ..SvgOptions::default() };
    let (_, pixels) = drawn(&to_svg(&mesh, &colours, &options), 1.0, [0; 4]);
    // As the rasteriser has it: the line stands in place of the facets.
    let red = pixels.iter().filter(|p| p[3].abs_diff(100) < 3 && p[0] > 250 && p[1] < 5).count();
    assert!(red > 1000, "{red} pixels");
    let mut svg = AnimatedSvg::default();
    for start in [0.0, 1.0] {
        svg.push(&mesh, &colours, start, &options).expect("small");
    }
    let text = svg.finish(2.0, None);
    assert_eq!(text.matches("mask=\"url(#beside-lines-2)\"").count(), 1, "each frame has its own");
}
