//! An input that is played twice: its beginning goes on from its end.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Arc, Mutex};

use polyreel::error::Result;
use polyreel::frame::{Buffers, Frame};
use polyreel::geom::Size;
use polyreel::options::{Options, Points};
use polyreel::pipeline::{self, Ending, FrameReport, Observer, Settings, Stop, Summary};
use polyreel::render::Renderer;
use polyreel::sink::{Origin, Picture, Sink};
use polyreel::source::{self, Source, SourceOptions};

const SIZE: Size = Size::new(192, 128);
const FRAMES: usize = 12;

/// Frame `t` of a film without a seam: a disc goes round on a ground that stands still.
fn frame(t: usize) -> Frame {
    let angle = t as f64 / FRAMES as f64 * std::f64::consts::TAU;
    let (cx, cy) = (60.0 + 10.0 * angle.cos(), 64.0 + 10.0 * angle.sin());
    let pixels = (0..SIZE.pixels()).map(|i| {
        let (x, y) = ((i % 192) as f64, (i / 192) as f64);
        let ground = 110.0 + 60.0 * (x * 0.13).sin() * (y * 0.17).cos() + x * 0.4;
        if (x - cx).hypot(y - cy) < 15.0 {
            [220, 60, 40, 255]
        } else {
            [ground as u8, (ground * 0.8) as u8, 120, 255]
        }
    });
    Frame::new(SIZE, pixels.collect()).expect("a small frame")
}

/// The film as numbered pictures in `folder`; the name of their pattern.
fn film(folder: &Path) -> String {
    for t in 0..FRAMES {
        let name = folder.join(format!("{t:02}.png"));
        frame(t).into_image().save(name).expect("a writable folder");
    }
    folder.join("%02d.png").display().to_string()
}

fn options() -> Options {
    Options { points: Points::Count(300), ..Options::default() }
}

/// Keeps the pictures.
struct Keep(Arc<Mutex<Vec<Picture>>>);

impl Sink for Keep {
    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        self.0.lock().expect("nobody panicked").push(picture);
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}

/// Keeps the reports.
#[derive(Default)]
struct Reports(Vec<FrameReport>);

impl Observer for Reports {
    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()> {
        self.0.push(report.clone());
        ControlFlow::Continue(())
    }
}

type Run = (Result<Summary>, Vec<Picture>, Vec<FrameReport>);

fn run(start: impl FnOnce() -> Result<Box<dyn Source>> + Send, settings: &Settings) -> Run {
    let kept = Arc::default();
    let mut reports = Reports::default();
    let sink = Box::new(Keep(Arc::clone(&kept)));
    let ended = pipeline::run(start, sink, settings, &mut reports, &Stop::default());
    let pictures = std::mem::take(&mut *kept.lock().expect("nobody panicked"));
    (ended, pictures, reports.0)
}

fn run_film(looped: bool, settings: &Settings) -> Run {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let wanted = SourceOptions { looped, ..SourceOptions::default() };
    let input = source::open(&[film(folder.path())], &wanted).expect("an input");
    assert_eq!(input.info().frames, Some(FRAMES as u64));
    run(|| input.start(), settings)
}

/// The second of two rounds of the serial renderer.
fn second_round() -> Vec<Frame> {
    let mut renderer = Renderer::new(&options()).expect("sound options");
    let mut round = || {
        let frames = (0..FRAMES).map(|t| renderer.render(&frame(t)).expect("renders"));
        frames.map(|rendered| rendered.picture).collect::<Vec<_>>()
    };
    round();
    round()
}

#[test]
fn what_is_written_is_the_second_round_of_the_serial_renderer_and_only_that() {
    for threads in [1, 2, 8] {
        let threads = std::num::NonZeroUsize::new(threads);
        let settings = Settings { options: options(), threads, ..Settings::default() };
        let (ended, pictures, reports) = run_film(true, &settings);
        let summary = ended.expect("a run");
        assert!(matches!(summary.ending, Ending::Complete));
        assert_eq!(summary.frames, FRAMES as u64);
        let order: Vec<_> = reports.iter().map(|report| report.index).collect();
        assert_eq!(order, (0..FRAMES as u64).collect::<Vec<_>>());
        assert_eq!(reports[0].pts_s, 0.0);
        assert!(!reports[0].cut, "the end leads into the beginning");
        let frames: Vec<Frame> = pictures.into_iter().map(|picture| picture.frame).collect();
        assert!(frames == second_round(), "{threads:?}");
    }
}

/// Mean change from one picture to another, over pixels and colours.
fn change(a: &Picture, b: &Picture) -> f64 {
    let pairs = a.frame.pixels().iter().zip(b.frame.pixels());
    let sum: u32 = pairs.flat_map(|(a, b)| (0..3).map(|c| u32::from(a[c].abs_diff(b[c])))).sum();
    f64::from(sum) / (3 * a.frame.pixels().len()) as f64
}

/// The change from the last picture to the first, as a share of the mean change between the others. Of
/// the film itself it is 1.
fn jump(pictures: &[Picture]) -> f64 {
    let inner: f64 = pictures.windows(2).map(|pair| change(&pair[0], &pair[1])).sum();
    let last = pictures.last().expect("pictures");
    change(last, &pictures[0]) / inner * (pictures.len() - 1) as f64
}

/// Where the seam goes is a matter of chance for a few hundred triangles: so the mean of several meshes
/// is bounded too. The excess over 1 was 0.54 without the warm-up round and 0.34 with it.
#[test]
fn a_film_without_a_seam_plays_round_with_less_of_a_jump() {
    let mut excess = [0.0; 2];
    for points in [150, 300, 600] {
        let options = Options { points: Points::Count(points), ..options() };
        let settings = Settings { options, ..Settings::default() };
        let [once, looped] = [false, true].map(|looped| jump(&run_film(looped, &settings).1));
        assert!(looped < once, "{points} points: {looped} instead of {once}");
        excess[0] += (once - 1.0) / 3.0;
        excess[1] += (looped - 1.0) / 3.0;
    }
    assert!(excess[1] < 0.8 * excess[0] && excess[1] < 0.5, "{excess:?}");
}

#[test]
fn an_input_that_breaks_off_is_kept_where_that_is_allowed_and_fails_at_once_where_not() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pattern = film(folder.path());
    let torn = folder.path().join("05.png");
    let bytes = std::fs::read(&torn).expect("a picture");
    std::fs::write(&torn, &bytes[..bytes.len() / 2]).expect("a writable folder");
    for allow_truncated in [false, true] {
        let wanted = SourceOptions { looped: true, allow_truncated, ..SourceOptions::default() };
        let input = source::open(std::slice::from_ref(&pattern), &wanted).expect("sound headers");
        let settings = Settings { options: options(), allow_truncated, ..Settings::default() };
        let (ended, pictures, _) = run(|| input.start(), &settings);
        if allow_truncated {
            assert!(matches!(ended.expect("kept").ending, Ending::Truncated(_)));
            assert_eq!(pictures.len(), 5);
        } else {
            let error = ended.expect_err("it breaks off").to_string();
            assert!(error.contains("frame 5"), "{error}");
            assert!(pictures.is_empty());
        }
    }
}

#[test]
fn a_still_is_read_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    film(folder.path());
    let wanted = SourceOptions { looped: true, ..SourceOptions::default() };
    let still = folder.path().join("00.png").display().to_string();
    let mut source = source::open(&[still], &wanted).expect("an input").start().expect("starts");
    let frame = source.next().expect("a frame").expect("one frame");
    assert!(!frame.is_warmup);
    assert!(source.next().expect("an end").is_none());
}
