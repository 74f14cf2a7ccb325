//! Frames in a row through the whole chain: what stands still stays, what moves keeps its seeds, and a
//! cut is a cut.

use polyreel::chance::{Purpose, unit};
use polyreel::frame::Frame;
use polyreel::geom::Size;
use polyreel::metric::mse::mse;
use polyreel::options::{Options, Points};
use polyreel::render::{Rendered, Renderer};

const SIZE: Size = Size::new(240, 160);

/// A frame with the grey of each pixel, and what is made of it for the other channels.
fn painted(grey: impl Fn(f64, f64) -> f64) -> Frame {
    let pixels = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
    let pixel = |(x, y): (u32, u32)| {
        let g = grey(f64::from(x), f64::from(y)).clamp(0.0, 255.0);
        [g as u8, (0.7 * g + 20.0) as u8, (200.0 - 0.5 * g) as u8, 255]
    };
    Frame::new(SIZE, pixels.map(pixel).collect()).expect("a small frame")
}

/// Smooth noise of `pitch` pixels a knot, 0 to 1.
fn blobs(seed: u64, x: f64, y: f64, pitch: f64) -> f64 {
    let knot = |x: f64, y: f64| unit(seed, Purpose::Noise, x as u32 + 50, y as u32 + 50);
    let (u, v) = (x / pitch + 99.0, y / pitch);
    let (fu, fv) = (u.fract(), v.fract());
    let row = |v: f64| knot(u.floor(), v) * (1.0 - fu) + knot(u.floor() + 1.0, v) * fu;
    row(v.floor()) * (1.0 - fv) + row(v.floor() + 1.0) * fv
}

/// A scene by chance, coarse and fine, moved to the right, its brightness scaled.
fn scene(seed: u64, moved: f64, light: f64) -> Frame {
    painted(|x, y| {
        let x = x - moved;
        light * 255.0 * (0.6 * blobs(seed, x, y, 29.0) + 0.4 * blobs(seed + 90, x, y, 7.0))
    })
}

/// Pictures of all sorts: flat, a gradient, edges, texture.
fn sorts() -> [(&'static str, Frame); 5] {
    let edges = |x: f64, y: f64| {
        let disc = (x - 150.0).hypot(y - 80.0) < 45.0;
        if disc {
            210.0
        } else if x + 0.4 * y < 90.0 {
            60.0
        } else {
            130.0
        }
    };
    [
        ("flat", painted(|_, _| 117.0)),
        ("gradient", painted(|x, y| 30.0 + 0.6 * x + 0.3 * y)),
        ("edges", painted(edges)),
        ("steep edges on a gradient", painted(|x, y| edges(x, y) * 0.6 + 0.4 * y)),
        ("texture", scene(5, 0.0, 1.0)),
    ]
}

/// `clean` with Gaussian noise of standard deviation `sigma` in each channel, another one for each `t`.
fn noisy(clean: &Frame, sigma: f64, t: u64) -> Frame {
    let channel = |i: usize, c: usize, value: u8| {
        let draw = |n: u32| unit(t * 8 + c as u64, Purpose::Noise, i as u32, n);
        // Box and Muller.
        let radius = (-2.0 * (1.0 - draw(0)).ln()).sqrt();
        let normal = radius * (draw(1) * std::f64::consts::TAU).cos();
        (f64::from(value) + sigma * normal).round().clamp(0.0, 255.0) as u8
    };
    let pixels = clean.pixels().iter().enumerate();
    let pixels =
        pixels.map(|(i, &[r, g, b, a])| [channel(i, 0, r), channel(i, 1, g), channel(i, 2, b), a]);
    Frame::new(clean.size(), pixels.collect()).expect("a small frame")
}

fn options() -> Options {
    Options { points: Points::Count(300), ..Options::default() }
}

fn rendered(frames: impl IntoIterator<Item = Frame>) -> Vec<Rendered> {
    let mut renderer = Renderer::new(&options()).expect("sound options");
    frames.into_iter().map(|frame| renderer.render(&frame).expect("renders")).collect()
}

/// Mean change from one frame to the next, over pixels and colours.
fn change(frames: &[&Frame]) -> f64 {
    let pair = |a: &Frame, b: &Frame| {
        let pairs = a.pixels().iter().zip(b.pixels());
        let sum: u32 =
            pairs.flat_map(|(a, b)| (0..3).map(|c| u32::from(a[c].abs_diff(b[c])))).sum();
        f64::from(sum) / (3 * a.pixels().len()) as f64
    };
    let sum: f64 = frames.windows(2).map(|w| pair(w[0], w[1])).sum();
    sum / (frames.len() - 1) as f64
}

#[test]
fn a_still_is_the_same_from_its_tenth_frame_on() {
    for (sort, frame) in sorts() {
        let seen = rendered(vec![frame; 30]);
        for (t, later) in seen.iter().enumerate().skip(10) {
            assert!(later.picture == seen[10].picture, "{sort}, frame {t}");
            assert!(later.mesh == seen[10].mesh, "{sort}, frame {t}");
        }
    }
}

/// With many seeds, a few of which went on changing by turns for some frames more. With one step a frame it takes some
/// frames longer.
#[test]
fn a_still_full_of_detail_is_the_same_from_its_tenth_frame_on() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/lake.jpg");
    let picture = image::open(path).expect("a sample").to_rgba8();
    let size = Size::new(picture.width(), picture.height());
    let pixels = picture.pixels().map(|pixel| pixel.0).collect();
    let frame = Frame::new(size, pixels).expect("a small frame");
    for (refine, settled) in [(None, 10), (Some(1), 15)] {
        let points = Points::Count(size.pixels() as u32 * 3 / 100);
        let options = Options { points, refine, ..options() };
        let mut renderer = Renderer::new(&options).expect("sound options");
        let seen: Vec<_> = (0..24).map(|_| renderer.render(&frame).expect("renders")).collect();
        let changes = |&t: &usize| seen[t].picture != seen[t - 1].picture;
        let last = (1..seen.len()).filter(changes).max();
        assert!(last < Some(settled), "{refine:?}: {last:?}");
    }
}

#[test]
fn noise_of_the_source_is_less_than_half_in_the_output() {
    for (sort, clean) in sorts() {
        let frames: Vec<Frame> = (0..20).map(|t| noisy(&clean, 2.0, t)).collect();
        let seen = rendered(frames.iter().cloned());
        let noise = change(&frames.iter().collect::<Vec<_>>());
        let output = change(&seen.iter().map(|r| &r.picture).collect::<Vec<_>>());
        assert!(output < 0.5 * noise, "{sort}: {output} of {noise}");
    }
}

#[test]
fn the_number_of_seeds_holds_while_the_picture_moves() {
    for speed in [0.7, 3.0, 9.0] {
        let seen = rendered((0..24).map(|t| scene(3, f64::from(t) * speed, 1.0)));
        for (t, Rendered { mesh, life, .. }) in seen.iter().enumerate() {
            let seeds = mesh.seeds().len();
            assert!((294..=306).contains(&seeds), "{speed}, frame {t}: {seeds}");
            assert_eq!(mesh.check(), Ok(()));
            assert!(t == 0 || !life.cut, "{speed}, frame {t}");
            assert!(t == 0 || life.kept + life.moved + life.born == seeds, "{life:?}");
        }
    }
}

/// The frames that are reported as the first of a new shot.
fn cuts(frames: impl IntoIterator<Item = Frame>) -> Vec<usize> {
    let seen = rendered(frames);
    seen.iter().enumerate().filter(|(_, r)| r.life.cut).map(|(t, _)| t).collect()
}

#[test]
fn every_cut_is_reported_in_its_frame() {
    let shot = |seed: u64| (0..5).map(move |t| scene(seed, f64::from(t) * 3.0, 1.0));
    assert_eq!(cuts((1..=6).flat_map(shot)), [5, 10, 15, 20, 25]);
}

#[test]
fn no_flash_and_no_fade_is_reported_as_a_cut() {
    let white = Frame::filled(SIZE, [255; 4]).expect("white");
    let flash = (0..9).map(|t| if t == 4 { white.clone() } else { scene(1, f64::from(t), 1.0) });
    assert_eq!(cuts(flash), [0; 0], "a white frame");
    let light = (0..9).map(|t| scene(1, f64::from(t), if t == 4 { 1.6 } else { 0.6 }));
    assert_eq!(cuts(light), [0; 0], "more light");
    let out = (0..18).map(|t| scene(1, 0.0, 1.0 - f64::from(t) * 0.05));
    assert_eq!(cuts(out), [0; 0], "a fade to black");
    assert_eq!(cuts((1..18).map(|t| scene(1, 0.0, f64::from(t) * 0.05))), [0; 0], "a fade in");
    // Its first frame shows nothing; what comes after has a mesh of its own, but is no cut.
    let fast = rendered((0..4).map(|t| scene(1, 0.0, f64::from(t) / 3.0)));
    assert!(fast.iter().all(|r| !r.life.cut), "a fast fade from black");
    assert_eq!(fast[1].life.born, fast[1].mesh.seeds().len());
}

/// Without a step of refinement seeds are born and die all the same: a mesh that was only carried had
/// half as much error again as frames that are each alone, and more with every frame.
#[test]
fn seeds_live_without_refinement_too() {
    let course = |coherence: f64| {
        let options = Options { refine: Some(0), coherence, ..options() };
        let mut renderer = Renderer::new(&options).expect("sound options");
        let (mut error, mut born) = (0.0, 0);
        for t in 0..40 {
            let frame = scene(3, f64::from(t) * 4.0, 1.0);
            let seen = renderer.render(&frame).expect("renders");
            error += mse(&frame, &seen.picture).expect("one size");
            born += if t > 0 { seen.life.born } else { 0 };
            assert_eq!((seen.mesh.check(), seen.refine_steps), (Ok(()), 0));
        }
        (error, born)
    };
    let (alone, _) = course(0.0);
    let (carried, born) = course(Options::default().coherence);
    assert!(carried < 1.2 * alone && born > 0, "{carried} of {alone}, {born} born");
}
