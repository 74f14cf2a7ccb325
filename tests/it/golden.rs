//! Golden pictures: the exact bytes of small renders.
//!
//! `BLESS="the reason" cargo test --test it golden` writes those that differ anew, notes the reason with
//! the old and new errors in `tests/golden/REASONS.md`, and fails, so that no blessing passes unseen.
//! Without it, expected, difference and actual are left in one picture in the target folder.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use image::{Rgba, RgbaImage};
use polyreel::chance::{Purpose, rank};
use polyreel::colour::{
    Coding, Form, Layout, Matrix, Planes, Range, Sampling, Siting, from_rgba, to_rgba,
};
use polyreel::frame::Frame;
use polyreel::geom::Size;
use polyreel::metric::mse::mse;
use polyreel::metric::ssim::ssim;
use polyreel::options::{
    Colour, Detail, Edges, FillMode, FrontEnd, Look, Method, Options, Points, Quality, Shape, Steps,
};
use polyreel::render::Renderer;
use polyreel::sink::SinkOptions;

use crate::files::given::{folder as temporary_folder, name, write};

/// A picture of whole-number formulas: a disk and a bar on a gradient, with a little grain; `shift`
/// moves the disk.
fn scene(size: Size, shift: u32, glass: bool) -> Frame {
    let pixel = |x: u32, y: u32| {
        let grain = (rank(11, Purpose::Noise, x, y) % 9) as u32;
        let (dx, dy) = (x.abs_diff(size.width / 3 + shift), y.abs_diff(size.height / 2));
        let inside = dx * dx + dy * dy < size.height * size.height / 9;
        let bar = (x + 2 * y) % size.width > size.width * 3 / 4;
        let [r, g, b] = match (inside, bar) {
            (true, _) => [220, 90 + y % 60, 40],
            (false, true) => [30, 60, 110 + x % 50],
            (false, false) => [70 + x * 90 / size.width, 120 + y * 80 / size.height, 170],
        };
        let alpha = if glass && !inside { (x * 255 / size.width) as u8 } else { 255 };
        [(r + grain) as u8, (g + grain) as u8, (b + grain) as u8, alpha]
    };
    let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| pixel(x, y)));
    Frame::new(size, pixels.collect()).expect("a small frame")
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// Compares `actual`, made from `source`, with the golden picture `name`.
fn compare(name: &str, source: &Frame, actual: &RgbaImage) {
    let path = folder().join(format!("{name}.png"));
    let expected = image::open(&path).ok().map(|image| image.to_rgba8());
    if expected.as_ref() == Some(actual) {
        return;
    }
    if let Ok(reason) = std::env::var("BLESS") {
        let before = expected.map_or("none".into(), |expected| errors(source, &expected));
        bless(&path, name, actual, &format!("{before} -> {}", errors(source, actual)), &reason);
    }
    let hint = "BLESS=\"the reason\" makes it anew";
    let Some(expected) = expected else { panic!("there is no {}: {hint}", path.display()) };
    let report = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-differs.png"));
    side_by_side(&expected, actual).save(&report).expect("the target folder can be written");
    panic!("{name} differs from its golden picture: see {}; {hint}", report.display());
}

/// Writes a golden picture and the reason for it, and fails.
fn bless(path: &Path, name: &str, actual: &RgbaImage, errors: &str, reason: &str) -> ! {
    /// One line at a time.
    static REASONS: Mutex<()> = Mutex::new(());
    assert!(
        reason.split_whitespace().count() > 1 && !reason.contains('|'),
        "a blessing needs a reason of some words: BLESS=\"edges are antialiased\""
    );
    actual.save(path).expect("the golden folder can be written");
    let _alone = REASONS.lock().unwrap_or_else(PoisonError::into_inner);
    let file = std::fs::OpenOptions::new().append(true).open(folder().join("REASONS.md"));
    let line = format!("| {name} | {errors} | {} |\n", reason.trim());
    file.expect("the list of reasons").write_all(line.as_bytes()).expect("it can be written");
    panic!("{name} was blessed ({errors}): look at it, then run again without BLESS");
}

/// How far a picture is from its source.
fn errors(source: &Frame, picture: &RgbaImage) -> String {
    let pixels = picture.pixels().map(|pixel| pixel.0).collect();
    let size = Size::new(picture.width(), picture.height());
    let picture = Frame::new(size, pixels).expect("a small frame");
    match (mse(source, &picture), ssim(source, &picture)) {
        (Ok(mse), Ok(ssim)) => format!("MSE {mse:.2}, SSIM {ssim:.4}"),
        _ => "of another size".into(),
    }
}

#[test]
fn every_golden_picture_belongs_to_a_test() {
    let tests = include_str!("golden.rs");
    for entry in std::fs::read_dir(folder()).expect("the golden folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_stem().expect("a name").to_string_lossy();
        let is_used =
            ["check", "compare", "study"].map(|f| tests.contains(&format!("{f}(\"{name}\"")));
        assert!(
            name == "REASONS" || is_used.contains(&true),
            "no test names {}: remove it",
            path.display()
        );
    }
}

/// Expected, difference (white where they differ), actual.
fn side_by_side(expected: &RgbaImage, actual: &RgbaImage) -> RgbaImage {
    let (w, h) = (expected.width().max(actual.width()), expected.height().max(actual.height()));
    let at = |image: &RgbaImage, x: u32, y: u32| image.get_pixel_checked(x, y).copied();
    RgbaImage::from_fn(3 * w, h, |x, y| {
        let (e, a) = (at(expected, x % w, y), at(actual, x % w, y));
        let shown = match x / w {
            0 => e,
            1 => Some(if e == a { Rgba([0, 0, 0, 255]) } else { Rgba([255; 4]) }),
            _ => a,
        };
        shown.unwrap_or(Rgba([0; 4]))
    })
}

fn check(name: &str, options: &Options, frames: &[Frame]) {
    let mut renderer = Renderer::new(options).expect("sound options");
    let mut last = None;
    for frame in frames {
        let rendered = renderer.render(frame).expect("a sound frame");
        assert_eq!(rendered.mesh.check(), Ok(()));
        last = Some(rendered.picture);
    }
    let source = frames.last().expect("at least one frame");
    compare(name, source, &last.expect("at least one frame").into_image());
}

const SIZE: Size = Size::new(150, 101);

/// Hard edges show which triangle each pixel belongs to.
fn points(n: u32) -> Options {
    Options { points: Points::Count(n), edges: Edges::Hard, ..Options::default() }
}

#[test]
fn hrlp() {
    check("hrlp", &points(220), &[scene(SIZE, 0, false)]);
}

#[test]
fn hrlp_to_the_letter_of_the_paper() {
    let paper = Options { points: Points::Count(220), ..Options::paper() };
    check("paper", &paper, &[scene(SIZE, 0, false)]);
}

#[test]
fn another_seed_is_another_picture() {
    check("seed", &Options { seed: 1, ..points(220) }, &[scene(SIZE, 0, false)]);
}

#[test]
fn transparency() {
    check("glass", &points(220), &[scene(SIZE, 0, true)]);
}

#[test]
fn smooth_edges() {
    let smooth = Options { edges: Edges::Smooth, ..points(220) };
    check("smooth", &smooth, &[scene(SIZE, 0, false)]);
}

#[test]
fn smooth_edges_where_it_is_transparent() {
    let smooth = Options { edges: Edges::Smooth, ..points(220) };
    check("smooth-glass", &smooth, &[scene(SIZE, 0, true)]);
}

#[test]
fn outline() {
    let outline = Some(Colour([20, 20, 30, 255]));
    check("outline", &Options { outline, ..points(120) }, &[scene(SIZE, 0, false)]);
}

fn filled(fill: FillMode) -> Options {
    Options { fill, ..points(120) }
}

#[test]
fn medians() {
    check("fill-median", &filled(FillMode::Median), &[scene(SIZE, 0, false)]);
}

#[test]
fn colours_at_centroids() {
    check("fill-centroid", &filled(FillMode::Centroid), &[scene(SIZE, 0, false)]);
}

#[test]
fn planes_of_colour() {
    check("fill-linear", &filled(FillMode::Linear), &[scene(SIZE, 0, false)]);
}

#[test]
fn planes_of_colour_where_it_is_transparent() {
    check("fill-linear-glass", &filled(FillMode::Linear), &[scene(SIZE, 0, true)]);
}

#[test]
fn colours_at_vertices() {
    check("fill-gouraud", &filled(FillMode::Gouraud), &[scene(SIZE, 0, false)]);
}

#[test]
fn lines_on_transparency() {
    check("fill-none", &filled(FillMode::None), &[scene(SIZE, 0, false)]);
}

fn shaped(shape: Shape) -> Options {
    Options { shape, outline: Some(Colour([20, 20, 30, 255])), ..points(160) }
}

#[test]
fn third_frame_of_panes() {
    let frames = [0, 2, 4].map(|shift| scene(SIZE, shift, false));
    check("polygons", &shaped(Shape::Polygons), &frames);
}

#[test]
fn panes_where_it_is_transparent() {
    check("polygons-glass", &shaped(Shape::Polygons), &[scene(SIZE, 0, true)]);
}

#[test]
fn third_frame_of_voronoi_cells() {
    let frames = [0, 2, 4].map(|shift| scene(SIZE, shift, false));
    check("voronoi", &shaped(Shape::Voronoi), &frames);
}

#[test]
fn a_learned_palette() {
    let palette = Some("5".parse().expect("a number of colours"));
    check("colours-5", &Options { palette, ..points(160) }, &[scene(SIZE, 0, false)]);
}

#[test]
fn two_tones_of_more_contrast() {
    let duotone = Some("navy,#ffe8c0".parse().expect("two colours"));
    let options = Options { duotone, contrast: 1.3, ..points(160) };
    check("duotone", &options, &[scene(SIZE, 0, false)]);
}

#[test]
fn a_spot_in_focus() {
    let focus = Some("30%,50%,30%".parse().expect("a place and a radius"));
    check("focus", &Options { focus, ..points(160) }, &[scene(SIZE, 0, false)]);
}

#[test]
fn third_frame_of_a_moving_scene() {
    let frames = [0, 2, 4].map(|shift| scene(SIZE, shift, false));
    check("moving", &points(220), &frames);
}

#[test]
fn more_points_than_features() {
    let flat = Frame::filled(SIZE, [90, 120, 200, 255]).expect("flat");
    check("flat", &Options { outline: Some(Colour([0, 0, 0, 255])), ..points(60) }, &[flat]);
}

/// Level one and two of a method alone: refinement would hide the differences between methods.
fn unrefined(method: Method) -> Options {
    Options { method, quality: Quality::Draft, ..points(220) }
}

#[test]
fn help() {
    check("help", &unrefined(Method::Help), &[scene(SIZE, 0, false)]);
}

#[test]
fn hslp() {
    check("hslp", &unrefined(Method::Hslp), &[scene(SIZE, 0, false)]);
}

#[test]
fn rlp() {
    check("rlp", &unrefined(Method::Rlp), &[scene(SIZE, 0, false)]);
}

#[test]
fn entropy() {
    check("entropy", &unrefined(Method::Entropy), &[scene(SIZE, 0, false)]);
}

#[test]
fn pic2polyart() {
    check("pic2polyart", &unrefined(Method::Pic2polyart), &[scene(SIZE, 0, false)]);
}

#[test]
fn sobel_before_density() {
    let options = Options { features: Some(FrontEnd::Sobel), ..unrefined(Method::Hrlp) };
    check("sobel", &options, &[scene(SIZE, 0, false)]);
}

/// A study at a number of points that shows its triangles.
fn study(name: &str) {
    let published = Options::study(name).expect(name);
    let options = Options { points: Points::Count(220), error: None, ..published };
    check(name, &options, &[scene(SIZE, 0, false)]);
}

#[test]
fn study_gai_2015() {
    study("gai-2015");
}

#[test]
fn study_zhang_2016() {
    study("zhang-2016");
}

#[test]
fn study_qian_2016() {
    study("qian-2016");
}

#[test]
fn study_uasmith_2017() {
    study("uasmith-2017");
}

#[test]
fn study_ma_2017() {
    study("ma-2017");
}

#[test]
fn study_ng_2017() {
    study("ng-2017");
}

#[test]
fn study_lawonn_2018() {
    study("lawonn-2018");
}

#[test]
fn study_pic2polyart_2021() {
    study("pic2polyart-2021");
}

#[test]
fn study_laske_2024() {
    study("laske-2024");
}

/// After a first frame with all details.
#[test]
fn third_frame_with_the_detail_of_a_tight_budget() {
    let frames = [0, 2, 4].map(|shift| scene(SIZE, shift, false));
    let steps = Some(Steps::from_eighths(4));
    let tight = Detail { look: Look::Half, seeds: 50, steps, rows: 4 };
    let mut renderer = Renderer::new(&points(220)).expect("sound options");
    let details = [Detail::FULL, tight, tight];
    let pictures = frames
        .iter()
        .zip(details)
        .map(|(frame, detail)| renderer.render_in(frame, &detail).expect("a sound frame").picture);
    let last = pictures.last().expect("three frames");
    compare("budget", &frames[2], &last.into_image());
}

/// Frames of video come as planes and are painted as planes, each with the residual of the one before.
#[test]
fn third_frame_as_planes() {
    let size = Size::new(150, 102);
    let form = Form {
        layout: Layout { size, sampling: Sampling::Yuv420, siting: Siting::Left, alpha: false },
        coding: Coding { matrix: Matrix::Bt709, range: Range::Limited },
    };
    let frames = [0, 2, 4].map(|shift| scene(size, shift, false));
    let planar = frames.each_ref().map(|frame| {
        let mut data = Vec::new();
        from_rgba(size, frame.pixels(), &form.layout, form.coding, &mut data);
        Frame::planar(Planes { form, data }, Vec::new()).expect("even sides")
    });
    let smooth = Options { edges: Edges::Smooth, ..points(220) };
    let mut renderer = Renderer::new(&smooth).expect("sound options").with_form(Some(form));
    let painted = planar.map(|frame| renderer.render(&frame).expect("a frame").picture);
    let planes = painted[2].planes().expect("planes were asked for");
    let mut pixels = Vec::new();
    to_rgba(&form.layout, form.coding, &planes.data, &mut pixels);
    let picture = Frame::new(size, pixels).expect("as many as pixels");
    compare("planes", &frames[2], &picture.into_image());
}

/// More colours than a palette has, some of them transparent.
#[test]
fn palette_of_a_gif() {
    let frame = scene(SIZE, 0, true);
    let mut renderer = Renderer::new(&points(700)).expect("sound options");
    let painted = renderer.render(&frame).expect("a sound frame").picture;
    let folder = temporary_folder();
    let file = name(&folder, "a.gif");
    write(&file, &[painted], &[10], &SinkOptions::default()).expect("a GIF");
    let picture = image::open(&file).expect("a GIF").to_rgba8();
    compare("palette", &frame, &picture);
}
