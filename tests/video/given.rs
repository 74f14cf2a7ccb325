//! What the tests start from: clips made by ffmpeg, and what ffprobe says of files.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use polyreel::error::Result;
use polyreel::ffmpeg::Ffmpeg;
use polyreel::frame::{Frame, Rational, Rgba};
use polyreel::geom::Size;
use polyreel::sink::Sound;
use polyreel::sink::ffmpeg::{VideoOptions, VideoSink, VideoSpec};
use polyreel::sink::{Picture, Sink, SinkOptions};
use polyreel::source::ffmpeg::Video;
use polyreel::source::{Decoded, Source};
use polyreel::stream::Span;
use tempfile::TempDir;

/// Whether there is an ffmpeg to test with.
pub(crate) fn require() -> bool {
    let there = Command::new("ffmpeg").arg("-version").output().is_ok()
        && Command::new("ffprobe").arg("-version").output().is_ok();
    if !there {
        assert_ne!(std::env::var("REQUIRE_FFMPEG").as_deref(), Ok("1"), "ffmpeg is missing");
        // Not by `eprintln`: of a test that passes nobody would see it.
        let _ = writeln!(std::io::stderr(), "SKIPPED: this test needs ffmpeg and ffprobe");
    }
    there
}

/// A folder for a test's files.
pub(crate) fn folder() -> TempDir {
    TempDir::new().expect("a temporary folder")
}

/// Runs ffmpeg with the words of `args`, then the file.
pub(crate) fn make(folder: &TempDir, name: &str, args: &str) -> PathBuf {
    let path = folder.path().join(name);
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-nostdin", "-y"]).args(args.split_whitespace()).arg(&path);
    let output = command.output().expect("ffmpeg runs");
    assert!(output.status.success(), "{args}: {}", String::from_utf8_lossy(&output.stderr));
    path
}

/// What ffprobe says for `entries`, a line each.
pub(crate) fn ask(path: &Path, select: &str, entries: &str) -> Vec<String> {
    let output = Command::new("ffprobe")
        .args(["-v", "error", "-select_streams", select, "-show_entries", entries])
        .args(["-of", "csv=p=0"])
        .arg(path)
        .output()
        .expect("ffprobe runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.lines()
        .map(|line| line.trim_end_matches(',').to_string())
        .filter(|l| !l.is_empty())
        .collect()
}

/// Times of all frames by ffprobe's account.
pub(crate) fn times(path: &Path) -> Vec<f64> {
    let lines = ask(path, "v:0", "frame=pts_time");
    lines.iter().map(|line| line.parse().expect("a time")).collect()
}

/// Seconds of sound that come out when it is decoded, and when it begins.
pub(crate) fn sound(path: &Path) -> Option<(f64, f64)> {
    let mut frames = ask(path, "a:0", "frame=pts_time,pkt_duration_time,duration_time")
        .into_iter()
        .map(|line| {
            let mut parts = line.split(',').map(|part| part.parse::<f64>().unwrap_or(0.0));
            (parts.next().unwrap_or(0.0), parts.next().unwrap_or(0.0))
        });
    let first = frames.next()?;
    let last = frames.next_back().unwrap_or(first);
    Some((first.0, last.0 + last.1))
}

/// Everything that a source delivers, and how it ended.
pub(crate) fn read(path: &Path) -> (Vec<Decoded>, Result<()>) {
    let video = Video::open(path, &Ffmpeg::default()).expect("a video");
    drain(&mut video.start().expect("ffmpeg starts"))
}

pub(crate) fn drain(source: &mut dyn Source) -> (Vec<Decoded>, Result<()>) {
    let mut frames = Vec::new();
    loop {
        match source.next() {
            Ok(Some(frame)) => frames.push(frame),
            Ok(None) => return (frames, Ok(())),
            Err(error) => return (frames, Err(error)),
        }
    }
}

/// Encodes `path` again as it is, at most `most` frames, with its sound.
pub(crate) fn copy(path: &Path, to: &Path, most: usize) -> Vec<String> {
    let video = Video::open(path, &Ffmpeg::default()).expect("a video");
    let info = video.info();
    let mut spec = VideoSpec::of(info, info.size);
    spec.sound = Some(Sound::new(path, Rational::ZERO, false));
    let sink = VideoSink::create(to, spec, &fast()).expect("an encoder");
    let (warnings, mut sink) = (sink.warnings().to_vec(), Box::new(sink));
    let mut source = video.start().expect("ffmpeg starts");
    for _ in 0..most {
        let Some(Decoded { frame, span, .. }) = source.next().expect("a sound video") else {
            break;
        };
        sink.write(Picture { frame, fills: vec![], span }, None).expect("it is encoded");
    }
    sink.finish().expect("it is complete");
    let check = Command::new("ffmpeg")
        .args(["-v", "error", "-i"])
        .arg(to)
        .args(["-f", "null", "-"])
        .output();
    let said = check.expect("ffmpeg runs").stderr;
    assert!(said.is_empty(), "{}", String::from_utf8_lossy(&said));
    warnings
}

pub(crate) fn fast() -> SinkOptions {
    let video =
        VideoOptions { encoder_preset: Some("ultrafast".into()), ..VideoOptions::default() };
    SinkOptions { overwrite: true, video, ..SinkOptions::default() }
}

/// The largest difference between two lists of times.
pub(crate) fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len(), "the same number of frames");
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Fails unless all of `frame` is within `within` of `colour`.
pub(crate) fn assert_flat(frame: &Frame, colour: Rgba, within: u8, of: &str) {
    for pixel in frame.pixels() {
        let off = (0..3).map(|i| pixel[i].abs_diff(colour[i])).max();
        assert!(off <= Some(within), "{of}: {pixel:?} is not {colour:?}");
    }
}

/// Picture number `i` of a video of one colour at 10 frames a second.
pub(crate) fn flat(size: Size, i: i64) -> Picture {
    let frame = Frame::filled(size, [250, 20, 90, 255]).expect("a size");
    let span = Span { start: Rational::new(i, 10), length: Some(Rational::new(1, 10)) };
    Picture { frame, fills: vec![], span }
}

/// A stand-in for ffmpeg.
pub(crate) fn stand_in(dir: &TempDir, script: &str) -> PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let path = dir.path().join("stand-in");
    std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("a script");
    std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).expect("executable");
    path
}
