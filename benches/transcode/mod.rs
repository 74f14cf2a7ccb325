//! MP4 to MP4 through the library's own source and sink, compared with ffmpeg's plain transcode.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use polyreel::frame::{Frame, Rational};
use polyreel::geom::Size;
use polyreel::pipeline::{Settings, Stop, Summary, run};
use polyreel::sink::ffmpeg::{VideoOptions, VideoSink, VideoSpec};
use polyreel::sink::{Picture, Sink, SinkOptions};
use polyreel::source::{self, SourceOptions};
use polyreel::stage::Stage;
use polyreel::stream::Span;

use super::{film, with_steps};

/// Both encode as live video is encoded.
const PRESET: &str = "veryfast";
const CRF: u32 = 20;

/// Runs of each, taken in turn; the fastest counts, which a busy neighbour disturbed least.
const RUNS: usize = 3;

/// Frames of a clip that is made here, four seconds.
const FRAMES: u64 = 100;

/// The tables for `clips`, or for a clip of each of `sizes`.
pub(crate) fn bench(clips: &[String], sizes: &[Size]) {
    if !ffmpeg_is_there() {
        println!("\nSKIPPED: MP4 to MP4, for want of ffmpeg");
        return;
    }
    println!("\n## MP4 to MP4, x264 {PRESET} crf {CRF}, best of {RUNS} runs\n");
    println!("| clip | run | s | fps | times plain |");
    println!("|---|---|--:|--:|--:|");
    let folder = tempfile::tempdir().expect("a folder");
    let mut runs = Vec::new();
    for clip in clips {
        runs.extend(compare(Path::new(clip), folder.path()));
    }
    for &size in if clips.is_empty() { sizes } else { &[] } {
        let clip = folder.path().join(format!("{size}.mp4"));
        make(&clip, size);
        runs.extend(compare(&clip, folder.path()));
    }
    print_stages(&runs);
}

/// Levels of grain in the clips: as much as is left after a first encoding. More would be hard to encode
/// for ffmpeg, but not for polyreel, whose pictures have none, and the ratio would flatter.
const GRAIN: f64 = 2.0;

/// A clip of the film, all but lossless.
fn make(clip: &Path, size: Size) {
    let rate = Some(Rational::new(25, 1));
    let spec = VideoSpec { size, rate, duration: None, colour: None, alpha: false, sound: None };
    let mut sink = Box::new(VideoSink::create(clip, spec, &encoding(12)).expect("a sink"));
    for number in 0..FRAMES {
        let start = Rational::new(number as i64, 25);
        let span = Span { start, length: Some(Rational::new(1, 25)) };
        let frame: Frame = film::paint(size, number, GRAIN);
        sink.write(Picture { frame, fills: Vec::new(), span }, None).expect("written");
    }
    sink.finish().expect("finished");
}

fn encoding(crf: u32) -> SinkOptions {
    let video = VideoOptions {
        crf: Some(crf),
        encoder_preset: Some(PRESET.into()),
        audio: false,
        ..VideoOptions::default()
    };
    SinkOptions { overwrite: true, video, ..SinkOptions::default() }
}

/// Plain, without and with refinement.
fn compare(clip: &Path, folder: &Path) -> Vec<(String, Summary)> {
    let output = folder.join("output.mp4");
    let mut best = [Duration::MAX; 3];
    let mut summaries = Vec::new();
    for _ in 0..RUNS {
        summaries.clear();
        best[0] = best[0].min(plain(clip, &output));
        for steps in [0, 1] {
            let (time, summary) = polyreel(clip, &output, steps);
            let place = &mut best[1 + steps as usize];
            *place = (*place).min(time);
            summaries.push(summary);
        }
    }
    let name = clip.file_stem().unwrap_or_default().to_string_lossy();
    let names = ["ffmpeg alone", "polyreel, 0 steps", "polyreel, 1 step"];
    for (run, time) in names.iter().zip(best) {
        let seconds = time.as_secs_f64();
        let fps = summaries[0].frames as f64 / seconds;
        let ratio = seconds / best[0].as_secs_f64();
        println!("| {name} | {run} | {seconds:.2} | {fps:.1} | {ratio:.2} |");
    }
    summaries
        .into_iter()
        .zip(0..)
        .map(|(summary, steps)| (format!("{name}, {steps} steps"), summary))
        .collect()
}

/// Median and tails of the stages' times, of the last run of each kind.
fn print_stages(runs: &[(String, Summary)]) {
    println!("\n| p50 / p95 / p99 ms | {} |", Stage::ALL.map(Stage::name).join(" | "));
    println!("|---{}|", "|--:".repeat(Stage::ALL.len()));
    for (name, summary) in runs {
        let times = Stage::ALL.map(|stage| {
            let p = summary.stages.get(stage);
            format!("{:.1} / {:.1} / {:.1}", p.p50_ms, p.p95_ms, p.p99_ms)
        });
        println!("| {name} | {} |", times.join(" | "));
    }
}

/// Everything from the name of the input to the finished output.
fn polyreel(clip: &Path, output: &Path, steps: u32) -> (Duration, Summary) {
    let began = Instant::now();
    let inputs = [clip.to_string_lossy().into_owned()];
    let input = source::open(&inputs, &SourceOptions::default()).expect("a clip");
    let info = input.info().clone();
    let mut with = encoding(CRF);
    with.video.gives_way = steps > 0;
    let sink = VideoSink::create(output, VideoSpec::of(&info, info.size), &with);
    let sink = Box::new(sink.expect("a sink"));
    let settings = Settings { options: with_steps(steps), ..Settings::default() };
    let summary = run(|| input.start(), sink, &settings, &mut (), &Stop::default());
    (began.elapsed(), summary.expect("renders"))
}

/// ffmpeg from the same input to the same kind of output.
fn plain(clip: &Path, output: &Path) -> Duration {
    let began = Instant::now();
    let status = Command::new("ffmpeg")
        .args(["-nostdin", "-v", "error", "-y", "-i"])
        .arg(clip)
        .args(["-an", "-c:v", "libx264", "-preset", PRESET, "-crf", &CRF.to_string()])
        .arg(output)
        .status();
    assert!(status.is_ok_and(|s| s.success()), "ffmpeg failed on {}", clip.display());
    began.elapsed()
}

fn ffmpeg_is_there() -> bool {
    let mut command = Command::new("ffmpeg");
    command.arg("-version").stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}
