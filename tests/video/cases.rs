//! Kinds of files that came out wrong once.

use std::path::Path;

use polyreel::frame::Rgba;
use polyreel::geom::Size;
use polyreel::source::{self, SourceOptions};
use tempfile::TempDir;

use crate::given::*;
use crate::program::*;

/// Renders `name` to `output`, which must succeed; what was said.
fn render(dir: &TempDir, name: &str, output: &str) -> String {
    let ended = run(dir, &format!("render {name} -o {output} --points 60"));
    assert!(ended.status.success(), "{name} to {output}: {}", said(&ended));
    said(&ended)
}

/// The duration of `name` as its container has it.
fn duration(dir: &TempDir, name: &str) -> f64 {
    let told = ask(&dir.path().join(name), "", "format=duration");
    told[0].parse().expect("a number")
}

const X264: &str = "-c:v libx264 -preset ultrafast -pix_fmt yuv420p";

#[test]
fn colour_tags_that_options_call_otherwise_come_through() {
    if !require() {
        return;
    }
    let dir = folder();
    let scene = "-f lavfi -i testsrc2=s=64x48:r=10:d=0.3";
    make(
        &dir,
        "pal.mp4",
        // ffmpeg 9 takes tags from frames, not from options.
        &format!(
            "{scene} -vf setparams=color_trc=bt470bg:colorspace=bt470bg:color_primaries=bt470bg {X264} \
             -color_trc gamma28 -colorspace bt470bg -color_primaries bt470bg"
        ),
    );
    make(&dir, "gbr.mp4", &format!("{scene} {X264} -bsf:v h264_metadata=matrix_coefficients=0"));
    render(&dir, "pal.mp4", "out.mp4");
    let tags = ask(&dir.path().join("out.mp4"), "v:0", "stream=color_transfer");
    assert_eq!(tags, ["bt470bg"]);
    render(&dir, "gbr.mp4", "out2.mp4");
}

#[test]
fn matrices_that_the_scaler_of_ffmpeg_refuses_are_read() {
    if !require() {
        return;
    }
    let dir = folder();
    let scene = "-f lavfi -i testsrc2=s=64x48:r=10:d=0.3";
    // Y'CgCo, BT.2020 of constant luminance, SMPTE 2085, derived from primaries, ICtCp.
    for matrix in [8, 10, 11, 12, 13, 14] {
        let tagged = format!("{scene} {X264} -bsf:v h264_metadata=matrix_coefficients={matrix}");
        make(&dir, "in.mp4", &tagged);
        render(&dir, "in.mp4", "out.mp4 -y");
        assert_eq!(ask(&dir.path().join("out.mp4"), "v:0", "stream=nb_frames"), ["3"], "{matrix}");
        render(&dir, "in.mp4", "out.gif -y");
    }
}

#[test]
fn y_cg_co_has_its_colours() {
    if !require() {
        return;
    }
    let dir = folder();
    make(
        &dir,
        "in.mp4",
        "-f lavfi -i color=0xc83c1e:s=64x48:r=10:d=0.2,format=gbrp -vf zscale=matrix=ycgco:range=limited,format=yuv444p \
         -c:v libx264 -crf 5",
    );
    render(&dir, "in.mp4", "out_%d.png");
    let picture = image::open(dir.path().join("out_1.png")).expect("a picture").into_rgb8();
    let [r, g, b] = picture.get_pixel(30, 20).0;
    assert!(r.abs_diff(200) < 4 && g.abs_diff(60) < 4 && b.abs_diff(30) < 4, "{r} {g} {b}");
}

#[test]
fn transparency_is_seen_however_its_tag_is_written() {
    if !require() {
        return;
    }
    let dir = folder();
    make(
        &dir,
        "plain.webm",
        "-f lavfi -i color=red@0.0:s=64x48:r=10:d=0.3,format=yuva420p -c:v libvpx-vp9",
    );
    let plain = dir.path().join("plain.webm");
    make(
        &dir,
        "capitals.webm",
        &format!("-i {} -c copy -metadata:s:v ALPHA_MODE=1", plain.display()),
    );
    for name in ["plain.webm", "capitals.webm"] {
        let ended = run(&dir, &format!("info {name}"));
        let text = String::from_utf8_lossy(&ended.stdout).into_owned();
        let line = text.lines().find(|line| line.contains("alpha")).unwrap_or_default();
        assert!(line.contains("yes"), "{name}: {text}");
    }
}

#[test]
fn a_clock_that_starts_again_goes_on() {
    if !require() {
        return;
    }
    let dir = folder();
    for ending in ["ts", "flv"] {
        let part = format!("part.{ending}");
        let parts = make(
            &dir,
            &part,
            &format!(
                "-f lavfi -i testsrc2=s=64x48:r=25:d=1 -f lavfi -i sine=d=1 {X264} -c:a aac -ar 44100"
            ),
        );
        let bytes = std::fs::read(parts).expect("the part");
        // FLV has one header: tags follow it.
        let again = if ending == "flv" { &bytes[13..] } else { &bytes[..] };
        let name = format!("again.{ending}");
        std::fs::write(dir.path().join(&name), [&bytes, again].concat()).expect("both");
        let output = format!("{ending}.mp4");
        render(&dir, &name, &output);
        let path = dir.path().join(&output);
        let times = times(&path);
        let last = *times.last().expect("frames");
        assert!(
            times.len() >= 48 && (1.9..2.2).contains(&last),
            "{ending}: {} to {last}",
            times.len()
        );
        let (_, end) = sound(&path).expect("sound");
        assert!((1.9..2.3).contains(&end), "{ending}: sound ends at {end}");
    }
}

#[test]
fn a_mean_rate_gives_no_unit_of_time() {
    if !require() {
        return;
    }
    let dir = folder();
    let jitter = "-vf settb=1/1000000,setpts=N*128875+mod(N*7919\\,40000) -fps_mode passthrough \
                  -enc_time_base 1/1000000 -video_track_timescale 1000000";
    make(&dir, "in.mp4", &format!("-f lavfi -i testsrc2=s=64x48:r=8:d=12 {jitter} {X264}"));
    let wanted = times(&dir.path().join("in.mp4"));
    for output in ["out.mp4", "out.mov", "out.mkv"] {
        render(&dir, "in.mp4", output);
        let found = times(&dir.path().join(output));
        assert!(apart(&wanted, &found) <= 0.001, "{output}: {found:?}");
    }
}

#[test]
fn a_film_ends_where_its_last_frame_does() {
    if !require() {
        return;
    }
    let dir = folder();
    let held = "-vf setpts=if(lt(N\\,20)\\,N*0.05/TB\\,(4+(N-20)*0.05)/TB) -fps_mode vfr";
    make(&dir, "late.mkv", &format!("-f lavfi -i testsrc2=s=64x48:r=20:d=1.1 {held} {X264} -bf 2"));
    let first = "-vf setpts=if(eq(N\\,0)\\,0\\,(1+(N-1)*0.05)/TB) -fps_mode vfr";
    make(&dir, "early.mkv", &format!("-f lavfi -i testsrc2=s=64x48:r=20:d=1 {first} {X264} -bf 2"));
    for name in ["late.mkv", "early.mkv"] {
        for output in ["out.mp4", "out.mov"] {
            render(&dir, name, &format!("{name}-{output}"));
            let (wanted, found) =
                (duration(&dir, name), duration(&dir, &format!("{name}-{output}")));
            assert!((wanted - found).abs() < 0.06, "{name} to {output}: {found} s, not {wanted}");
        }
    }
}

#[test]
fn a_rest_before_the_end_does_not_move_the_end() {
    if !require() {
        return;
    }
    let dir = folder();
    let rest = "-frames:v 50 -vf setpts=(N/25+if(gte(N\\,48)\\,3\\,0)+if(gte(N\\,49)\\,0.013\\,0))/TB,settb=1/1000 \
                -fps_mode passthrough -enc_time_base 1:1000 -bf 0 -video_track_timescale 1000";
    make(&dir, "in.mp4", &format!("-f lavfi -i testsrc2=s=64x48:r=25 {rest} {X264}"));
    make(&dir, "in.mkv", &format!("-i {}/in.mp4 -c copy", dir.path().display()));
    let wanted = duration(&dir, "in.mkv");
    for output in ["out.mp4", "out.mov", "out.mkv", "out.webm"] {
        render(&dir, "in.mkv", output);
        let found = duration(&dir, output);
        assert!((wanted - found).abs() < 0.005, "{output}: {found} s, not {wanted}");
    }
}

#[test]
fn gif_delays_of_zero_are_those_of_browsers() {
    if !require() {
        return;
    }
    let dir = folder();
    make(&dir, "timed.gif", "-f lavfi -i testsrc2=s=32x24:r=10:d=0.8");
    let mut bytes = std::fs::read(dir.path().join("timed.gif")).expect("a GIF");
    // Graphic control extensions: their delay is the two bytes after the flags.
    let at: Vec<usize> =
        (0..bytes.len() - 6).filter(|&i| bytes[i..i + 3] == [0x21, 0xF9, 4]).collect();
    assert_eq!(at.len(), 8);
    at.iter().for_each(|&i| bytes[i + 4..i + 6].fill(0));
    std::fs::write(dir.path().join("in.gif"), bytes).expect("a GIF");
    render(&dir, "in.gif", "out.mp4");
    let times = times(&dir.path().join("out.mp4"));
    let wanted: Vec<f64> = (0..8).map(|i| f64::from(i) / 10.0).collect();
    assert!(apart(&wanted, &times) < 0.001, "{times:?}");
    assert!((duration(&dir, "out.mp4") - 0.8).abs() < 0.01);
}

#[test]
fn the_film_is_read_and_not_its_cover() {
    if !require() {
        return;
    }
    let dir = folder();
    make(
        &dir,
        "in.mkv",
        "-f lavfi -i testsrc=s=320x320:d=0.04 -f lavfi -i testsrc2=s=64x48:r=25:d=1 \
             -map 0 -map 1 -c:v:0 mjpeg -c:v:1 libx264 -pix_fmt:v:1 yuv420p",
    );
    render(&dir, "in.mkv", "out.mp4");
    assert_eq!(times(&dir.path().join("out.mp4")).len(), 25);
}

#[test]
fn languages_that_quicktime_calls_otherwise_are_kept() {
    if !require() {
        return;
    }
    let dir = folder();
    make(
        &dir,
        "in.mkv",
        &format!(
            "-f lavfi -i testsrc2=s=64x48:r=10:d=0.3 -f lavfi -i sine=d=0.3 -map 0 -map 1 -map 1 {X264} \
             -metadata:s:a:0 language=deu -metadata:s:a:1 language=nld"
        ),
    );
    for (output, languages) in
        [("out.mov", ["ger", "dut"]), ("out.mp4", ["deu", "nld"]), ("out.mkv", ["deu", "nld"])]
    {
        render(&dir, "in.mkv", output);
        assert_eq!(
            ask(&dir.path().join(output), "a", "stream_tags=language"),
            languages,
            "{output}"
        );
    }
}

#[test]
fn languages_titles_chapters_and_subtitles_are_kept() {
    if !require() {
        return;
    }
    let dir = folder();
    std::fs::write(dir.path().join("s.srt"), "1\n00:00:00,100 --> 00:00:00,900\nhello\n")
        .expect("text");
    let chapters = ";FFMETADATA1\ntitle=My Film\n[CHAPTER]\nTIMEBASE=1/1000\nSTART=0\nEND=500\ntitle=A\n\
                    [CHAPTER]\nTIMEBASE=1/1000\nSTART=500\nEND=1000\ntitle=B\n";
    std::fs::write(dir.path().join("c.txt"), chapters).expect("text");
    let (srt, list) = (dir.path().join("s.srt"), dir.path().join("c.txt"));
    make(
        &dir,
        "in.mkv",
        &format!(
            "-f lavfi -i testsrc2=s=64x48:r=25:d=1 -f lavfi -i sine=d=1 -f lavfi -i sine=f=900:d=1 -i {} -i {} \
             -map 0 -map 1 -map 2 -map 3 -map_metadata 4 -map_chapters 4 {X264} -c:a aac -c:s srt \
             -metadata:s:a:0 language=eng -metadata:s:a:1 language=jpn -metadata:s:a:1 title=Commentary",
            srt.display(),
            list.display()
        ),
    );
    for output in ["out.mkv", "out.mp4", "out.webm"] {
        render(&dir, "in.mkv", output);
        let path = dir.path().join(output);
        assert_eq!(ask(&path, "a", "stream_tags=language"), ["eng", "jpn"], "{output}");
        // In MP4 players take the handler's name for the track's title.
        let titles = ask(&path, "a:1", "stream_tags=title,handler_name");
        assert!(titles.iter().any(|line| line.contains("Commentary")), "{output}: {titles:?}");
        assert_eq!(ask(&path, "s", "stream=codec_type"), ["subtitle"], "{output}");
        assert_eq!(ask(&path, "", "format_tags=title"), ["My Film"], "{output}");
        assert_eq!(ask(&path, "", "chapter_tags=title"), ["A", "B"], "{output}");
    }
}

#[test]
fn hdr_comes_to_pictures_as_sdr() {
    if !require() {
        return;
    }
    let dir = folder();
    // Diffuse white of 203 nits in PQ.
    let white = "color=white:s=64x48:r=10:d=0.2,format=yuv420p10le,geq=lum=573:cb=512:cr=512,\
                 setparams=color_trc=smpte2084:color_primaries=bt2020:colorspace=bt2020nc:range=tv";
    make(
        &dir,
        "in.mp4",
        &format!(
            "-f lavfi -i {white} -c:v libx265 -pix_fmt yuv420p10le -color_trc smpte2084 -color_primaries bt2020 \
             -colorspace bt2020nc -color_range tv -x265-params log-level=error"
        ),
    );
    let said = render(&dir, "in.mp4", "out_%d.png");
    let pixel = image::open(dir.path().join("out_1.png")).expect("a picture").to_rgb8();
    let level = pixel.get_pixel(32, 24).0[1];
    assert!(level > 215 && !said.contains("HDR"), "{level}: {said}");
}

#[test]
fn one_picture_through_ffmpeg_is_one_picture() {
    if !require() {
        return;
    }
    let dir = folder();
    for name in ["in.tga", "in.pcx", "in.jp2"] {
        make(&dir, name, "-f lavfi -i testsrc=s=64x48:d=0.04 -frames:v 1");
        render(&dir, name, &format!("{name}.png"));
        assert!(dir.path().join(format!("{name}.png")).is_file());
    }
}

#[test]
fn a_list_of_other_files_is_not_opened_under_a_false_name() {
    if !require() {
        return;
    }
    let dir = folder();
    let part = make(&dir, "part.ts", &format!("-f lavfi -i testsrc2=s=64x48:r=25:d=1 {X264}"));
    let list = format!(
        "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n{}\n#EXT-X-ENDLIST\n",
        part.display()
    );
    for (name, wanted) in [("in.mp4", 1), ("in.m3u8", 0)] {
        std::fs::write(dir.path().join(name), &list).expect("a list");
        let ended = run(&dir, &format!("render {name} -o {name}.gif --points 60"));
        assert_eq!(ended.status.code(), Some(wanted), "{name}: {}", said(&ended));
        assert_eq!(dir.path().join(format!("{name}.gif")).is_file(), wanted == 0);
    }
}

#[test]
fn options_that_leave_no_frame_are_an_error() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "64x48", 1);
    for options in ["-t 0", "-ss 100", "-h"] {
        let line = ["render", "in.mp4", "-o", "out.mp4", "--ffmpeg-args", options];
        let mut command = polyreel(&dir, "");
        let ended = command.args(line).output().expect("the program");
        assert_eq!(ended.status.code(), Some(1), "{options}: {}", said(&ended));
        assert!(!Path::new(&dir.path().join("out.mp4")).exists(), "{options}");
    }
}

/// The corners of an AVIF of four areas, from the upper left on: red, green, blue, yellow (by libavif). `None` where ffmpeg
/// does not read its transparency, which is said.
fn corners(file: &[u8]) -> Option<(Size, [Rgba; 4])> {
    let dir = folder();
    let path = dir.path().join("in.avif");
    std::fs::write(&path, file).expect("written");
    let input = match source::open(&[&path], &SourceOptions::default()) {
        Ok(input) => input,
        Err(error) => {
            assert!(error.to_string().contains("has transparency that this ffmpeg"), "{error}");
            return None;
        }
    };
    let frame = input.start().expect("a start").next().expect("a picture").expect("one").frame;
    let size = frame.size();
    let (x, y) = (size.width - 4, size.height - 4);
    Some((size, [(3, 3), (x, 3), (3, y), (x, y)].map(|(x, y)| frame.at(x, y))))
}

const OPAQUE: [Rgba; 2] = [[220, 40, 30, 255], [40, 200, 60, 255]];
const HALF: [Rgba; 2] = [[30, 60, 210, 128], [200, 190, 30, 128]];

fn check_corners(file: &[u8], size: Size, wanted: [Rgba; 4]) {
    let Some((own, corners)) = corners(file) else { return };
    assert_eq!(own, size);
    let near = |(a, b): (&Rgba, &Rgba)| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 8);
    assert!(corners.iter().zip(&wanted).all(near), "{corners:?}, not {wanted:?}");
}

#[test]
fn avifs_are_turned_with_their_alpha() {
    if !require() {
        return;
    }
    let ([red, green], [blue, yellow]) = (OPAQUE, HALF);
    let turned = include_bytes!("data/turned-alpha.avif");
    check_corners(turned, Size::new(16, 32), [green, yellow, red, blue]);
    let opaque = |[r, g, b, _]: Rgba| [r, g, b, 255];
    let mirrored = include_bytes!("data/mirrored.avif");
    check_corners(mirrored, Size::new(32, 16), [opaque(blue), opaque(yellow), red, green]);
}

#[test]
fn alpha_of_gray_and_of_premultiplied_avifs_is_kept() {
    if !require() {
        return;
    }
    let ([red, green], [blue, yellow]) = (OPAQUE, HALF);
    let premultiplied = include_bytes!("data/premultiplied.avif");
    check_corners(premultiplied, Size::new(32, 16), [red, green, blue, yellow]);
    let gray = |v, a| [v, v, v, a];
    let wanted = [gray(200, 255), gray(80, 255), gray(200, 128), gray(80, 128)];
    check_corners(include_bytes!("data/gray-alpha.avif"), Size::new(32, 16), wanted);
}

#[test]
fn what_newer_ffmpegs_crop_is_not_stretched() {
    if !require() {
        return;
    }
    // The right half, with ffmpeg 7.1 and later.
    let (size, corners) = corners(include_bytes!("data/cropped.avif")).expect("it is opaque");
    let right_half = size == Size::new(16, 16);
    assert!(right_half || size == Size::new(32, 16), "{size}");
    let wanted = if right_half { OPAQUE[1] } else { OPAQUE[0] };
    assert!(corners[0].iter().zip(wanted).all(|(a, b)| a.abs_diff(b) <= 8), "{corners:?}");
}
