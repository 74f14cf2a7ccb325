//! Inputs that break off or are none.

use polyreel::error::Error;
use polyreel::ffmpeg::{Ffmpeg, FfmpegError};
use polyreel::source::ffmpeg::Video;

use crate::given::*;

#[test]
fn truncated_videos_deliver_and_then_fail() {
    if !require() {
        return;
    }
    let dir = folder();
    let base = "-f lavfi -i testsrc2=s=160x120:r=25:d=4 -c:v libx264 -preset ultrafast -g 25";
    for (name, more) in
        [("a.mp4", "-movflags +faststart"), ("b.mkv", ""), ("c.webm", "-c:v libvpx -b:v 1M")]
    {
        let clip = make(&dir, name, &format!("{base} {more}"));
        let bytes = std::fs::read(&clip).expect("the clip");
        std::fs::write(&clip, &bytes[..bytes.len() * 6 / 10]).expect("shorter");
        let (frames, end) = read(&clip);
        assert!((30..90).contains(&frames.len()), "{name}: {}", frames.len());
        let error = end.expect_err(name);
        assert!(error.is_truncation(), "{error}: {error:?}");
        let cause = std::error::Error::source(&error).expect("a cause");
        assert!(cause.is::<FfmpegError>(), "{cause:?}");
        let error = error.to_string();
        assert!(
            error.contains(name) && error.contains(&format!("frame {}", frames.len())),
            "{error}"
        );
        assert!(error.contains("partial file") || error.contains("ended prematurely"), "{error}");
    }
    let clip = make(&dir, "d.mp4", base);
    let bytes = std::fs::read(&clip).expect("the clip");
    std::fs::write(&clip, &bytes[..bytes.len() / 2]).expect("shorter");
    let error = Video::open(&clip, &Ffmpeg::default()).expect_err("no tables");
    assert!(error.is_truncation() && error.to_string().contains("moov atom not found"), "{error}");
}

#[test]
fn damaged_videos_do_not_pass_for_good() {
    if !require() {
        return;
    }
    let dir = folder();
    let clip = make(&dir, "a.mkv", "-f lavfi -i testsrc2=s=320x240:r=25:d=4 -c:v libx264 -g 25");
    let mut bytes = std::fs::read(&clip).expect("the clip");
    let middle = bytes.len() / 2;
    for byte in &mut bytes[middle..middle + 2000] {
        *byte ^= 0x5A;
    }
    std::fs::write(&clip, bytes).expect("damaged");
    let (frames, end) = read(&clip);
    assert!(frames.len() > 30);
    assert!(matches!(end, Err(Error::Input { frame: Some(_), .. })), "{end:?}");
    let error = end.expect_err("damaged");
    assert!(error.is_corruption() && error.to_string().contains("is damaged"), "{error}");
}

#[test]
fn what_is_no_video_is_refused_with_ffmpegs_words() {
    if !require() {
        return;
    }
    let dir = folder();
    let sound = make(&dir, "sound.wav", "-f lavfi -i sine=d=0.2");
    let said = Video::open(&sound, &Ffmpeg::default()).expect_err("only sound").to_string();
    assert!(said.contains("no video"), "{said}");
    let text = dir.path().join("-text.mp4");
    std::fs::write(&text, "hello").expect("a file");
    let said = Video::open(&text, &Ffmpeg::default()).expect_err("text").to_string();
    assert!(said.contains("Invalid data") || said.contains("moov"), "{said}");
}
