//! What holds for every study: sound meshes at any size, the same bytes on any number of threads, clips.

use polyreel::chance::{Purpose, rank};
use polyreel::frame::Frame;
use polyreel::geom::Size;
use polyreel::options::{Options, Points, STUDIES};
use polyreel::render::{Rendered, Renderer};

/// Disks and ramps with grain, moved by `shift`; the left is transparent in part.
fn scene(size: Size, shift: u32) -> Frame {
    let pixel = |i: u32| {
        let (x, y) = (i % size.width, i / size.width);
        let grain = (rank(8, Purpose::Noise, x, y) % 10) as u32;
        let disk = ((x + shift) % 60).abs_diff(30).pow(2) + (y % 50).abs_diff(25).pow(2) < 300;
        let tone = if disk { 210 - (y / 50) * 30 % 100 } else { 30 + (2 * x + y) / 6 % 90 };
        let alpha = if x < size.width / 8 { 90 } else { 255 };
        [tone + grain, tone / 2 + grain, 235 - tone, alpha].map(|v| v.min(255) as u8)
    };
    Frame::new(size, (0..size.pixels() as u32).map(pixel).collect()).expect("as many as pixels")
}

/// Each study, with fewer points so that none is found by search.
fn studies() -> impl Iterator<Item = (&'static str, Options)> {
    STUDIES.iter().map(|study| {
        let options = Options::study(study.name).expect(study.name);
        (study.name, Options { points: Points::Count(150), error: None, ..options })
    })
}

fn render(options: &Options, frame: &Frame) -> Rendered {
    Renderer::new(options).expect("sound options").render(frame).expect("a sound frame")
}

#[test]
fn every_study_has_a_sound_mesh_at_any_size() {
    for (width, height) in [(1, 1), (2, 1), (3, 3), (17, 5), (1, 60), (120, 90)] {
        let frame = scene(Size::new(width, height), 0);
        for (name, options) in studies() {
            let rendered = render(&options, &frame);
            assert_eq!(rendered.mesh.check(), Ok(()), "{name} {width}x{height}");
            if width == 120 {
                assert_eq!(rendered.mesh.seeds().len(), 150, "{name}");
            }
        }
    }
}

#[test]
fn every_study_gives_the_same_bytes_on_any_number_of_threads() {
    let frame = scene(Size::new(210, 160), 0);
    for (name, options) in studies() {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("a pool").install(|| render(&options, &frame))
        };
        assert!(on(1) == on(3), "{name}");
    }
}

#[test]
fn every_study_carries_its_mesh_through_a_clip() {
    let size = Size::new(140, 100);
    for (name, options) in studies() {
        let options = Options { coherence: 0.4, ..options };
        let mut renderer = Renderer::new(&options).expect("sound options");
        let first = renderer.render(&scene(size, 0)).expect("a sound frame");
        for shift in [1, 2, 3] {
            let next = renderer.render(&scene(size, shift)).expect("a sound frame");
            assert_eq!(next.mesh.seeds().len(), first.mesh.seeds().len(), "{name}");
            let kept = next.life.kept + next.life.moved;
            assert!(kept * 10 >= 8 * first.mesh.seeds().len(), "{name}: {kept} are kept");
        }
    }
}

/// A number that the picture asks for stays where it does, and follows slowly where it does not.
#[test]
fn points_of_a_clip_follow_the_picture_and_do_not_pump() {
    let size = Size::new(256, 192);
    let options = Options { points: Points::Auto, ..Options::default() };
    let mut renderer = Renderer::new(&options).expect("sound options");
    let mut seeds =
        |frame: &Frame| renderer.render(frame).expect("a sound frame").mesh.seeds().len();
    let counts: Vec<_> = (0..40).map(|t| seeds(&scene(size, t))).collect();
    assert!(counts.iter().all(|count| *count == counts[0]), "{counts:?}");
    // What is seen gets darker by and by, and leaves only a ramp.
    let faded = |t: u32| {
        let last = scene(size, 40);
        let pixels = last.pixels().iter().map(|&[r, g, b, _]| {
            let fade = |v: u8| (u32::from(v) * (30 - t.min(30)) / 30) as u8;
            [fade(r), fade(g), fade(b), 255]
        });
        Frame::new(size, pixels.collect()).expect("as many as pixels")
    };
    let fading: Vec<_> = (0..100).map(|t| seeds(&faded(t))).collect();
    // The disk at its last place asks for a few more than where it was at first: once up at most, then down.
    let turn = fading.iter().position(|count| Some(count) == fading.iter().max()).unwrap_or(0);
    assert!(fading[..turn].iter().all(|count| *count == counts[0]), "{fading:?}");
    assert!(fading[turn..].is_sorted_by(|a, b| a >= b), "{fading:?}");
    let steps = fading.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert!((1..=5).contains(&steps) && fading[99] * 2 < counts[0], "{fading:?}");
}
