//! The whole program on video.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

use crate::given::*;

/// `polyreel` with the words of `line`, in `dir`.
pub(crate) fn polyreel(dir: &TempDir, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_polyreel"));
    command.current_dir(dir.path()).args(line.split_whitespace());
    command
}

/// Runs it to its end.
pub(crate) fn run(dir: &TempDir, line: &str) -> Output {
    polyreel(dir, line).stdin(Stdio::null()).output().expect("the program")
}

/// The same, where it must succeed; what it said.
fn done(dir: &TempDir, line: &str) -> String {
    let output = run(dir, line);
    let said = said(&output);
    assert!(output.status.success(), "{line}: {said}");
    assert!(output.stdout.is_empty(), "standard output is for frames");
    said
}

pub(crate) fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Fails unless ffmpeg decodes all of `path` without a word.
pub(crate) fn assert_sound(path: &Path) {
    let mut check = Command::new("ffmpeg");
    check.args(["-v", "error", "-i"]).arg(path).args(["-f", "null", "-"]);
    let words = said(&check.output().expect("ffmpeg runs"));
    assert!(words.is_empty(), "{}: {words}", path.display());
}

/// Files in `dir`, sorted.
pub(crate) fn listing(dir: &TempDir) -> Vec<String> {
    let entries = fs::read_dir(dir.path()).expect("the folder").flatten();
    let mut names: Vec<_> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// 25 frames a second and a tone, `length` seconds of both.
pub(crate) fn clip(dir: &TempDir, name: &str, size: &str, length: u32) {
    let picture = format!("-f lavfi -i testsrc2=s={size}:r=25:d={length}");
    let sound = format!("-f lavfi -i sine=d={length}");
    make(dir, name, &format!("{picture} {sound} -c:v libx264 -preset ultrafast -bf 2 -c:a aac"));
}

#[test]
fn video_goes_to_every_container_with_its_times_and_sound() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 1);
    let (wanted, (_, end)) = (times(&dir.path().join("in.mp4")), sound_of(&dir, "in.mp4"));
    for (output, codec, heard) in [
        ("out.mp4", "h264", "aac"),
        ("out.mov", "h264", "aac"),
        ("out.mkv", "h264", "aac"),
        ("out.webm", "vp9", "opus"),
    ] {
        done(&dir, &format!("render in.mp4 -o {output}"));
        let path = dir.path().join(output);
        assert_sound(&path);
        assert!(apart(&wanted, &times(&path)) <= 0.001, "{output}");
        assert_eq!(ask(&path, "v:0", "stream=codec_name,pix_fmt"), [format!("{codec},yuv420p")]);
        assert_eq!(ask(&path, "a:0", "stream=codec_name"), [heard], "{output}");
        let (_, own) = sound_of(&dir, output);
        assert!((own - end).abs() <= 0.05, "{output}: {own} s of sound, not {end}");
    }
    let refused = run(&dir, "render in.mp4 -o no.mp4 --crf 99");
    let words = said(&refused);
    assert_eq!(refused.status.code(), Some(2), "{words}");
    assert!(words.contains("--crf 99 is out of range") && words.contains("to 51"), "{words}");
    done(&dir, "render in.mp4 -o mute.mp4 --no-audio --codec h265 --crf 30 --encoder-preset fast");
    assert_eq!(ask(&dir.path().join("mute.mp4"), "", "stream=codec_name"), ["hevc"]);
    done(&dir, "render in.mp4 -o out.gif");
    assert!(apart(&wanted, &times(&dir.path().join("out.gif"))) <= 0.001);
    done(&dir, "render out.gif -o again.mp4");
    assert!(apart(&wanted, &times(&dir.path().join("again.mp4"))) <= 0.001);
}

fn sound_of(dir: &TempDir, name: &str) -> (f64, f64) {
    sound(&dir.path().join(name)).expect("sound")
}

#[test]
fn frames_of_varying_length_keep_their_times() {
    if !require() {
        return;
    }
    let dir = folder();
    let vfr = "-f lavfi -i testsrc2=s=64x48:r=30000/1001:d=2 \
               -vf select='not(mod(n\\,3))+lt(n\\,9)' -fps_mode vfr -c:v libx264 -preset ultrafast";
    let wanted = times(&make(&dir, "in.mkv", vfr));
    for output in ["out.mp4", "out.webm"] {
        done(&dir, &format!("render in.mkv -o {output}"));
        assert!(apart(&wanted, &times(&dir.path().join(output))) <= 0.001, "{output}");
    }
    // From 0.7 s on, and counted from there.
    done(&dir, "render in.mkv -o part.mp4 --start 0.7 --frames 5");
    let part: Vec<f64> = wanted.iter().filter(|&&t| t >= 0.7).take(5).map(|t| t - 0.7).collect();
    assert!(apart(&part, &times(&dir.path().join("part.mp4"))) <= 0.001);
}

#[test]
fn parts_are_exact_to_the_frame_and_so_is_their_sound() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "64x48", 3);
    for (options, first, frames) in [
        ("--start 1", 25, 50),
        ("--start 0.98 --end 1.5", 25, 13),
        ("--end 0.4", 0, 10),
        ("--start 2 --frames 7", 50, 7),
    ] {
        done(&dir, &format!("render in.mp4 -o out.mp4 -y {options}"));
        let path = dir.path().join("out.mp4");
        assert_sound(&path);
        let got = times(&path);
        assert_eq!(got.len(), frames, "{options}");
        let (_, end) = sound_of(&dir, "out.mp4");
        let length = got[0] + frames as f64 / 25.0;
        assert!((end - length).abs() <= 0.05, "{options}: {end} s of sound, {length} of picture");
        done(&dir, &format!("render in.mp4 -o one.png -y --frames 1 {}", options_of(first)));
        done(&dir, "render out.mp4 -o other.png -y --frames 1");
        let read = |name: &str| image::open(dir.path().join(name)).expect(name).to_rgb8();
        let (one, other) = (read("one.png"), read("other.png"));
        let off: u64 =
            one.iter().zip(other.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum::<u64>();
        // The second is low-poly of low-poly: alike, where a frame of another time is not.
        assert!(off / (one.len() as u64) < 24, "{options}: {} apart", off / one.len() as u64);
    }
}

fn options_of(frame: u32) -> String {
    format!("--start {}", f64::from(frame) / 25.0)
}

#[test]
fn pictures_become_video_at_the_rate_that_is_asked_for() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "64x48", 1);
    done(&dir, "render in.mp4 -o f_%03d.png");
    assert!(dir.path().join("f_025.png").exists() && !dir.path().join("f_026.png").exists());
    done(&dir, "render f_%03d.png -o out.mp4 --fps 24000/1001");
    let path = dir.path().join("out.mp4");
    assert_eq!(ask(&path, "v:0", "stream=r_frame_rate,nb_frames"), ["24000/1001,25"]);
    let wanted: Vec<f64> = (0..25).map(|n| f64::from(n) * 1001.0 / 24000.0).collect();
    assert!(apart(&wanted, &times(&path)) <= 0.001);

    let refused = run(&dir, "render f_001.png -o still.mp4");
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("still picture"), "{}", said(&refused));
}

#[test]
fn y4m_goes_through_pipes() {
    if !require() {
        return;
    }
    let dir = folder();
    for format in ["yuv420p", "yuv422p", "yuv444p"] {
        let args = format!(
            "-f lavfi -i testsrc2=s=66x48:r=30000/1001:d=0.4 -pix_fmt {format} -f yuv4mpegpipe"
        );
        let path = make(&dir, "in.y4m", &args);
        let output = polyreel(&dir, "render - -o -")
            .stdin(fs::File::open(&path).expect("the stream"))
            .output()
            .expect("the program");
        assert!(output.status.success(), "{}", said(&output));
        let header = output.stdout.iter().position(|&byte| byte == b'\n').expect("a line") + 1;
        assert!(output.stdout.starts_with(b"YUV4MPEG2 W66 H48 F30000:1001 "));
        // 12 frames and nothing else.
        assert_eq!(output.stdout.len() - header, 12 * (6 + 66 * 48 * 3 / 2), "{format}");
        fs::write(dir.path().join("out.y4m"), output.stdout).expect("a file");
        assert_sound(&dir.path().join("out.y4m"));
    }
    let table = run(&dir, "info in.y4m").stdout;
    assert!(String::from_utf8_lossy(&table).contains("frames    12"));
    done(&dir, "render in.y4m -o copy.y4m");
    assert!(apart(&times(&dir.path().join("in.y4m")), &times(&dir.path().join("copy.y4m"))) == 0.0);
    for (input, words) in [("", "nothing came in"), ("RIFF and so on\n", "ffmpeg cannot read it")] {
        fs::write(dir.path().join("bad"), input).expect("a file");
        let file = fs::File::open(dir.path().join("bad")).expect("a file");
        let output = polyreel(&dir, "render - -o x.mp4").stdin(file).output().expect("the program");
        assert_eq!(output.status.code(), Some(1));
        assert!(said(&output).contains(words), "{}", said(&output));
    }
    assert!(!dir.path().join("x.mp4").exists());
}

#[test]
fn a_reader_who_has_seen_enough_is_no_failure() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "320x240", 4);
    let mut child = polyreel(&dir, "render in.mp4 -o -")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program");
    let mut head = [0; 1000];
    child.stdout.take().expect("a pipe").read_exact(&mut head).expect("frames");
    assert!(head.starts_with(b"YUV4MPEG2 "));
    let output = child.wait_with_output().expect("its end");
    assert_eq!((output.status.code(), said(&output).as_str()), (Some(0), ""));
}

#[test]
fn info_tells_of_video() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 1);
    let output = run(&dir, "info in.mp4");
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    for row in ["format    h264 in mov", "size      96x64", "frames    25", "rate      25 fps"] {
        assert!(table.lines().any(|line| line == row), "{row} in {table}");
    }
    assert!(table.contains("audio     aac 44100 Hz 1 ch"), "{table}");
    let json = run(&dir, "info in.mp4 --json --start 0.2 --frames 10").stdout;
    let info: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    assert_eq!((&info["frames"], &info["duration"]["den"]), (&10.into(), &5.into()), "{info}");
}

#[test]
fn padding_is_told() {
    if !require() {
        return;
    }
    let dir = folder();
    make(&dir, "in.gif", "-f lavfi -i testsrc=s=65x47:r=10:d=0.5");
    let words = done(&dir, "render in.gif -o out.mp4 --report r.json");
    assert!(words.contains("warning") && words.contains("66x48"), "{words}");
    let report = fs::read(dir.path().join("r.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
    let warnings = report["output"]["warnings"].as_array().expect("a list");
    assert!(warnings.len() == 1 && warnings[0].as_str().is_some_and(|w| w.contains("66x48")));
    assert_eq!(done(&dir, "render in.gif -o out.mp4 -y -q"), "");
    assert_eq!(done(&dir, "render in.gif -o out.webm -q"), "");
    assert_eq!(ask(&dir.path().join("out.webm"), "v:0", "stream=width,height"), ["65,47"]);
}

#[test]
fn a_flat_colour_stays_itself() {
    if !require() {
        return;
    }
    let dir = folder();
    let [r, g, b] = [200u8, 60, 30];
    for (name, args) in [
        ("hd.mp4", "scale=out_color_matrix=bt709,format=yuv420p -colorspace bt709"),
        ("sd.mp4", "scale=out_color_matrix=bt601,format=yuv420p -colorspace smpte170m"),
        ("full.mp4", "scale=out_range=pc,format=yuvj420p -color_range pc"),
        ("plain.mp4", "format=yuv420p"),
    ] {
        let args = format!(
            "-f lavfi -i color=c=0xC83C1E:s=96x64:r=10:d=0.3,format=gbrp -vf {args} -c:v libx264 -qp 1"
        );
        make(&dir, name, &args);
        done(&dir, &format!("render {name} -o out.png -y --frames 1"));
        done(&dir, &format!("render {name} -o out.mp4 -y"));
        make(&dir, "back.png", &format!("-i {}/out.mp4 -frames:v 1", dir.path().display()));
        for file in ["out.png", "back.png"] {
            let picture = image::open(dir.path().join(file)).expect(file).to_rgb8();
            for pixel in picture.pixels() {
                let off = pixel.0.iter().zip([r, g, b]).map(|(p, c)| p.abs_diff(c)).max();
                assert!(off <= Some(2), "{name} to {file}: {pixel:?}");
            }
        }
    }
}
