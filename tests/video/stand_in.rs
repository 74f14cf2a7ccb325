//! Programs in ffmpeg's place that misbehave.

use std::path::{Path, PathBuf};

use polyreel::error::Error;
use polyreel::frame::{Colorimetry, Rational};
use polyreel::geom::Size;
use polyreel::sink::Sink;
use polyreel::sink::ffmpeg::{VideoSink, VideoSpec};
use polyreel::source::Source;
use polyreel::source::ffmpeg::Video;
use tempfile::TempDir;

use crate::given::*;

const SIZE: Size = Size::new(320, 240);

/// An encoder to `out.mp4`.
fn encoder(dir: &TempDir, ffmpeg: PathBuf, ffmpeg_args: &[&str]) -> Box<VideoSink> {
    let spec = VideoSpec {
        size: SIZE,
        rate: Some(Rational::new(10, 1)),
        duration: None,
        colour: Some(Colorimetry::default()),
        alpha: false,
        sound: None,
    };
    let mut options = fast();
    options.video.ffmpeg = ffmpeg.into();
    options.video.ffmpeg_args = ffmpeg_args.iter().map(|arg| (*arg).to_string()).collect();
    options.video.gives_way = true;
    let out = dir.path().join("out.mp4");
    Box::new(VideoSink::create(&out, spec, &options).expect("it starts"))
}

/// Encodes until something goes wrong; what went wrong. Nothing may be left of the output.
fn encode_with(dir: &TempDir, ffmpeg: PathBuf, ffmpeg_args: &[&str]) -> Error {
    let mut sink = encoder(dir, ffmpeg, ffmpeg_args);
    let written = (0..200).try_for_each(|i| sink.write(flat(SIZE, i), None).map(drop));
    let error = match written {
        Ok(()) => sink.finish().expect_err("it cannot succeed"),
        Err(error) => {
            drop(sink);
            error
        }
    };
    let left: Vec<_> = std::fs::read_dir(dir.path())
        .expect("the folder")
        .flatten()
        .map(|e| e.file_name())
        .collect();
    assert!(left.iter().all(|name| name == "stand-in"), "left behind: {left:?}");
    error
}

/// Without that it takes turns with the frames that it waits for.
#[cfg(target_os = "linux")]
#[test]
fn the_encoder_gives_way() {
    let dir = folder();
    let told = dir.path().join("nice");
    // Begun before it is made nicer; what it begins later is as nice.
    let script = format!("cat >/dev/null; nice >'{}'; exit 1", told.display());
    let mut sink = encoder(&dir, stand_in(&dir, &script), &[]);
    sink.write(flat(SIZE, 0), None).expect("it reads");
    sink.finish().expect_err("it writes nothing");
    let ours = std::process::Command::new("nice").output().expect("coreutils").stdout;
    let nice = |text: &str| text.trim().parse::<i32>().expect("a number");
    let theirs = nice(&std::fs::read_to_string(told).expect("it said it"));
    assert_eq!(theirs, (nice(&String::from_utf8_lossy(&ours)) + 10).min(19));
}

#[test]
fn an_encoder_that_dies_is_told_with_its_last_words() {
    let dir = folder();
    let script = "head -c 1300000 >/dev/null; echo 'frame 10: I give up' >&2; exit 1";
    let error = encode_with(&dir, stand_in(&dir, script), &[]).to_string();
    assert!(error.contains("I give up") && error.contains("exit status: 1"), "{error}");
}

#[test]
fn an_encoder_that_is_killed_is_told() {
    let dir = folder();
    let script = "head -c 1300000 >/dev/null; kill -9 $$";
    let error = encode_with(&dir, stand_in(&dir, script), &[]).to_string();
    assert!(error.contains("signal: 9"), "{error}");
}

#[test]
fn an_encoder_that_stops_reading_is_ended() {
    let dir = folder();
    // The sleeper is a grandchild that holds the pipe open: it must be ended too.
    let error =
        encode_with(&dir, stand_in(&dir, "head -c 1300000 >/dev/null; sleep 1000; exit 0"), &[]);
    assert!(error.to_string().contains("stopped working"), "{error}");
}

#[test]
fn an_encoder_that_never_ends_is_ended() {
    let dir = folder();
    let error = encode_with(&dir, stand_in(&dir, "cat >/dev/null; sleep 1000; exit 0"), &[]);
    assert!(error.to_string().contains("stopped working"), "{error}");
}

#[test]
fn an_encoder_that_floods_its_stderr_is_drained() {
    let dir = folder();
    let script = "yes 'a lot of words' | head -c 20000000 >&2; head -c 1300000 >/dev/null; \
                  yes x | head -c 5000000 | tr -d '\\n' >&2; echo >&2; echo 'the last word' >&2; exit 3";
    let error = encode_with(&dir, stand_in(&dir, script), &[]).to_string();
    assert!(error.contains("the last word") && error.len() < 3000, "{error}");
}

#[test]
fn an_encoder_is_out_of_reach_of_the_terminals_ctrl_c() {
    if !Path::new("/proc/self/stat").exists() {
        return;
    }
    let dir = folder();
    // Its process group is its own number.
    let script = "cut -d' ' -f1,5 /proc/$$/stat >&2; exit 1";
    let error = encode_with(&dir, stand_in(&dir, script), &[]).to_string();
    let mut numbers = error.split_whitespace().filter_map(|word| word.parse::<u32>().ok());
    let (pid, group) = (numbers.next(), numbers.next());
    assert!(pid.is_some() && pid == group, "{error}");
}

#[test]
fn options_that_ffmpeg_refuses_are_told_in_its_words() {
    if !require() {
        return;
    }
    let dir = folder();
    let error = encode_with(&dir, "ffmpeg".into(), &["-no_such_option", "1"]).to_string();
    assert!(error.contains("no_such_option"), "{error}");
}

#[test]
fn a_decoder_that_hangs_is_ended_and_one_that_fails_is_told() {
    if !require() {
        return;
    }
    let dir = folder();
    let clip = make(&dir, "clip.mp4", "-f lavfi -i testsrc2=s=64x48:r=25:d=1 -c:v libx264");
    let run = |script: &str| {
        let ffmpeg = stand_in(&dir, script);
        let video = Video::open(&clip, &ffmpeg.into()).expect("probed by the real ffprobe");
        drain(&mut video.start().expect("it starts"))
    };
    let (frames, end) = run("sleep 1000; exit 0");
    assert!(frames.is_empty() && end.expect_err("hung").to_string().contains("stopped working"));
    // Ten frames and a bit, then death.
    let (frames, end) =
        run("ffmpeg \"$@\" 2>/dev/null | head -c 48000; echo 'no more' >&2; exit 1");
    let error = end.expect_err("failed").to_string();
    assert_eq!(frames.len(), 10, "{error}");
    assert!(error.contains("no more") && error.contains("frame 10"), "{error}");
    let (frames, end) = run("yes | head -c 20000000 >&2; exec ffmpeg \"$@\"");
    end.expect("only talkative");
    assert_eq!(frames.len(), 25);
}

#[test]
fn a_source_dropped_early_leaves_no_process() {
    if !require() {
        return;
    }
    let dir = folder();
    let ffmpeg =
        stand_in(&dir, &format!("echo $$ > {}/pid; ffmpeg \"$@\"; exit $?", dir.path().display()));
    let clip = make(
        &dir,
        "clip.mp4",
        "-f lavfi -i testsrc2=s=320x240:r=25:d=10 -c:v libx264 -preset ultrafast",
    );
    let video = Video::open(&clip, &ffmpeg.into()).expect("a video");
    let mut source = video.start().expect("it starts");
    source.next().expect("a frame").expect("a frame");
    let pid = std::fs::read_to_string(dir.path().join("pid")).expect("it has started");
    drop(source);
    let there = Path::new("/proc").join(pid.trim()).exists();
    assert!(!there || !Path::new("/proc/self").exists(), "process {pid} is left");
}
