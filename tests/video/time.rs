//! When frames are shown.

use polyreel::frame::Rational;
use polyreel::geom::Size;
use polyreel::sink::ffmpeg::{VideoOptions, VideoSink, VideoSpec};
use polyreel::sink::{Picture, Sink, SinkOptions};
use polyreel::stream::Span;

use crate::given::*;

#[test]
fn times_are_those_of_the_container() {
    if !require() {
        return;
    }
    let dir = folder();
    let x264 = "-c:v libx264 -preset ultrafast -bf 2";
    let lavfi = "-f lavfi -i testsrc2=s=64x48";
    for (name, args) in [
        ("ntsc.mp4", format!("{lavfi}:r=30000/1001:d=1 {x264}")),
        ("ntsc.mkv", format!("{lavfi}:r=24000/1001:d=1 {x264}")),
        (
            "vfr.mkv",
            format!("{lavfi}:r=30:d=2 -vf select='not(mod(n\\,3))+lt(n\\,9)' -fps_mode vfr {x264}"),
        ),
        (
            "vfr.mp4",
            format!(
                "{lavfi}:r=50:d=1 -vf select='not(mod(n\\,7))+gt(n\\,30)' -fps_mode vfr {x264}"
            ),
        ),
        ("late-and-mute.mkv", format!("{lavfi}:r=10:d=1 -vf setpts=PTS+0.4/TB {x264}")),
        ("late.mkv", format!("{lavfi}:r=10:d=1 -f lavfi -i sine=d=2 -vf setpts=PTS+0.4/TB {x264}")),
        ("mpeg.ts", format!("{lavfi}:r=25:d=1 -f lavfi -i sine=d=1 {x264}")),
    ] {
        let clip = make(&dir, name, &args);
        let (frames, end) = read(&clip);
        end.expect(name);
        let origin = ask(&clip, "v:0", "format=start_time")[0].parse::<f64>().expect("a time");
        let origin = if origin.abs() < 1.0 { 0.0 } else { origin };
        let wanted: Vec<f64> = times(&clip).iter().map(|t| t - origin).collect();
        let got: Vec<f64> = frames.iter().map(|f| f.span.start.to_f64()).collect();
        assert!(apart(&wanted, &got) < 2e-5, "{name}: {wanted:?} {got:?}");
        for pair in frames.windows(2) {
            let length = pair[0].span.length.expect("the next is known");
            assert_eq!(pair[0].span.start + length, pair[1].span.start, "{name}");
        }
        assert!(frames.last().and_then(|f| f.span.length) > Some(Rational::ZERO), "{name}");
        for to in ["mp4", "mkv", "webm"] {
            let out = dir.path().join(format!("out.{to}"));
            copy(&clip, &out, usize::MAX);
            assert!(apart(&got, &times(&out)) <= 0.001, "{name} to {to}: {:?}", times(&out));
        }
    }
    let out = dir.path().join("out.mp4");
    copy(&dir.path().join("ntsc.mp4"), &out, usize::MAX);
    assert_eq!(ask(&out, "v:0", "stream=r_frame_rate"), ["30000/1001"]);
}

#[test]
fn codecs_by_name() {
    if !require() {
        return;
    }
    let dir = folder();
    let size = Size::new(64, 48);
    for (codec, name, extension) in [
        ("h265", "hevc", "mp4"),
        ("vp8", "vp8", "webm"),
        ("mpeg4", "mpeg4", "mp4"),
        ("ffv1", "ffv1", "mkv"),
    ] {
        let out = dir.path().join(format!("out.{extension}"));
        let rate = Some(Rational::new(10, 1));
        let spec =
            VideoSpec { size, rate, duration: None, colour: None, alpha: false, sound: None };
        let video = VideoOptions { codec: Some(codec.into()), ..VideoOptions::default() };
        let options = SinkOptions { overwrite: true, video, ..SinkOptions::default() };
        let mut sink = Box::new(VideoSink::create(&out, spec, &options).expect(codec));
        (0..5).for_each(|i| drop(sink.write(flat(size, i), None).expect(codec)));
        sink.finish().expect(codec);
        assert_eq!(ask(&out, "v:0", "stream=codec_name"), [name]);
        assert!(apart(&times(&out), &[0.0, 0.1, 0.2, 0.3, 0.4]) < 0.001, "{codec}");
    }
}

#[test]
fn a_long_last_frame_stays_long() {
    if !require() {
        return;
    }
    let dir = folder();
    let size = Size::new(64, 48);
    for extension in ["mp4", "mkv", "webm", "mov"] {
        let out = dir.path().join(format!("held.{extension}"));
        let spec = VideoSpec {
            size,
            rate: Some(Rational::new(10, 1)),
            duration: None,
            colour: None,
            alpha: false,
            sound: None,
        };
        let mut sink =
            Box::new(VideoSink::create(&out, spec, &SinkOptions::default()).expect("it starts"));
        for i in 0..8 {
            let picture = flat(size, i);
            let length = if i == 7 { Rational::new(5, 2) } else { Rational::new(1, 10) };
            let span = Span { length: Some(length), ..picture.span };
            sink.write(Picture { span, ..picture }, None).expect("encoded");
        }
        sink.finish().expect("complete");
        let length: f64 = ask(&out, "v:0", "format=duration")[0].parse().expect("a time");
        assert!((length - 3.2).abs() < 0.002, "{extension}: {length}");
        let (frames, end) = read(&out);
        end.expect("a sound video");
        let last = frames.last().expect("frames").span;
        assert!((last.start.to_f64() - 0.7).abs() < 0.001, "{extension}: {last:?}");
        let length = last.length.expect("known").to_f64();
        assert!((length - 2.5).abs() < 0.002, "{extension}: {length}");
    }
}
