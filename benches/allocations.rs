//! Bytes and allocations for each frame of a video that runs already, stage by stage:
//! `cargo bench -p polyreel-bench --bench allocations`. Memory that is asked for again and again costs page faults, and
//! nobody sees it in a profile of functions.

// The one place where a program may say how memory is had is a trait whose functions are unsafe.
#![allow(unsafe_code)]

mod chain;
mod film;

use std::alloc::{GlobalAlloc, Layout, System};
use std::hint::black_box;
use std::sync::atomic::{AtomicU64, Ordering};

use chain::{Chain, STAGES};
use polyreel::frame::{Frame, Rational};
use polyreel::geom::Size;
use polyreel::options::Options;
use polyreel::sink::ffmpeg::{VideoSink, VideoSpec};
use polyreel::sink::{Picture, Sink, SinkOptions};
use polyreel::source::SourceOptions;
use polyreel::stream::Span;

/// Frames before the counting, so that all buffers have found their size.
const BEFORE: u64 = 24;
/// Frames that are counted.
const FRAMES: u64 = 24;
/// Different frames.
const DIFFERENT: u64 = 8;

/// An allocation from this size on is had from the system page by page, at first at least (glibc,
/// `M_MMAP_THRESHOLD`).
const LARGE: usize = 128 << 10;

static COUNT: AtomicU64 = AtomicU64::new(0);
static BYTES: AtomicU64 = AtomicU64::new(0);
static LARGE_COUNT: AtomicU64 = AtomicU64::new(0);
static LARGE_BYTES: AtomicU64 = AtomicU64::new(0);

/// The system's allocator, counted.
struct Counted;

#[global_allocator]
static ALLOCATOR: Counted = Counted;

fn note(bytes: usize) {
    COUNT.fetch_add(1, Ordering::Relaxed);
    BYTES.fetch_add(bytes as u64, Ordering::Relaxed);
    if bytes >= LARGE {
        LARGE_COUNT.fetch_add(1, Ordering::Relaxed);
        LARGE_BYTES.fetch_add(bytes as u64, Ordering::Relaxed);
    }
}

// SAFETY: every call goes on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(size);
        // SAFETY: as the caller promises.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// What was asked for: allocations and their bytes, and of these the large ones.
#[derive(Clone, Copy, Default)]
struct Asked([u64; 4]);

impl Asked {
    fn now() -> Self {
        Self([&COUNT, &BYTES, &LARGE_COUNT, &LARGE_BYTES].map(|c| c.load(Ordering::Relaxed)))
    }

    /// Adds what was asked for since `before`, which becomes now.
    fn add_since(&mut self, before: &mut Self) {
        let now = Self::now();
        for (sum, (now, before)) in self.0.iter_mut().zip(now.0.iter().zip(before.0)) {
            *sum += now - before;
        }
        *before = now;
    }

    fn print(&self, name: &str, frames: u64) {
        let [count, bytes, large, large_bytes] = self.0.map(|v| v as f64 / frames as f64);
        let (kib, large_kib) = (bytes / 1024.0, large_bytes / 1024.0);
        println!("| {name:<11} | {count:11.1} | {kib:9.1} | {large:8.2} | {large_kib:9.1} |");
    }
}

fn main() {
    for size in [Size::new(1280, 720), Size::new(1920, 1080)] {
        let film = film::shot(size, DIFFERENT);
        let frame_kib = size.pixels() * 4 / 1024;
        println!("\n### {size}, for each frame (a frame has {frame_kib} KiB)\n");
        println!("| stage       | allocations |       KiB | >128 KiB |       KiB |");
        println!("|-------------|------------:|----------:|---------:|----------:|");
        stages(&film);
        if ffmpeg_is_there() {
            ends(size, &film);
        } else {
            println!("\nSKIPPED: decode and encode, for want of ffmpeg");
        }
    }
}

/// Everything between decode and encode.
fn stages(film: &[Frame]) {
    let options = Options { refine: Some(1), ..Options::default() };
    let mut chain = Chain::new(&options, Some(film::form(film[0].size())));
    let mut sums = [Asked::default(); STAGES.len()];
    for number in 0..BEFORE + FRAMES {
        if number == BEFORE {
            sums = Default::default();
        }
        let (mut before, mut stage) = (Asked::now(), 0);
        let frame = &film[(number % DIFFERENT) as usize];
        let picture = black_box(chain.render(frame, |_| {
            sums[stage].add_since(&mut before);
            stage += 1;
        }));
        chain.recycle(picture);
    }
    for (stage, sum) in STAGES.iter().zip(sums) {
        sum.print(stage.name(), FRAMES);
    }
}

/// Decode and encode of a video.
fn ends(size: Size, film: &[Frame]) {
    let folder = tempfile::tempdir().expect("a folder");
    let clip = folder.path().join("clip.mp4");
    let rate = Some(Rational::new(25, 1));
    let spec = VideoSpec { size, rate, duration: None, colour: None, alpha: false, sound: None };
    let sink = VideoSink::create(&clip, spec, &SinkOptions::default()).expect("a sink");
    let mut sink = Box::new(sink);
    let mut encode = Asked::default();
    for number in 0..BEFORE + FRAMES {
        let frame = film[(number % DIFFERENT) as usize].clone();
        let start = Rational::new(number as i64, 25);
        let span = Span { start, length: Some(Rational::new(1, 25)) };
        let mut before = Asked::now();
        sink.write(Picture { frame, fills: Vec::new(), span }, None).expect("written");
        if number >= BEFORE {
            encode.add_since(&mut before);
        }
    }
    sink.finish().expect("finished");

    let clip = clip.to_string_lossy().into_owned();
    let input = polyreel::source::open(&[clip], &SourceOptions::default()).expect("a source");
    let mut source = input.start().expect("started");
    let mut decode = Asked::default();
    // The last frames are not looked at: the end of the input has its own needs.
    let counted = FRAMES - 2;
    for number in 0..BEFORE + counted {
        let mut before = Asked::now();
        let decoded = source.next().expect("decoded").expect("a frame");
        if number >= BEFORE {
            decode.add_since(&mut before);
        }
        // As the pipeline does with what has been painted.
        source.recycle(decoded.frame);
    }
    decode.print("decode", counted);
    encode.print("encode", FRAMES);
}

fn ffmpeg_is_there() -> bool {
    let quiet = std::process::Stdio::null;
    std::process::Command::new("ffmpeg")
        .arg("-version")
        .stdout(quiet())
        .stderr(quiet())
        .status()
        .is_ok_and(|status| status.success())
}
