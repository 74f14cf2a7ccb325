//! Sound with the picture.

use polyreel::ffmpeg::Ffmpeg;
use polyreel::frame::Rational;
use polyreel::sink::Sound;
use polyreel::sink::ffmpeg::{VideoSink, VideoSpec};
use polyreel::sink::{Picture, Sink};
use polyreel::source::Decoded;
use polyreel::source::ffmpeg::Video;
use polyreel::stream::Span;

use crate::given::*;

#[test]
fn sound_is_kept_and_cut_with_the_picture() {
    if !require() {
        return;
    }
    let dir = folder();
    let base = "-f lavfi -i testsrc2=s=64x48:r=25:d=3 -f lavfi -i sine=d=3:r=44100 -c:v libx264 -preset ultrafast";
    for (name, codec, outs) in [
        ("aac.mp4", "aac", ["mp4:aac", "mkv:aac", "webm:opus", "mov:aac"]),
        ("pcm.mov", "pcm_s16le", ["mp4:aac", "mkv:pcm_s16le", "webm:opus", "mov:pcm_s16le"]),
        ("mp3.mkv", "libmp3lame", ["mp4:mp3", "mkv:mp3", "webm:opus", "mov:mp3"]),
        ("opus.mkv", "libopus", ["mp4:opus", "mkv:opus", "webm:opus", "mov:aac"]),
    ] {
        let clip = make(&dir, name, &format!("{base} -c:a {codec}"));
        let (_, wanted) = sound(&clip).expect("sound");
        for out in outs {
            let (extension, codec) = out.split_once(':').expect("two parts");
            let out = dir.path().join(format!("out.{extension}"));
            copy(&clip, &out, usize::MAX);
            assert_eq!(ask(&out, "a:0", "stream=codec_name"), [codec], "{name} {extension}");
            let (start, end) = sound(&out).expect("sound");
            assert!(start.abs() < 0.05 && (end - wanted).abs() < 0.05, "{name}: {start}..{end}");
            assert!(apart(&times(&clip), &times(&out)) <= 0.001, "{name} to {extension}");
            // Stopped after 1 s of 3.
            copy(&clip, &out, 25);
            let (_, end) = sound(&out).expect("sound");
            assert!((end - 1.0).abs() < 0.05, "{name} cut in {extension} ends at {end}");
            let (all, cut) = (times(&clip), times(&out));
            assert!(apart(&all[..25], &cut) <= 0.001, "{name} cut in {extension}: {cut:?}");
        }
    }
    let silent = make(&dir, "silent.mp4", "-f lavfi -i testsrc2=s=64x48:r=25:d=1 -c:v libx264");
    let out = dir.path().join("silent.webm");
    copy(&silent, &out, usize::MAX);
    assert_eq!(sound(&out), None);
}

#[test]
fn sound_of_a_part_starts_with_it() {
    if !require() {
        return;
    }
    let dir = folder();
    // Silence until 1 s, then a tone.
    let clip = make(
        &dir,
        "beep.mp4",
        "-f lavfi -i testsrc2=s=64x48:r=25:d=3 -f lavfi -i aevalsrc='gte(t,1.5)*sin(2000*t):d=3' \
         -c:v libx264 -g 100 -c:a aac",
    );
    for extension in ["mp4", "mkv", "webm"] {
        let out = dir.path().join(format!("part.{extension}"));
        let (frames, _) = read(&clip);
        let info = Video::open(&clip, &Ffmpeg::default()).expect("a video").info().clone();
        let mut spec = VideoSpec::of(&info, info.size);
        let start = Rational::new(1, 1);
        spec.sound = Some(Sound::new(&clip, start, true));
        let mut sink = Box::new(VideoSink::create(&out, spec, &fast()).expect("an encoder"));
        for Decoded { frame, span, .. } in frames.into_iter().skip(25).take(25) {
            let span = Span { start: span.start - start, ..span };
            sink.write(Picture { frame, fills: vec![], span }, None).expect("it is encoded");
        }
        sink.finish().expect("complete");
        let (first, end) = sound(&out).expect("sound");
        assert!(first.abs() < 0.05 && (end - 1.0).abs() < 0.05, "{extension}: {first}..{end}");
        // The tone must begin at 0.5 s.
        let raw = make(&dir, "raw.f32", &format!("-i {} -ac 1 -ar 8000 -f f32le", out.display()));
        let bytes = std::fs::read(raw).expect("samples");
        let loud = bytes
            .chunks_exact(4)
            .position(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]).abs() > 0.2);
        let at = loud.expect("a tone") as f64 / 8000.0;
        assert!((at - 0.5).abs() < 0.05, "{extension}: the tone begins at {at}");
    }
}
