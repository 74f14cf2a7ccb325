//! What holds for every method and front end: the number of seeds, sound meshes, the same bytes on any
//! number of threads, all sizes.

use polyreel::chance::{Purpose, rank};
use polyreel::frame::Frame;
use polyreel::geom::Size;
use polyreel::options::{FrontEnd, Method, Options, Points};
use polyreel::render::{Rendered, Renderer};

/// Disks and ramps with grain.
fn scene(size: Size) -> Frame {
    let pixel = |i: u32| {
        let (x, y) = (i % size.width, i / size.width);
        let grain = (rank(3, Purpose::Noise, x, y) % 12) as u32;
        let disk = (x % 50).abs_diff(25).pow(2) + (y % 50).abs_diff(25).pow(2) < 200;
        let tone = if disk { 200 - (x / 50) * 20 % 100 } else { 40 + (x + y) / 8 % 120 };
        [tone + grain, tone / 2 + grain, 255 - tone, 255].map(|v| v.min(255) as u8)
    };
    Frame::new(size, (0..size.pixels() as u32).map(pixel).collect()).expect("as many as pixels")
}

fn render(options: &Options, frame: &Frame) -> Rendered {
    Renderer::new(options).expect("sound options").render(frame).expect("a sound frame")
}

#[test]
fn every_method_meets_the_number_of_seeds_on_every_front_end() {
    let frame = scene(Size::new(160, 120));
    for method in Method::ALL {
        for features in FrontEnd::ALL.map(Some).into_iter().chain([None]) {
            for points in [1, 40, 700] {
                let points = Points::Count(points);
                let rendered =
                    render(&Options { method, features, points, ..Options::default() }, &frame);
                assert_eq!(rendered.mesh.check(), Ok(()));
                let seeds = rendered.mesh.seeds().len();
                assert_eq!(seeds, points.target(frame.size()), "{method:?} {features:?}");
            }
        }
    }
}

#[test]
fn every_method_works_on_every_size() {
    for (width, height) in [(1, 1), (2, 1), (1, 40), (40, 1), (3, 3), (17, 5), (300, 2)] {
        let frame = scene(Size::new(width, height));
        for method in Method::ALL {
            for points in [Points::Count(5), Points::Share(0.3), Points::Share(1.0)] {
                let rendered = render(&Options { method, points, ..Options::default() }, &frame);
                assert_eq!(rendered.mesh.check(), Ok(()), "{method:?} {width}x{height}");
                let target = points.target(frame.size());
                assert!(rendered.mesh.seeds().len() <= target, "{method:?} {width}x{height}");
            }
        }
    }
}

#[test]
fn flat_and_transparent_frames_have_meshes_too() {
    let size = Size::new(80, 60);
    for colour in [[90, 120, 200, 255], [9, 9, 9, 0]] {
        let frame = Frame::filled(size, colour).expect("flat");
        for method in Method::ALL {
            let options = Options { method, points: Points::Count(50), ..Options::default() };
            let rendered = render(&options, &frame);
            assert_eq!((rendered.mesh.check(), rendered.mesh.seeds().len()), (Ok(()), 50));
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let frame = scene(Size::new(231, 187));
    for method in Method::ALL {
        for features in [None, Some(FrontEnd::Sobel), Some(FrontEnd::Slic)] {
            let options =
                Options { method, features, points: Points::Count(400), ..Options::default() };
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                pool.expect("a pool").install(|| render(&options, &frame))
            };
            let one = on(1);
            assert!(one == on(2) && one == on(8), "{method:?} {features:?}");
        }
    }
}

#[test]
fn methods_differ_and_seeds_decide() {
    let frame = scene(Size::new(160, 120));
    let seeds = |method, seed| {
        let options = Options { method, seed, points: Points::Count(150), ..Options::default() };
        render(&options, &frame).mesh.vertices
    };
    for (i, a) in Method::ALL.into_iter().enumerate() {
        for b in &Method::ALL[..i] {
            assert_ne!(seeds(a, 0), seeds(*b, 0), "{a:?} {b:?}");
        }
        if a != Method::Entropy {
            assert_ne!(seeds(a, 0), seeds(a, 1), "{a:?}");
        }
    }
}
