//! Frames a second, serial and threaded, and the time of each stage: `cargo bench --bench pipeline`.
//!
//! The film is made here: a sunset with hills and drifting clouds, with the grain that generated video
//! has.

use std::hint::black_box;
use std::time::Instant;

use polyreel::chance::{Purpose, unit};
use polyreel::error::Result;
use polyreel::frame::{Frame, Rational, Rgba, Span};
use polyreel::geom::Size;
use polyreel::options::Options;
use polyreel::pipeline::{Settings, Stop, run};
use polyreel::render::Renderer;
use polyreel::sink::{Picture, Sink};
use polyreel::source::{Decoded, Source};
use polyreel::stage::Stage;

/// Frames of a run: enough that the first and the last, which nobody overlaps with, do not matter.
const FRAMES: usize = 48;

/// Different frames; a run plays them over and over, so that painting them takes no part of its time.
const DIFFERENT: usize = 8;

fn main() {
    for size in [Size::new(640, 360), Size::new(1280, 720), Size::new(1920, 1080)] {
        bench(size);
    }
}

fn bench(size: Size) {
    let film: Vec<_> = (0..DIFFERENT).map(|t| paint(size, t as f64 * 0.08)).collect();
    let options = Options::default();

    let began = Instant::now();
    let mut renderer = Renderer::new(&options).expect("the defaults are sound");
    for t in 0..FRAMES {
        black_box(renderer.render(&film[t % DIFFERENT]).expect("renders"));
    }
    let serial = FRAMES as f64 / began.elapsed().as_secs_f64();

    let settings = Settings { options, ..Settings::default() };
    let start = || Ok(Box::new(Replay { film, next: 0 }) as Box<dyn Source>);
    let summary = run(start, Box::new(Nowhere), &settings, &mut (), &Stop::default());
    let summary = summary.expect("renders");
    println!("{size}: serial {serial:.1} fps, threaded {:.1} fps", summary.fps());
    for stage in Stage::ALL {
        let times = summary.stages.get(stage);
        let (p50, p95, p99) = (times.p50_ms, times.p95_ms, times.p99_ms);
        println!("  {:<12} p50 {p50:7.2} ms  p95 {p95:7.2} ms  p99 {p99:7.2} ms", stage.name());
    }
}

/// A frame at moment `t`.
fn paint(size: Size, t: f64) -> Frame {
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    let pixels = (0..size.pixels()).map(|i| {
        let (px, py) = (i as u32 % size.width, i as u32 / size.width);
        let (x, y) = (f64::from(px) / width, f64::from(py) / height);
        let sun = (x - 0.3).hypot((y - 0.35) * height / width);
        let cloud = (9.0 * x + t).sin() * (21.0 * y - 3.0 * x).cos() + (17.0 * x - 2.0 * t).sin();
        let hill = 0.7 + 0.06 * (7.0 * x + 0.2).sin() + 0.02 * (31.0 * x).sin();
        let [r, g, b] = if y > hill {
            [30.0 + 60.0 * (y - hill), 50.0 + 90.0 * (1.0 - y), 45.0]
        } else if sun < 0.06 {
            [255.0, 235.0, 170.0]
        } else {
            [250.0 - 130.0 * y + 18.0 * cloud, 120.0 + 60.0 * y + 18.0 * cloud, 90.0 + 120.0 * y]
        };
        let grain = 10.0 * (unit((t * 100.0) as u64, Purpose::Noise, px, py) - 0.5);
        let channel = |v: f64| (v + grain).clamp(0.0, 255.0) as u8;
        [channel(r), channel(g), channel(b), 255] as Rgba
    });
    Frame::new(size, pixels.collect()).expect("a frame of this size")
}

struct Replay {
    film: Vec<Frame>,
    next: usize,
}

impl Source for Replay {
    fn next(&mut self) -> Result<Option<Decoded>> {
        if self.next == FRAMES {
            return Ok(None);
        }
        let frame = self.film[self.next % DIFFERENT].clone();
        let length = Rational::new(1, 25);
        let start = Rational::new(self.next as i64, 25);
        self.next += 1;
        Ok(Some(Decoded { frame, span: Span { start, length: Some(length) } }))
    }
}

struct Nowhere;

impl Sink for Nowhere {
    fn write(&mut self, picture: Picture) -> Result<()> {
        black_box(picture);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}
