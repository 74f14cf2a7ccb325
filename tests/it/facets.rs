//! Facets of wanted sizes.

use polyreel::chance::{Purpose, rank};
use polyreel::frame::Frame;
use polyreel::geom::{SUBPIXEL, Size, orient};
use polyreel::mesh::Mesh;
use polyreel::options::{Length, Options, Points, Quality};
use polyreel::{Renderer, Rgba};

/// A disk on a ground with grain, `shift` pixels from the left.
fn picture(size: Size, shift: u32) -> Frame {
    let pixel = |x: u32, y: u32| -> Rgba {
        let grain = (rank(5, Purpose::Noise, x, y) % 40) as u8;
        let inside = x.abs_diff(50 + shift).pow(2) + y.abs_diff(60).pow(2) < 900;
        if inside { [200 + grain, 90, 40, 255] } else { [30, 60 + grain, (x % 200) as u8, 255] }
    };
    let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| pixel(x, y)));
    Frame::new(size, pixels.collect()).expect("a small frame")
}

/// The areas of triangles, in pixels, ascending.
fn areas(mesh: &Mesh) -> Vec<f64> {
    let unit = 2.0 * f64::from(SUBPIXEL) * f64::from(SUBPIXEL);
    let area = |t: usize| {
        let [a, b, c] = mesh.triangle(t);
        orient(a, b, c) as f64 / unit
    };
    let mut areas: Vec<_> = (0..mesh.triangles.len()).map(area).collect();
    areas.sort_unstable_by(f64::total_cmp);
    areas
}

#[test]
fn facets_keep_to_their_limits_on_stills_and_clips() {
    let size = Size::new(160, 120);
    // Equilateral triangles with sides of 8 and 24 pixels.
    let (least, most) = (0.433 * 64.0, 0.433 * 576.0);
    for (coherence, points) in [(0.0, 2000), (0.4, 2000), (0.4, 20)] {
        let options = Options {
            points: Points::Count(points),
            min_facet: Some(Length::Pixels(8.0)),
            max_facet: Some(Length::Share(0.2)),
            quality: Quality::Best,
            coherence,
            ..Options::default()
        };
        let mut renderer = Renderer::new(&options).expect("sound options");
        for frame in 0..4 {
            let rendered = renderer.render(&picture(size, 2 * frame)).expect("a frame");
            let areas = areas(&rendered.mesh);
            let outside = areas.iter().filter(|&&a| a < 0.9 * least || a > 1.1 * most).count();
            assert!(
                outside * 12 <= areas.len(),
                "frame {frame}, coherence {coherence}: {outside} of {}: {:?} to {:?}",
                areas.len(),
                &areas[..8],
                areas.last()
            );
        }
    }
}
