//! Colours, sizes, and y4m against ffmpeg's own.

use std::path::Path;

use polyreel::colour::Sampling;
use polyreel::frame::Rational;
use polyreel::geom::Size;
use polyreel::sink::ffmpeg::{VideoSink, VideoSpec};
use polyreel::sink::y4m::Y4mSink;
use polyreel::sink::{Picture, Sink};
use polyreel::source::Decoded;
use polyreel::source::y4m::Y4mSource;

use crate::given::*;

/// The codes of Y, Cb and Cr for a colour, where red and blue weigh as `weights` say and the largest code is `most`.
fn codes(rgb: [u8; 4], weights: (f64, f64), full: bool, most: f64) -> [u32; 3] {
    let [r, g, b, _] = rgb.map(|channel| f64::from(channel) / 255.0);
    let (red, blue) = weights;
    let y = red * r + (1.0 - red - blue) * g + blue * b;
    let chroma = [(b - y) / (2.0 - 2.0 * blue), (r - y) / (2.0 - 2.0 * red)];
    // Limited range: 16 to 235 and 16 to 240 of 8 bits, shifted for more.
    let unit = (most + 1.0) / 256.0;
    let luma = if full { y * most } else { (16.0 + 219.0 * y) * unit };
    let [u, v] = chroma.map(|c| 128.0 * unit + c * if full { most } else { 224.0 * unit });
    [luma, u, v].map(|code| code.round() as u32)
}

#[test]
fn flat_colours_come_back_within_two_whatever_the_tags() {
    if !require() {
        return;
    }
    let dir = folder();
    // Weights of red and blue: BT.709, BT.601 and BT.2020.
    let matrices =
        [("bt709", 0.2126, 0.0722), ("smpte170m", 0.299, 0.114), ("bt2020nc", 0.2627, 0.0593)];
    for (tag, red, blue) in matrices {
        for range in ["tv", "pc"] {
            for format in ["yuv420p", "yuv444p", "yuv420p10le"] {
                let rgb = [200u8, 60, 30, 255];
                let ten = format.ends_with("10le");
                // By formula: ffmpeg 9's own conversion is off by 1.5 of 255 in luma.
                let [y, u, v] =
                    codes(rgb, (red, blue), range == "pc", if ten { 1023.0 } else { 255.0 });
                let args = format!(
                    "-f lavfi -i color=black:s=96x64:r=10:d=0.5 -vf \
                     format={format},geq=lum={y}:cb={u}:cr={v},setparams=colorspace={tag}:range={range} \
                     -c:v libx264 -qp 1 -colorspace {tag} -color_range {range}"
                );
                let of = format!("{tag} {range} {format}");
                let clip = make(&dir, "colour.mp4", &args);
                let (frames, end) = read(&clip);
                end.expect(&of);
                assert_flat(&frames[2].frame, rgb, 2, &of);
                let out = dir.path().join("again.mp4");
                copy(&clip, &out, usize::MAX);
                assert_eq!(ask(&out, "v:0", "stream=color_space"), [tag], "{of}");
                assert_eq!(ask(&out, "v:0", "stream=color_range"), [range], "{of}");
                assert_flat(&read(&out).0[2].frame, rgb, 2, &format!("{of}, twice"));
            }
        }
    }
}

#[test]
fn untagged_colour_stays_untagged_and_looks_the_same() {
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
        alpha: false,
        sound: None,
    };
    let mut sink = Box::new(VideoSink::create(&out, spec, &fast()).expect("an encoder"));
    for i in 0..5 {
        sink.write(flat(Size::new(64, 64), i), None).expect("encoded");
    }
    sink.finish().expect("complete");
    assert_eq!(ask(&out, "v:0", "stream=color_space,color_primaries"), ["bt709,bt709"]);
    let (frames, end) = read(&out);
    end.expect("a sound video");
    assert_flat(&frames[4].frame, [250, 20, 90, 255], 2, "tagged");
}

/// Copies the MP4 `from` to `to`, to be shown turned right by 90 degrees: the matrix of its track's header says so.
/// ffmpeg 5.1 has another option for it than 9.
fn turn(from: &Path, to: &Path) {
    let mut bytes = std::fs::read(from).expect("the clip");
    let header = bytes.windows(4).position(|name| name == b"tkhd").expect("a track's header");
    // Version 0: after the name 40 bytes to the matrix, which begins with a, b, u, c, d.
    let one = 0x1_0000_i32;
    let height = i32::from_be_bytes(bytes[header + 84..][..4].try_into().expect("four bytes"));
    for (i, value) in [0, one, 0, -one, 0, 0, height, 0].into_iter().enumerate() {
        bytes[header + 44 + 4 * i..][..4].copy_from_slice(&value.to_be_bytes());
    }
    std::fs::write(to, bytes).expect("the turned clip");
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
    let turned = dir.path().join("turned.mp4");
    turn(&plain, &turned);
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
        let mut source = Y4mSource::new(file, &clip).expect("a header");
        let info = source.info().clone();
        assert_eq!((info.size, info.rate), (Size::new(66, 48), Some(Rational::new(30000, 1001))));
        let (frames, end) = drain(&mut source);
        end.expect(format);
        assert_eq!(frames.len(), 6);
        assert_flat(&frames[5].frame, colour, 2, format);
        let out = dir.path().join("out.y4m");
        let file = std::fs::File::create(&out).expect("a file");
        let mut sink =
            Box::new(Y4mSink::new(file, &out, &info, info.size, sampling).expect("a sink"));
        for Decoded { frame, span, .. } in frames {
            sink.write(Picture { frame, fills: vec![], span }, None).expect("written");
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
