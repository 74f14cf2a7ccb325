//! What changes while the pipeline runs changes at one frame for all stages, as the serial renderer
//! does it.

use std::sync::{Arc, Mutex};

use polyreel::error::Result;
use polyreel::frame::{Buffers, Frame, Rational};
use polyreel::geom::Size;
use polyreel::options::{Colour, Detail, Look, Method, Options, Points, Quality, Steps, Target};
use polyreel::pipeline::{Controls, Settings, Stop, run};
use polyreel::render::{Rendered, Renderer};
use polyreel::sink::{Origin, Picture, Sink};
use polyreel::source::{Decoded, Source};
use polyreel::stream::Span;

const FRAMES: u64 = 8;

/// The frame at which the options change.
const CHANGE: u64 = 4;

/// A disc that wanders over a gradient.
fn frame(index: u64) -> Frame {
    let size = Size::new(80, 60);
    let x0 = 12.0 + 2.0 * index as f64;
    let pixels = (0..size.pixels() as u32).map(|i| {
        let (x, y) = (i % size.width, i / size.width);
        if (f64::from(x) - x0).hypot(f64::from(y) - 30.0) < 11.0 {
            [210, 40, (y * 4) as u8, 255]
        } else {
            [(x * 3) as u8, (y * 4) as u8, 90, 255]
        }
    });
    Frame::new(size, pixels.collect()).expect("a small frame")
}

/// Changes the options just before it hands out frame [`CHANGE`].
struct Film {
    next: u64,
    change: Option<(Controls, Options)>,
}

impl Source for Film {
    fn next(&mut self) -> Result<Option<Decoded>> {
        if self.next == FRAMES {
            return Ok(None);
        }
        if let Some((controls, options)) = self.change.take_if(|_| self.next == CHANGE) {
            controls.set(options)?;
        }
        let start = Rational::new(self.next as i64, 25);
        self.next += 1;
        let span = Span { start, length: Some(Rational::new(1, 25)) };
        Ok(Some(Decoded::new(frame(self.next - 1), span)))
    }
}

struct Keep(Arc<Mutex<Vec<Frame>>>);

impl Sink for Keep {
    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        self.0.lock().expect("the lock").push(picture.frame);
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}

fn base() -> Options {
    Options { points: Points::Count(90), ..Options::default() }
}

/// What the pipeline makes of the film when `before` becomes `after` at frame [`CHANGE`].
fn piped(before: &Options, after: &Options) -> Vec<Frame> {
    let controls = Controls::new(before.clone()).expect("sound options");
    let kept = Arc::new(Mutex::new(Vec::new()));
    let film = Film { next: 0, change: Some((controls.clone(), after.clone())) };
    let settings = Settings { controls: Some(controls), ..Settings::default() };
    let start = || Ok(Box::new(film) as Box<dyn Source>);
    run(start, Box::new(Keep(kept.clone())), &settings, &mut (), &Stop::default())
        .expect("a run without mishaps");
    let mut kept = kept.lock().expect("the lock");
    std::mem::take(&mut *kept)
}

/// The same by the serial renderer.
fn serial(before: &Options, after: &Options) -> Vec<Rendered> {
    let mut renderer = Renderer::new(before).expect("sound options");
    (0..FRAMES)
        .map(|index| {
            if index == CHANGE {
                renderer.retune(after).expect("sound options");
            }
            renderer.render(&frame(index)).expect("renders")
        })
        .collect()
}

#[test]
fn a_change_takes_effect_at_one_frame_in_all_stages() {
    let changes = [
        Options { outline: Some(Colour([255, 0, 0, 255])), ..base() },
        Options { coherence: 0.9, ..base() },
        Options { coherence: 0.0, ..base() },
        Options { refine: Some(5), ..base() },
        Options { points: Points::Count(140), ..base() },
        Options { method: Method::Hslp, clusters: 5, ..base() },
        Options { points: Points::Auto, error: Some(Target::Psnr(24.0)), ..base() },
    ];
    for after in changes {
        for (before, after) in [(base(), after.clone()), (after, base())] {
            let expected = serial(&before, &after);
            let expected: Vec<_> = expected.into_iter().map(|r| r.picture).collect();
            assert!(piped(&before, &after) == expected, "{before:?} to {after:?}");
        }
    }
}

#[test]
fn seeds_live_through_changes_that_do_not_concern_them() {
    let alive = [
        Options { outline: Some(Colour([255; 4])), ..base() },
        Options { coherence: 0.8, regularity: 0.2, ..base() },
        Options { quality: Quality::Best, ..base() },
        Options { refine: Some(7), ..base() },
    ];
    for after in alive {
        let life = serial(&base(), &after)[CHANGE as usize].life;
        assert!(life.kept + life.moved > life.born, "{life:?} with {after:?}");
    }
    let anew = [
        Options { points: Points::Count(91), ..base() },
        Options { method: Method::Rlp, ..base() },
        Options { clusters: 4, ..base() },
        Options { hex_density: Some(0.01), ..base() },
        Options { seed: 1, ..base() },
    ];
    for after in anew {
        let rendered = serial(&base(), &after).swap_remove(CHANGE as usize);
        assert_eq!(rendered.life.kept + rendered.life.moved, 0, "{after:?}");
        let alone = Renderer::new(&after).expect("sound").render(&frame(CHANGE)).expect("renders");
        // Only the numbers of the vertices go on.
        let mut mesh = rendered.mesh;
        mesh.ids.clone_from(&alone.mesh.ids);
        assert_eq!(mesh, alone.mesh, "as if it were the first: {after:?}");
    }
}

#[test]
fn a_wrong_change_changes_nothing() {
    let mut renderer = Renderer::new(&base()).expect("sound options");
    renderer.retune(&Options { clusters: 1, ..base() }).expect_err("one cluster");
    let mut other = Renderer::new(&base()).expect("sound options");
    let same = other.render(&frame(0)).expect("renders");
    assert_eq!(renderer.render(&frame(0)).expect("renders"), same);
}

#[test]
fn a_number_found_once_is_not_looked_for_again() {
    let auto = Options { points: Points::Auto, error: Some(Target::Psnr(24.0)), ..base() };
    let outlined = Options { outline: Some(Colour([0, 0, 0, 255])), ..auto.clone() };
    let rendered = serial(&auto, &outlined);
    let counts: Vec<_> = rendered.iter().map(|r| r.mesh.seeds().len()).collect();
    assert!(counts.iter().all(|&count| count == counts[0]), "{counts:?}");
    assert!(rendered[CHANGE as usize].life.kept > 0);
}

#[test]
fn seeds_live_on_when_there_are_fewer_or_more() {
    let mut renderer = Renderer::new(&base()).expect("sound options");
    let mut render = |index: u64, seeds: u32| {
        let detail = Detail { seeds, ..Detail::FULL };
        renderer.render_in(&frame(index), &detail).expect("renders")
    };
    let [_, full, half, still_half, back] =
        [(0, 100), (1, 100), (2, 50), (3, 50), (4, 100)].map(|(i, seeds)| render(i, seeds));
    let counts = [&full, &half, &still_half, &back].map(|r| r.mesh.seeds().len());
    assert_eq!(counts, [90, 45, 45, 90]);
    assert_eq!((half.life.moved, half.life.born, half.life.died), (45, 0, 45));
    assert_eq!((back.life.moved, back.life.born, back.life.died), (45, 45, 0));
    assert!(!half.life.cut && !back.life.cut);
    for rendered in [&half, &still_half, &back] {
        assert_eq!(rendered.mesh.check(), Ok(()));
    }
    assert!(still_half.life.kept > 0, "nothing begins anew where nothing changes");
}

#[test]
fn a_frame_that_is_not_looked_at_keeps_its_mesh_and_the_next_one_catches_up() {
    let mut renderer = Renderer::new(&base()).expect("sound options");
    let blind = Detail { look: Look::Reuse, steps: Some(Steps::default()), ..Detail::FULL };
    let first = renderer.render_in(&frame(0), &blind).expect("renders");
    assert!(first.candidates > 0, "the first frame has to be looked at");
    let second = renderer.render_in(&frame(3), &blind).expect("renders");
    // The colours are those of the new frame.
    let mut unpainted = second.mesh.clone();
    unpainted.fills.clone_from(&first.mesh.fills);
    assert_eq!(unpainted, first.mesh);
    let seen = Detail { steps: Some(Steps::default()), ..Detail::FULL };
    let third = renderer.render_in(&frame(3), &seen).expect("renders");
    assert_ne!(third.mesh, second.mesh, "the next frame catches up");
}
