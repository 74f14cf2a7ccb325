//! A decoder that is started before the headers are known gives what the right one gives.

use std::path::{Path, PathBuf};

use polyreel::source::{self, Decoded, SourceOptions};

use crate::given::{drain, folder, make, require};

/// The frames of `path`, and how they ended, in words.
fn read(path: &Path, soon: bool) -> (Vec<Decoded>, Option<String>) {
    let options = SourceOptions { soon, ..SourceOptions::default() };
    let input = source::open(&[path.to_string_lossy().into_owned()], &options).expect("a video");
    let (frames, end) = drain(&mut *input.start().expect("ffmpeg starts"));
    (frames, end.err().map(|error| error.to_string()))
}

fn assert_same(path: &Path) -> Vec<Decoded> {
    let (now, later) = (read(path, true), read(path, false));
    assert!(now == later, "{}: {} and {} frames", path.display(), now.0.len(), later.0.len());
    now.0
}

#[test]
fn frames_and_times_are_the_same() {
    if !require() {
        return;
    }
    let dir = folder();
    let scene = "-f lavfi -i testsrc=s=66x50:r=24000/1001:d=0.5";
    for (name, args) in [
        ("plain.mp4", "-pix_fmt yuv420p"),
        ("full.mp4", "-pix_fmt yuvj420p"),
        ("fine.mkv", "-pix_fmt yuv422p10le -c:v ffv1"),
        ("colours.mov", "-pix_fmt rgb24 -c:v qtrle"),
        ("wide.mp4", "-pix_fmt yuv420p -vf setsar=4/3"),
        ("late.mkv", "-pix_fmt yuv420p -output_ts_offset 0.7"),
        ("films.mkv", "-map 0:v -map 0:v -pix_fmt yuv420p"),
    ] {
        let frames = assert_same(&make(&dir, name, &format!("{scene} {args}")));
        assert_eq!(frames.len(), 12, "{name}");
    }
    let plain = dir.path().join("plain.mp4");
    // Newer ffmpegs do not turn it: then it is one more that is as it is.
    let turned = format!("-i {} -c copy -metadata:s:v rotate=90", plain.display());
    assert_same(&make(&dir, "turned.mp4", &turned));
}

#[test]
fn a_size_that_changes_on_the_way_is_the_first_ones() {
    if !require() {
        return;
    }
    let dir = folder();
    let part = |name: &str, size: &str| -> PathBuf {
        make(&dir, name, &format!("-f lavfi -i testsrc=s={size}:r=10:d=0.6 -pix_fmt yuv420p"))
    };
    let list = [part("large.ts", "96x64"), part("small.ts", "48x32")];
    let list = list.map(|path| format!("file '{}'\n", path.display())).concat();
    std::fs::write(dir.path().join("list.txt"), list).expect("a list");
    let list = dir.path().join("list.txt");
    let both = make(&dir, "both.mkv", &format!("-f concat -safe 0 -i {} -c copy", list.display()));
    let frames = assert_same(&both);
    assert!(frames.len() > 8, "{} frames", frames.len());
    assert!(frames.iter().all(|frame| frame.frame.size().width == 96));
}

#[test]
fn what_is_broken_ends_the_same_way() {
    if !require() {
        return;
    }
    let dir = folder();
    let scene = "-f lavfi -i testsrc=s=96x64:r=10:d=3 -pix_fmt yuv420p";
    let whole = make(&dir, "whole.mkv", scene);
    let bytes = std::fs::read(&whole).expect("it is there");
    let half = dir.path().join("half.mkv");
    std::fs::write(&half, &bytes[..bytes.len() / 2]).expect("half of it");
    assert_same(&half);
}
