//! Vertices keep their numbers as long as they live.

use std::collections::{BTreeMap, BTreeSet};

use polyreel_core::unstable::options::{Detail, Steps};
use polyreel_core::{Frame, Options, Point, Points, Renderer, Size};

const SIZE: Size = Size::new(160, 120);

/// A disc that wanders over stripes.
fn frame(t: u32) -> Frame {
    let pixels = (0..SIZE.pixels() as u32).map(|i| {
        let (x, y) = (i % SIZE.width, i / SIZE.width);
        let (dx, dy) = (x.abs_diff(30 + 6 * t), y.abs_diff(50 + 2 * t));
        let ground = [(x / 20 % 2 * 120) as u8, (2 * y) as u8, 90, 255];
        if dx * dx + dy * dy < 900 { [220, y as u8, 40, 255] } else { ground }
    });
    Frame::new(SIZE, pixels.collect()).expect("a small frame")
}

fn renderer() -> Renderer {
    let options = Options { points: Points::Count(300), ..Options::default() };
    Renderer::new(&options).expect("options in range")
}

fn by_id(ids: &[u64], vertices: &[Point]) -> BTreeMap<u64, Point> {
    assert_eq!(ids.len(), vertices.len());
    assert_eq!(ids[..4], [0, 1, 2, 3]);
    let by_id: BTreeMap<_, _> = ids.iter().copied().zip(vertices.iter().copied()).collect();
    assert_eq!(by_id.len(), ids.len(), "no number stands twice");
    by_id
}

#[test]
fn vertices_that_live_on_keep_their_numbers_and_no_number_comes_again() {
    let mut renderer = renderer();
    let mut seen = BTreeSet::new();
    let mut before: BTreeMap<u64, Point> = BTreeMap::new();
    for t in 0..8 {
        let rendered = renderer.render(&frame(t)).expect("a frame");
        let now = by_id(&rendered.mesh.ids, &rendered.mesh.vertices);
        let born = now.keys().filter(|id| !before.contains_key(*id)).count();
        assert!(now.keys().all(|id| before.contains_key(id) || !seen.contains(id)), "frame {t}");
        if t > 0 {
            assert!(rendered.life.born <= born && born < 150, "frame {t}: {born} born");
            let far = |id: &u64| {
                let ((x, y), (u, v)) = (now[id].to_pixels(), before[id].to_pixels());
                (x - u).hypot(y - v) > 40.0
            };
            assert!(!now.keys().filter(|id| before.contains_key(*id)).any(far), "frame {t}");
        }
        seen.extend(now.keys().copied());
        before = now;
    }
}

#[test]
fn seeds_that_outlive_a_change_of_their_number_keep_theirs() {
    let mut renderer = renderer();
    let first = renderer.render(&frame(0)).expect("a frame").mesh;
    let detail = Detail { seeds: 50, steps: Some(Steps::new(0)), ..Detail::FULL };
    let half = renderer.render_in(&frame(0), &detail).expect("a frame").mesh;
    let (first, half) = (by_id(&first.ids, &first.vertices), by_id(&half.ids, &half.vertices));
    assert!(half.len() < 200 && half.iter().all(|(id, p)| first.get(id) == Some(p)));
}
