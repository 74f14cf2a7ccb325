//! Frames a second, serial and threaded, and the time of each stage; then from MP4 to MP4, compared with

mod film;
mod transcode;

use std::hint::black_box;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use polyreel::error::Result;
use polyreel::frame::{Buffers, Frame, Rational};
use polyreel::geom::Size;
use polyreel::options::Options;
use polyreel::pipeline::{FrameReport, Observer, Settings, Stop, run};
use polyreel::render::Renderer;
use polyreel::sink::{Origin, Picture, Sink};
use polyreel::source::{Decoded, Source};
use polyreel::stage::{Percentiles, Stage};
use polyreel::stream::Span;

/// Frames of a run: enough that the first and the last, which nobody overlaps with, do not matter.
const FRAMES: usize = 96;

/// Different frames; a run plays them over and over, so that painting them takes no part of its time.
const DIFFERENT: u64 = 8;

/// What a frame may take at 30 frames a second.
const ALLOWED: Duration = Duration::from_millis(33);

fn main() {
    let clips: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let sizes = [Size::new(1280, 720), Size::new(1920, 1080)];
    if clips.is_empty() {
        for size in sizes {
            let film = film::shot(size, DIFFERENT);
            for steps in [0, 1] {
                compute(&film, steps);
            }
        }
    }
    transcode::bench(&clips, &sizes);
}

/// Options of a run with `steps` of refinement for each frame.
fn with_steps(steps: u32) -> Options {
    Options { refine: Some(steps), ..Options::default() }
}

/// From decoded frames to low-poly frames, in memory.
fn compute(film: &[Frame], steps: u32) {
    let options = with_steps(steps);
    let mut renderer = Renderer::new(&options).expect("the defaults are sound");
    let mut times: Vec<_> = (0..FRAMES)
        .map(|t| {
            let began = Instant::now();
            black_box(renderer.render(&film[t % film.len()]).expect("renders"));
            began.elapsed()
        })
        .collect();
    let serial = FRAMES as f64 / times.iter().sum::<Duration>().as_secs_f64();
    let missed = times.iter().filter(|time| **time > ALLOWED).count();

    let settings = Settings { options, ..Settings::default() };
    let replay = Replay { film: film.to_vec(), next: 0 };
    let mut watch = Watch { last: Instant::now(), gaps: Vec::new(), missed: 0 };
    let start = || Ok(Box::new(replay) as Box<dyn Source>);
    let summary = run(start, Box::new(Nowhere), &settings, &mut watch, &Stop::default());
    let summary = summary.expect("renders");
    let (threaded, size) = (summary.fps(), film[0].size());

    println!("\n## {size}, {steps} refinement steps a frame, {FRAMES} frames\n");
    println!("| frames | fps | p50 ms | p95 ms | p99 ms | over 33 ms |");
    println!("|---|--:|--:|--:|--:|--:|");
    print_row("serial: a frame", &format!("{serial:.1}"), Percentiles::of(&mut times), missed);
    let gaps = Percentiles::of(&mut watch.gaps);
    print_row("threaded: frame to frame", &format!("{threaded:.1}"), gaps, watch.missed);
    for stage in Stage::ALL.into_iter().filter(|s| !matches!(s, Stage::Decode | Stage::Encode)) {
        let times = summary.stages.get(stage);
        println!(
            "| threaded: {stage} | | {:.2} | {:.2} | {:.2} | |",
            times.p50_ms, times.p95_ms, times.p99_ms
        );
    }
    println!("\nthreaded / serial: {:.2}", threaded / serial);
}

fn print_row(name: &str, fps: &str, times: Percentiles, missed: usize) {
    let Percentiles { p50_ms, p95_ms, p99_ms } = times;
    println!("| {name} | {fps} | {p50_ms:.2} | {p95_ms:.2} | {p99_ms:.2} | {missed} |");
}

/// Looks at the time from one frame to the next.
struct Watch {
    last: Instant,
    gaps: Vec<Duration>,
    missed: usize,
}

impl Observer for Watch {
    fn frame_done(&mut self, _: &FrameReport) -> ControlFlow<()> {
        let gap = self.last.elapsed();
        self.last = Instant::now();
        self.missed += usize::from(gap > ALLOWED);
        self.gaps.push(gap);
        ControlFlow::Continue(())
    }
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
        let frame = self.film[self.next % self.film.len()].clone();
        let length = Rational::new(1, 25);
        let start = Rational::new(self.next as i64, 25);
        self.next += 1;
        Ok(Some(Decoded::new(frame, Span { start, length: Some(length) })))
    }
}

struct Nowhere;

impl Sink for Nowhere {
    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        black_box(picture);
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}
