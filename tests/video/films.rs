//! Films in parts, out of all containers: with B-frames, open GOPs, varying rates, edit lists, and sound.

use std::process::{Command, Stdio};

use tempfile::TempDir;

use crate::given::*;
use crate::program::{listing, polyreel, run, said};

/// Scenes of some seconds each, with a cut, a flash, a fade from black and a dissolve between them. All of them are the
/// same in each run: `gradients` is not, whatever its seed.
const SCENES: &str = "-f lavfi -i testsrc2=s=96x64:r=25:d=5 -f lavfi -i mandelbrot=s=96x64:r=25 \
    -f lavfi -i life=s=48x32:r=25:mold=10:ratio=0.4:seed=3 -f lavfi -i testsrc=s=96x64:r=25:d=5 \
    -f lavfi -i sine=d=16:r=44100 \
    -filter_complex [1]trim=duration=4,setsar=1[b];[2]trim=duration=3,scale=96:64:flags=neighbor,setsar=1,\
fade=in:0:10[c];[3]trim=duration=4,setsar=1[d];color=white:s=96x64:r=25:d=0.08,setsar=1[w];\
[0]setsar=1[a];[a][w][b][c][d]concat=n=5,format=yuv420p[v]";

fn done(dir: &TempDir, line: &str) -> String {
    let output = run(dir, line);
    let words = said(&output);
    assert!(output.status.success(), "{line}: {words}");
    words
}

/// The hash and the time of every decoded frame.
fn frames(dir: &TempDir, name: &str) -> Vec<String> {
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-i"]).arg(dir.path().join(name));
    command.args(["-map", "0:v", "-fps_mode", "passthrough", "-f", "framemd5", "-"]);
    let text = String::from_utf8(command.output().expect("ffmpeg runs").stdout).expect("text");
    text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect()
}

fn chunks(dir: &TempDir, plan: &str) -> usize {
    let text = std::fs::read_to_string(dir.path().join(plan)).expect("a plan");
    text.lines().filter(|line| line.starts_with("{\"chunk\":")).count()
}

#[test]
fn films_of_every_container_join_to_the_frames_and_times_of_one_render() {
    if !require() {
        return;
    }
    let dir = folder();
    let x264 = "-c:v libx264 -preset veryfast -g 40 -bf 3 -x264-params open-gop=1 -c:a aac";
    for (name, how) in [
        ("in.mp4", x264.to_owned()),
        ("in.ts", x264.to_owned()),
        // From 0.48 s on, by an edit list.
        ("edit.mov", format!("{x264} -ss 0.48")),
        ("varying.mkv", format!("-fps_mode vfr {x264}")),
        ("in.webm", "-c:v libvpx -deadline realtime -cpu-used 8 -g 50 -c:a libopus".to_owned()),
    ] {
        let scenes = if name == "varying.mkv" {
            SCENES.replace(
                "format=yuv420p[v]",
                "format=yuv420p,select='not(mod(n\\,3))+gt(n\\,200)'[v]",
            )
        } else {
            SCENES.to_owned()
        };
        make(&dir, name, &format!("{scenes} -map [v] -map 4:a {how}"));
        done(
            &dir,
            &format!("plan {name} -o plan.json -y --max-frames 60 --codec ffv1 --points 60"),
        );
        let count = chunks(&dir, "plan.json");
        assert!(count >= 4, "{name}: {count} chunks");
        render_roughly(&dir, count);
        done(&dir, "join plan.json -o joined.mkv -y");
        done(&dir, &format!("render {name} -o whole.mkv -y --codec ffv1 --points 60"));
        let (joined, whole) = (frames(&dir, "joined.mkv"), frames(&dir, "whole.mkv"));
        assert!(whole.len() > 200, "{name}: {} frames", whole.len());
        assert!(joined == whole, "{name}: frames or times differ");
        let [a, b] = ["joined.mkv", "whole.mkv"].map(|name| sound(&dir.path().join(name)));
        assert!(a.is_some() && a == b, "{name}: sound {a:?}, not {b:?}");
        std::fs::remove_dir_all(dir.path().join("parts")).expect("parts");
    }
}

/// Renders `count` chunks by two processes at a time, in a mixed order. One is killed and another run twice at once.
fn render_roughly(dir: &TempDir, count: usize) {
    let start = |chunk: usize| {
        let mut command = polyreel(dir, &format!("render --plan plan.json --chunk {chunk} -q"));
        command.stdin(Stdio::null()).spawn().expect("the program")
    };
    let mut killed = start(count - 1);
    killed.kill().expect("a child");
    killed.wait().expect("its end");
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|chunk| (chunk * 7 + 3) % count.next_power_of_two());
    order.push(order[0]);
    for pair in order.chunks(2) {
        let children: Vec<_> = pair.iter().map(|&chunk| start(chunk)).collect();
        for mut child in children {
            assert!(child.wait().expect("its end").success());
        }
    }
    let twice = [0, 0].map(|_| start(0));
    for mut child in twice {
        assert!(child.wait().expect("its end").success());
    }
}

/// A folder with `in.mp4`: all scenes, with sound.
fn folder_with_film() -> TempDir {
    let dir = folder();
    let how = "-map [v] -map 4:a -c:v libx264 -preset veryfast -c:a aac";
    make(&dir, "in.mp4", &format!("{SCENES} {how}"));
    dir
}

#[test]
fn encoded_films_and_parts_of_them_are_the_same_file() {
    if !require() {
        return;
    }
    let dir = folder_with_film();
    let how = "--points 50 --encoder-preset ultrafast --start 4.2 --end 11.5";
    done(&dir, &format!("plan in.mp4 -o plan.json --max-frames 50 {how}"));
    done(&dir, "render --plan plan.json --all --jobs 2");
    done(&dir, "join plan.json -o joined.mp4");
    done(&dir, &format!("render in.mp4 -o whole.mp4 {how}"));
    let [joined, whole] =
        ["joined.mp4", "whole.mp4"].map(|name| std::fs::read(dir.path().join(name)));
    assert!(joined.expect("a film") == whole.expect("a film"));
}

#[test]
fn a_render_that_was_killed_again_and_again_ends_as_one_that_was_not() {
    if !require() {
        return;
    }
    let dir = folder_with_film();
    let line = "render in.mp4 -o out.mkv --codec ffv1 --points 60 --resume";
    for tried in 0..6u64 {
        let mut child = polyreel(&dir, &format!("{line} -q"));
        let mut child = child.stdin(Stdio::null()).spawn().expect("the program");
        // At another moment each time: there is nothing to wait for.
        std::thread::sleep(std::time::Duration::from_millis(150 + tried * 370 % 800));
        child.kill().expect("a child");
        child.wait().expect("its end");
    }
    done(&dir, &format!("{line} -y"));
    done(&dir, "render in.mp4 -o whole.mkv --codec ffv1 --points 60");
    assert!(frames(&dir, "out.mkv") == frames(&dir, "whole.mkv"));
    assert_eq!(listing(&dir), ["in.mp4", "out.mkv", "whole.mkv"]);
}

#[test]
fn hdr_films_in_parts_are_those_of_one_render() {
    if !require() {
        return;
    }
    let dir = folder();
    make(
        &dir,
        "in.mp4",
        "-f lavfi -i mandelbrot=s=96x64:r=25 -t 1 -metadata title=deep -vf format=yuv420p10le -c:v libx265 \
         -x265-params log-level=error:colorprim=bt2020:transfer=smpte2084:colormatrix=bt2020nc \
         -color_primaries bt2020 -color_trc smpte2084 -colorspace bt2020nc",
    );
    for (options, transfer) in [("", "bt709"), ("--hdr --no-metadata", "smpte2084")] {
        done(&dir, &format!("plan in.mp4 -o plan.json -y --points 60 {options}"));
        done(&dir, "render --plan plan.json --all");
        done(&dir, "join plan.json -o parts.mp4 -y");
        done(&dir, &format!("render in.mp4 -o whole.mp4 -y --points 60 {options}"));
        assert_eq!(frames(&dir, "parts.mp4"), frames(&dir, "whole.mp4"), "{options}");
        for name in ["parts.mp4", "whole.mp4"] {
            let path = dir.path().join(name);
            assert_eq!(ask(&path, "v:0", "stream=color_transfer"), [transfer], "{name}");
            let title = ask(&path, "v:0", "format_tags=title");
            assert_eq!(title.concat() == "deep", options.is_empty(), "{name}: {title:?}");
        }
    }
}
