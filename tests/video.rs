//! Video in and out through a real ffmpeg, and through stand-ins that misbehave.
//!
//! Needs ffmpeg and ffprobe: without them tests are skipped, loudly, or fail if `REQUIRE_FFMPEG=1`.

#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::Command;

use polyreel::colour::Sampling;
use polyreel::error::{Error, Result};
use polyreel::frame::{Colorimetry, Frame, Rational, Rgba, Span};
use polyreel::geom::Size;
use polyreel::sink::ffmpeg::{VideoOptions, VideoSink, VideoSpec};
use polyreel::sink::sound::Sound;
use polyreel::sink::y4m::Y4mSink;
use polyreel::sink::{Picture, Sink, SinkOptions};
use polyreel::source::ffmpeg::Video;
use polyreel::source::y4m::Y4mSource;
use polyreel::source::{Decoded, Source};
use tempfile::TempDir;

/// Whether there is an ffmpeg to test with.
fn require() -> bool {
    let there = Command::new("ffmpeg").arg("-version").output().is_ok()
        && Command::new("ffprobe").arg("-version").output().is_ok();
    if !there {
        assert_ne!(std::env::var("REQUIRE_FFMPEG").as_deref(), Ok("1"), "ffmpeg is missing");
        eprintln!("SKIPPED: this test needs ffmpeg and ffprobe");
    }
    there
}

/// A folder for a test's files.
fn folder() -> TempDir {
    TempDir::new().expect("a temporary folder")
}

/// Runs ffmpeg with the words of `args`, then the file.
fn make(folder: &TempDir, name: &str, args: &str) -> PathBuf {
    let path = folder.path().join(name);
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-nostdin", "-y"]).args(args.split_whitespace()).arg(&path);
    let output = command.output().expect("ffmpeg runs");
    assert!(output.status.success(), "{args}: {}", String::from_utf8_lossy(&output.stderr));
    path
}

/// What ffprobe says for `entries`, a line each.
fn ask(path: &Path, select: &str, entries: &str) -> Vec<String> {
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
fn times(path: &Path) -> Vec<f64> {
    let lines = ask(path, "v:0", "frame=pts_time");
    lines.iter().map(|line| line.parse().expect("a time")).collect()
}

/// Seconds of sound that come out when it is decoded, and when it begins.
fn sound(path: &Path) -> Option<(f64, f64)> {
    let mut frames = ask(path, "a:0", "frame=pts_time,pkt_duration_time").into_iter().map(|line| {
        let mut parts = line.split(',').map(|part| part.parse::<f64>().unwrap_or(0.0));
        (parts.next().unwrap_or(0.0), parts.next().unwrap_or(0.0))
    });
    let first = frames.next()?;
    let last = frames.next_back().unwrap_or(first);
    Some((first.0, last.0 + last.1))
}

/// Everything that a source delivers, and how it ended.
fn read(path: &Path) -> (Vec<Decoded>, Result<()>) {
    let video = Video::open(path, None).expect("a video");
    drain(video.start().expect("ffmpeg starts"))
}

fn drain(mut source: impl Source) -> (Vec<Decoded>, Result<()>) {
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
fn copy(path: &Path, to: &Path, most: usize) -> Vec<String> {
    let video = Video::open(path, None).expect("a video");
    let info = video.info();
    let mut spec = VideoSpec::of(info, info.size);
    spec.sound = Some(Sound { path: path.into(), start: Rational::ZERO, cut: false });
    let sink = VideoSink::create(to, spec, &fast()).expect("an encoder");
    let (warnings, mut sink) = (sink.warnings().to_vec(), Box::new(sink));
    let mut source = video.start().expect("ffmpeg starts");
    for _ in 0..most {
        let Some(Decoded { frame, span }) = source.next().expect("a sound video") else { break };
        sink.write(Picture { frame, fills: vec![], span }).expect("it is encoded");
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

fn fast() -> SinkOptions {
    let video =
        VideoOptions { encoder_preset: Some("ultrafast".into()), ..VideoOptions::default() };
    SinkOptions { overwrite: true, video, ..SinkOptions::default() }
}

/// The largest difference between two lists of times.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len(), "the same number of frames");
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Fails unless all of `frame` is within `within` of `colour`.
fn assert_flat(frame: &Frame, colour: Rgba, within: u8, of: &str) {
    for pixel in frame.pixels() {
        let off = (0..3).map(|i| pixel[i].abs_diff(colour[i])).max();
        assert!(off <= Some(within), "{of}: {pixel:?} is not {colour:?}");
    }
}

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
            format!("{lavfi}:r=30:d=2 -vf select='not(mod(n\\,3))+lt(n\\,9)' -vsync vfr {x264}"),
        ),
        (
            "vfr.mp4",
            format!("{lavfi}:r=50:d=1 -vf select='not(mod(n\\,7))+gt(n\\,30)' -vsync vfr {x264}"),
        ),
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
        let spec = VideoSpec { size, rate, duration: None, colour: None, sound: None };
        let video = VideoOptions { codec: Some(codec.into()), ..VideoOptions::default() };
        let options = SinkOptions { overwrite: true, video, ..SinkOptions::default() };
        let mut sink = Box::new(VideoSink::create(&out, spec, &options).expect(codec));
        (0..5).for_each(|i| sink.write(flat(size, i)).expect(codec));
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
            sound: None,
        };
        let mut sink =
            Box::new(VideoSink::create(&out, spec, &SinkOptions::default()).expect("it starts"));
        for i in 0..8 {
            let picture = flat(size, i);
            let length = if i == 7 { Rational::new(5, 2) } else { Rational::new(1, 10) };
            let span = Span { length: Some(length), ..picture.span };
            sink.write(Picture { span, ..picture }).expect("encoded");
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
        let info = Video::open(&clip, None).expect("a video").info().clone();
        let mut spec = VideoSpec::of(&info, info.size);
        let start = Rational::new(1, 1);
        spec.sound = Some(Sound { path: clip.clone(), start, cut: true });
        let mut sink = Box::new(VideoSink::create(&out, spec, &fast()).expect("an encoder"));
        for Decoded { frame, span } in frames.into_iter().skip(25).take(25) {
            let span = Span { start: span.start - start, ..span };
            sink.write(Picture { frame, fills: vec![], span }).expect("it is encoded");
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

#[test]
fn flat_colours_come_back_within_two_whatever_the_tags() {
    if !require() {
        return;
    }
    let dir = folder();
    let matrices = [("bt709", "bt709"), ("bt601", "smpte170m"), ("bt2020", "bt2020nc")];
    for (matrix, tag) in matrices {
        for (range, tagged) in [("tv", "tv"), ("pc", "pc")] {
            for (format, codec) in
                [("yuv420p", "libx264"), ("yuv444p", "libx264"), ("yuv420p10le", "libx264")]
            {
                let rgb = [200u8, 60, 30, 255];
                let args = format!(
                    "-f lavfi -i color=c=0xC83C1E:s=96x64:r=10:d=0.5 -vf \
                     format=gbrp,scale=out_color_matrix={matrix}:out_range={range},format={format} \
                     -c:v {codec} -qp 1 -colorspace {tag} -color_range {tagged}"
                );
                let of = format!("{tag} {range} {format}");
                let clip = make(&dir, "colour.mp4", &args);
                let (frames, end) = read(&clip);
                end.expect(&of);
                assert_flat(&frames[2].frame, rgb, 2, &of);
                let out = dir.path().join("again.mp4");
                copy(&clip, &out, usize::MAX);
                assert_eq!(ask(&out, "v:0", "stream=color_space"), [tag], "{of}");
                assert_eq!(ask(&out, "v:0", "stream=color_range"), [tagged], "{of}");
                assert_flat(&read(&out).0[2].frame, rgb, 2, &format!("{of}, twice"));
            }
        }
    }
}

#[test]
fn untold_colour_stays_untold_and_looks_the_same() {
    if !require() {
        return;
    }
    let dir = folder();
    let args = "-f lavfi -i color=c=0x2080D0:s=1280x720:r=5:d=1 -c:v libx264 -preset ultrafast";
    let clip = make(&dir, "untold.mp4", args);
    let out = dir.path().join("out.mp4");
    copy(&clip, &out, usize::MAX);
    assert_eq!(ask(&out, "v:0", "stream=color_space"), ["unknown"]);
    let pixel = |path: &Path| {
        let raw = make(
            &dir,
            "p.rgb",
            &format!("-i {} -frames:v 1 -f rawvideo -pix_fmt rgb24", path.display()),
        );
        std::fs::read(raw).expect("pixels")[..3].to_vec()
    };
    let (a, b) = (pixel(&clip), pixel(&out));
    assert!(a.iter().zip(&b).all(|(a, b)| a.abs_diff(*b) <= 2), "{a:?} {b:?}");
}

#[test]
fn rgb_pictures_become_tagged_video() {
    if !require() {
        return;
    }
    let dir = folder();
    let out = dir.path().join("red.mp4");
    let spec = VideoSpec {
        size: Size::new(64, 64),
        rate: Some(Rational::new(10, 1)),
        duration: None,
        colour: None,
        sound: None,
    };
    let mut sink = Box::new(VideoSink::create(&out, spec, &fast()).expect("an encoder"));
    for i in 0..5 {
        sink.write(flat(Size::new(64, 64), i)).expect("encoded");
    }
    sink.finish().expect("complete");
    assert_eq!(ask(&out, "v:0", "stream=color_space,color_primaries"), ["bt709,bt709"]);
    let (frames, end) = read(&out);
    end.expect("a sound video");
    assert_flat(&frames[4].frame, [250, 20, 90, 255], 2, "tagged");
}

/// Picture number `i` of a video of one colour at 10 frames a second.
fn flat(size: Size, i: i64) -> Picture {
    let frame = Frame::filled(size, [250, 20, 90, 255]).expect("a size");
    let span = Span { start: Rational::new(i, 10), length: Some(Rational::new(1, 10)) };
    Picture { frame, fills: vec![], span }
}

#[test]
fn rotation_aspect_and_odd_sizes() {
    if !require() {
        return;
    }
    let dir = folder();
    // Left half red, right half blue.
    let halves = "-f lavfi -i color=red:s=32x48:r=5:d=1 -f lavfi -i color=blue:s=32x48:r=5:d=1 \
                  -filter_complex hstack -c:v libx264 -pix_fmt yuv444p -qp 1";
    let plain = make(&dir, "plain.mp4", halves);
    let turned = make(
        &dir,
        "turned.mp4",
        &format!("-i {} -c copy -metadata:s:v:0 rotate=90", plain.display()),
    );
    let (frames, end) = read(&turned);
    end.expect("turned");
    assert_eq!(frames[0].frame.size(), Size::new(48, 64));
    let (above, below) = (frames[0].frame.at(24, 8), frames[0].frame.at(24, 56));
    assert!(
        above[0].abs_diff(below[0]) > 200,
        "the halves lie above each other: {above:?} {below:?}"
    );
    let aspect = make(
        &dir,
        "aspect.mkv",
        "-f lavfi -i testsrc2=s=60x48:r=5:d=1 -vf setsar=4/3 -c:v libx264",
    );
    let (frames, end) = read(&aspect);
    end.expect("aspect");
    assert_eq!(frames[0].frame.size(), Size::new(80, 48));

    let odd = make(
        &dir,
        "odd.webm",
        "-f lavfi -i testsrc=s=65x47:r=5:d=1 -pix_fmt yuv420p -c:v libvpx-vp9 -deadline realtime",
    );
    assert_eq!(read(&odd).0[0].frame.size(), Size::new(65, 47));
    let out = dir.path().join("odd.mp4");
    let warnings = copy(&odd, &out, usize::MAX);
    assert!(
        warnings.len() == 1 && warnings[0].contains("66 x 48") || warnings[0].contains("66x48"),
        "{warnings:?}"
    );
    assert_eq!(read(&out).0[0].frame.size(), Size::new(66, 48));
    let out = dir.path().join("again.webm");
    assert!(copy(&odd, &out, usize::MAX).is_empty());
    assert_eq!(read(&out).0[0].frame.size(), Size::new(65, 47));
}

#[test]
fn pixels_are_those_that_ffmpeg_shows() {
    if !require() {
        return;
    }
    let dir = folder();
    for format in ["yuv420p", "yuv422p", "yuv444p", "gbrp", "gray", "yuva444p", "bgra"] {
        let clip = make(
            &dir,
            "clip.mkv",
            &format!("-f lavfi -i testsrc=s=320x240:r=5:d=0.4 -pix_fmt {format} -c:v ffv1"),
        );
        let flags = "accurate_rnd+full_chroma_int";
        let args = format!("-i {} -sws_flags {flags} -f rawvideo -pix_fmt rgba", clip.display());
        let wanted = std::fs::read(make(&dir, "clip.rgba", &args)).expect("pixels");
        let (frames, end) = read(&clip);
        end.expect(format);
        let got: Vec<u8> =
            frames.iter().flat_map(|f| f.frame.pixels().as_flattened().to_vec()).collect();
        assert_eq!(got.len(), wanted.len());
        // ffmpeg interpolates chroma from other places, so that edges may differ; areas may not.
        let same = got.iter().zip(&wanted).filter(|(a, b)| a.abs_diff(**b) <= 2).count();
        assert!(same * 100 > got.len() * 94, "{format}: {same} of {}", got.len());
    }
}

#[test]
fn y4m_goes_to_and_from_ffmpeg() {
    if !require() {
        return;
    }
    let dir = folder();
    for (format, sampling) in [
        ("yuv420p", Sampling::Yuv420),
        ("yuv422p", Sampling::Yuv422),
        ("yuv444p", Sampling::Yuv444),
        ("gray", Sampling::Gray),
    ] {
        let colour = if format == "gray" { [128, 128, 128, 255] } else { [200, 60, 30, 255] };
        let [r, g, b, _] = colour;
        let args = format!(
            "-f lavfi -i color=c=0x{r:02X}{g:02X}{b:02X}:s=66x48:r=30000/1001:d=0.2,format=gbrp \
             -vf scale=out_range=tv:flags=accurate_rnd,format={format} -f yuv4mpegpipe"
        );
        let clip = make(&dir, "in.y4m", &args);
        let file = std::fs::File::open(&clip).expect("a clip");
        let source = Y4mSource::new(file, &clip).expect("a header");
        let info = source.info().clone();
        assert_eq!((info.size, info.rate), (Size::new(66, 48), Some(Rational::new(30000, 1001))));
        let (frames, end) = drain(source);
        end.expect(format);
        assert_eq!(frames.len(), 6);
        assert_flat(&frames[5].frame, colour, 2, format);
        let out = dir.path().join("out.y4m");
        let file = std::fs::File::create(&out).expect("a file");
        let mut sink =
            Box::new(Y4mSink::new(file, &out, &info, info.size, sampling).expect("a sink"));
        for Decoded { frame, span } in frames {
            sink.write(Picture { frame, fills: vec![], span }).expect("written");
        }
        sink.finish().expect("complete");
        assert_eq!(
            ask(&out, "v:0", "stream=pix_fmt,r_frame_rate"),
            [format!("{format},30000/1001")]
        );
        let (frames, end) = read(&out);
        end.expect(format);
        assert_flat(&frames[5].frame, colour, 2, &format!("{format} through ffmpeg"));
    }
}

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
        let error = end.expect_err(name).to_string();
        assert!(
            error.contains(name) && error.contains(&format!("frame {}", frames.len())),
            "{error}"
        );
        assert!(error.contains("partial file") || error.contains("ended prematurely"), "{error}");
    }
    let clip = make(&dir, "d.mp4", base);
    let bytes = std::fs::read(&clip).expect("the clip");
    std::fs::write(&clip, &bytes[..bytes.len() / 2]).expect("shorter");
    let error = Video::open(&clip, None).expect_err("no tables").to_string();
    assert!(error.contains("moov atom not found"), "{error}");
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
}

#[test]
fn what_is_no_video_is_refused_with_ffmpegs_words() {
    if !require() {
        return;
    }
    let dir = folder();
    let sound = make(&dir, "sound.wav", "-f lavfi -i sine=d=0.2");
    let said = Video::open(&sound, None).expect_err("only sound").to_string();
    assert!(said.contains("no video"), "{said}");
    let text = dir.path().join("-text.mp4");
    std::fs::write(&text, "hello").expect("a file");
    let said = Video::open(&text, None).expect_err("text").to_string();
    assert!(said.contains("Invalid data") || said.contains("moov"), "{said}");
}

/// A stand-in for ffmpeg.
fn stand_in(dir: &TempDir, script: &str) -> PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let path = dir.path().join("stand-in");
    std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("a script");
    std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).expect("executable");
    path
}

/// Encodes until something goes wrong; what went wrong. Nothing may be left of the output.
fn encode_with(dir: &TempDir, ffmpeg: PathBuf, ffmpeg_args: &[&str]) -> Error {
    let size = Size::new(320, 240);
    let out = dir.path().join("out.mp4");
    let spec = VideoSpec {
        size,
        rate: Some(Rational::new(10, 1)),
        duration: None,
        colour: Some(Colorimetry::default()),
        sound: None,
    };
    let mut options = fast();
    options.video.ffmpeg = Some(ffmpeg);
    options.video.ffmpeg_args = ffmpeg_args.iter().map(|arg| (*arg).to_string()).collect();
    let mut sink = Box::new(VideoSink::create(&out, spec, &options).expect("it starts"));
    let written = (0..200).try_for_each(|i| sink.write(flat(size, i)));
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
        let video = Video::open(&clip, Some(&ffmpeg)).expect("probed by the real ffprobe");
        drain(video.start().expect("it starts"))
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
    let video = Video::open(&clip, Some(&ffmpeg)).expect("a video");
    let mut source = video.start().expect("it starts");
    source.next().expect("a frame").expect("a frame");
    let pid = std::fs::read_to_string(dir.path().join("pid")).expect("it has started");
    drop(source);
    let there = Path::new("/proc").join(pid.trim()).exists();
    assert!(!there || !Path::new("/proc/self").exists(), "process {pid} is left");
}
