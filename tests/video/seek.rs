//! A video that is entered far in gives what is left of it.

use std::path::{Path, PathBuf};

use polyreel::frame::Rational;
use polyreel::source::ffmpeg::Video;
use polyreel::source::{self, Source, SourceOptions};
use tempfile::TempDir;

use crate::given::{drain, folder, make, read, require, stand_in};

/// Twenty seconds whose key frames, one in two seconds, come before frames that are shown before them.
const SCENE: &str = "-f lavfi -i testsrc2=s=64x48:r=10:d=20";
const CODEC: &str = "-c:v libx264 -preset veryfast -x264-params open-gop=1:keyint=20:bframes=3";

/// An ffmpeg that takes down in `asked` what it is asked for.
fn telling(dir: &TempDir) -> (PathBuf, PathBuf) {
    let asked = dir.path().join("asked");
    let script = format!("echo \"$*\" >> '{}'\nexec ffmpeg \"$@\"", asked.display());
    (stand_in(dir, &script), asked)
}

/// Enters `clip` at thousandths of seconds `from`, and compares. Returns where ffmpeg was asked to begin, each time
/// that it was started to decode.
fn entered(clip: &Path, from: i64, (ffmpeg, asked): &(PathBuf, PathBuf)) -> Vec<Option<String>> {
    let _ = std::fs::remove_file(asked);
    let from = Rational::new(from, 1000);
    let video = Video::open(clip, &ffmpeg.clone().into()).expect("a video");
    let mut source = video.start().expect("ffmpeg starts");
    source.skip_to(from);
    let (frames, end) = drain(&mut source);
    end.expect("all is well");
    let (whole, _) = read(clip);
    let wanted: Vec<_> = whole.into_iter().filter(|frame| frame.span.start >= from).collect();
    assert!(frames == wanted, "{}: {} of {}", clip.display(), frames.len(), wanted.len());
    let begin = |line: &str| {
        let mut words = line.split(' ').skip_while(|word| *word != "-ss");
        words.nth(1).map(str::to_owned)
    };
    // A decoder that was let go at once may not have come to write.
    let told = std::fs::read_to_string(asked).expect("it was started");
    told.lines().map(begin).filter(|begin| begin.is_some() || told.lines().count() == 1).collect()
}

#[test]
fn frames_far_in_are_those_of_the_whole() {
    if !require() {
        return;
    }
    let dir = folder();
    let ffmpeg = telling(&dir);
    for (name, args) in [
        ("in.mp4", String::new()),
        ("in.mkv", String::new()),
        ("late.mkv", "-output_ts_offset 0.7".into()),
        ("late.mp4", "-output_ts_offset 0.7".into()),
        ("uneven.mkv", "-vf select='not(mod(n\\,3))+gt(n\\,150)' -fps_mode vfr".into()),
    ] {
        let clip = make(&dir, name, &format!("{SCENE} {CODEC} {args}"));
        assert_eq!(entered(&clip, 12_340, &ffmpeg), [Some("9".into())], "{name}");
        assert_eq!(entered(&clip, 19_500, &ffmpeg), [Some("16".into())], "{name}");
        assert_eq!(entered(&clip, 5_000, &ffmpeg), [None], "{name}: not far");
    }
    let stream = make(&dir, "in.ts", &format!("{SCENE} {CODEC}"));
    assert_eq!(entered(&stream, 12_340, &ffmpeg), [None], "it has no index");
}

#[test]
fn a_part_far_in_is_entered_at_once() {
    if !require() {
        return;
    }
    let dir = folder();
    let (ffmpeg, asked) = telling(&dir);
    let clip = make(&dir, "in.mp4", &format!("{SCENE} {CODEC}"));
    let start = Rational::new(15, 1);
    let options =
        SourceOptions { start: Some(start), ffmpeg: ffmpeg.into(), ..SourceOptions::default() };
    let input = source::open(&[clip.to_string_lossy().into_owned()], &options).expect("a video");
    let (frames, end) = drain(&mut *input.start().expect("ffmpeg starts"));
    end.expect("all is well");
    assert_eq!((frames.len(), frames[0].span.start), (50, Rational::ZERO));
    let told = std::fs::read_to_string(asked).expect("it was started");
    assert!(told.lines().count() == 1 && told.contains("-ss 12 "), "{told}");
}

#[test]
fn where_no_frame_comes_before_it_begins_at_the_beginning() {
    if !require() {
        return;
    }
    let dir = folder();
    let ffmpeg = telling(&dir);
    let held = "-vf select='lt(t\\,2)+gt(t\\,13)' -fps_mode vfr";
    let clip = make(&dir, "held.mkv", &format!("{SCENE} {CODEC} {held}"));
    for from in [12_000, 25_000] {
        let begun = entered(&clip, from, &ffmpeg);
        assert!(begun.len() == 1 && begun[0].is_some(), "{begun:?}");
        let told = std::fs::read_to_string(&ffmpeg.1).expect("as before");
        assert!(told.lines().last().is_some_and(|line| !line.contains("-ss ")), "{told}");
    }
}
