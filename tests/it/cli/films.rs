//! Films in parts, without ffmpeg: y4m in; y4m, GIFs and pictures out.

use std::fs;
use std::process::{Command, Stdio};

use super::{Folder, stderr};
use crate::wait::until;

const SIZE: (usize, usize) = (96, 64);

/// A y4m at 10 frames a second of shots, each as many frames long: waves that move, another pattern a shot.
fn film(lengths: &[usize]) -> Vec<u8> {
    let (width, height) = SIZE;
    let mut bytes = format!("YUV4MPEG2 W{width} H{height} F10:1 Ip A1:1 C420mpeg2\n").into_bytes();
    for (shot, &frames) in lengths.iter().enumerate() {
        let (fx, fy) = (0.11 + 0.13 * (shot % 3) as f64, 0.31 - 0.09 * (shot % 4) as f64);
        let tilt = 0.7 * shot as f64;
        for t in 0..frames {
            bytes.extend(b"FRAME\n");
            for i in 0..width * height {
                let (x, y) = ((i % width) as f64 + 1.5 * t as f64, (i / width) as f64);
                let (u, v) = (x * tilt.cos() + y * tilt.sin(), y * tilt.cos() - x * tilt.sin());
                let wave =
                    (u * fx).sin() * (v * fy + tilt).cos() + 0.4 * (u * v * 0.004 + tilt).sin();
                bytes.push((125.0 + 70.0 * wave) as u8);
            }
            bytes.extend((0..width * height / 2).map(|i| (90 + 20 * shot + i % 31) as u8));
        }
    }
    bytes
}

/// A folder with a film of four shots in it, `in.y4m`.
fn given() -> Folder {
    let folder = Folder::new();
    folder.write("in.y4m", &film(&[8, 6, 9, 5]));
    folder
}

/// The number of chunks of the plan `name`.
fn chunks(folder: &Folder, name: &str) -> usize {
    folder.json(name)["chunks"].as_array().expect("a list").len()
}

#[test]
fn parts_join_to_the_bytes_of_one_render() {
    for look in [
        "",
        "--refine 0",
        "--coherence 0 --refine 2",
        "--error psnr:22 --points auto",
        "--start 0.3 --frames 19",
        "--max-size 64 --scale 2 --outline --saturation 1.4",
    ] {
        let folder = given();
        folder.run(&format!("plan in.y4m -o plan.json --max-frames 8 {look}")).success();
        let count = chunks(&folder, "plan.json");
        assert!(count >= 3, "{look}: {count} chunks");
        // Not in their order.
        for chunk in (0..count).rev().step_by(2).chain((0..count - 1).rev().step_by(2)) {
            folder.run(&format!("render --plan plan.json --chunk {chunk}")).success();
        }
        for output in ["y4m", "gif", "png"] {
            let name = if output == "png" { "_%02d.png" } else { &format!(".{output}") };
            if output == "gif" && look.contains("--error") {
                continue;
            }
            folder.run(&format!("join plan.json -o joined{name}")).success();
            folder.run(&format!("render in.y4m -o whole{name} {look}")).success();
        }
        let names = folder.listing();
        let whole: Vec<_> = names.iter().filter(|name| name.starts_with("whole")).collect();
        assert!(whole.len() > 19, "{whole:?}");
        for name in whole {
            let joined = name.replace("whole", "joined");
            assert!(folder.read(name) == folder.read(&joined), "{look}: {name} differs");
        }
    }
}

#[test]
fn gifs_keep_their_times_and_what_is_transparent() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 40, 250, 100, 70]);
    folder.run("plan in.gif -o plan.json").success();
    folder.run("render --plan plan.json --all").success();
    folder.run("join plan.json -o joined.gif").success();
    folder.run("render in.gif -o whole.gif").success();
    assert!(folder.read("joined.gif") == folder.read("whole.gif"));
    let said = stderr(&folder.run("join plan.json -o joined.y4m").code(2));
    assert!(said.contains("--for .y4m"), "{said}");
}

#[test]
fn sequences_are_films_and_so_are_parts_of_them() {
    let folder = Folder::new();
    folder.sequence("in", 9);
    for look in ["--frames 7 --fps 12", "--start 0.1", "--frames 5 --coherence 0"] {
        folder.run(&format!("plan in -o plan.json -y --max-frames 3 {look}")).success();
        folder.run("render --plan plan.json --all -q").success();
        folder.run("join plan.json -o joined.y4m -y").success();
        folder.run(&format!("render in -o whole.y4m -y {look}")).success();
        assert!(folder.read("joined.y4m") == folder.read("whole.y4m"), "{look}");
    }
    let said = stderr(&folder.run("plan in/f0.png in/f1.png -o in/f1.png -y").code(1));
    assert!(said.contains("is the film, too"), "{said}");
}

#[test]
fn what_is_stale_is_named_and_rendered_again() {
    let folder = given();
    folder.run("plan in.y4m -o plan.json --max-frames 8").success();
    folder.run("render --plan plan.json --all").success();
    folder.run("join plan.json -o whole.y4m").success();
    let part = folder.read("parts/0001.polyreel");
    let report = String::from_utf8(folder.read("parts/0001.json")).expect("text");
    let mut flipped = part.clone();
    flipped[part.len() / 2] ^= 4;
    let version = format!("\"{}\"", env!("CARGO_PKG_VERSION"));
    for (name, bytes, why) in [
        ("parts/0001.polyreel", &part[..part.len() / 2], "cut short"),
        ("parts/0001.polyreel", &flipped[..], "damaged"),
        ("parts/0001.json", report.replace(&version, "\"0.0.9\"").as_bytes(), "by polyreel 0.0.9"),
        ("parts/0001.json", b"{}", "cannot be understood"),
    ] {
        folder.write(name, bytes);
        let said = stderr(&folder.run("join plan.json -o joined.y4m").code(1));
        assert!(said.contains("0001.polyreel") && said.contains(why), "{why}: {said}");
        assert!(said.contains("0 of 4 parts are missing and 1 are not"), "{said}");
        let said = stderr(&folder.run("render --plan plan.json --chunk 1").success());
        assert!(said.contains(why) && said.contains("anew"), "{said}");
        assert!(folder.read("parts/0001.polyreel") == part, "the same bytes again");
    }
    fs::remove_file(folder.path("parts/0001.json")).expect("a report");
    let said = stderr(&folder.run("join plan.json -o joined.y4m").code(1));
    assert!(said.contains("0001.polyreel has no report"), "{said}");
    fs::remove_file(folder.path("parts/0001.polyreel")).expect("a part");
    let said = stderr(&folder.run("join plan.json -o joined.y4m").code(1));
    assert!(said.contains("0001.polyreel is missing"), "{said}");
    folder.run("plan in.y4m -o other.json --max-frames 8 --seed 3").success();
    let said = stderr(&folder.run("join other.json -o joined.y4m").code(1));
    assert!(said.contains("0000.polyreel was rendered with other options"), "{said}");
    folder.write("in2.y4m", &film(&[8, 6, 9, 6]));
    folder.run("plan in2.y4m -o film.json --max-frames 8").success();
    let said = stderr(&folder.run("join film.json -o joined.y4m").code(1));
    assert!(said.contains("0000.polyreel was rendered from another film"), "{said}");
    folder.run("render --plan plan.json --all --jobs 2").success();
    folder.run("join plan.json -o joined.y4m").success();
    assert!(folder.read("joined.y4m") == folder.read("whole.y4m"));
}

#[test]
fn a_film_that_has_changed_is_refused() {
    let folder = given();
    folder.run("plan in.y4m -o plan.json --max-frames 8").success();
    folder.run("render --plan plan.json --all").success();
    let mut bytes = folder.read("in.y4m");
    let last = bytes.len() - 1;
    bytes[last] ^= 64;
    folder.write("in.y4m", &bytes);
    let said = stderr(&folder.run("join plan.json -o joined.y4m").code(1));
    assert!(said.contains("in.y4m") && said.contains("plan it again"), "{said}");
    for number in [2, 3] {
        fs::remove_file(folder.path(&format!("parts/000{number}.json"))).expect("a report");
    }
    folder.run("render --plan plan.json --chunk 2").success();
    let said = stderr(&folder.run("render --plan plan.json --chunk 3").code(1));
    assert!(said.contains("in.y4m") && said.contains("not the one that was planned"), "{said}");
    folder.write("in.y4m", &film(&[8, 6]));
    let said = stderr(&folder.run("render --plan plan.json --chunk 3").code(1));
    assert!(said.contains("in.y4m") && said.contains("has changed"), "{said}");
    let text = String::from_utf8(folder.read("plan.json")).expect("text");
    let version = env!("CARGO_PKG_VERSION");
    folder.write("plan.json", text.replacen(version, "0.0.9", 1).as_bytes());
    let said = stderr(&folder.run("render --plan plan.json --chunk 3").code(1));
    assert!(said.contains("plan.json: was made by polyreel 0.0.9"), "{said}");
}

#[test]
fn what_cannot_be_done_in_parts_is_refused() {
    let folder = given();
    folder.still("still.png", 40, 30);
    for (line, why) in [
        ("plan in.y4m -o p.json --budget 5ms", "a clock"),
        ("plan in.y4m -o p.json --loop", "the first frame"),
        ("plan in.y4m -o p.json --replay r.json", "a report"),
        ("plan - -o p.json", "only once"),
        ("plan still.png -o p.json", "no film"),
        ("render in.y4m -o x.gif --resume --budget 5ms", "a clock"),
        ("render in.y4m -o x.gif --resume --loop", "the first frame"),
        ("render in.y4m -o - --resume", "no file"),
        ("render in.y4m -o x.gif --jobs 2", "--resume"),
        ("render in.y4m --plan p.json --chunk 1", "--plan"),
        ("render --plan p.json --chunk 1 --points 9", "--points"),
    ] {
        let said = stderr(&folder.run(line).code(2));
        assert!(said.contains(why), "{line}: {said}");
    }
    assert_eq!(folder.listing(), ["in.y4m", "still.png"]);
}

#[test]
fn a_chunk_is_chosen_by_number_or_by_environment() {
    let folder = given();
    folder.run("plan in.y4m -o plan.json --max-frames 8").success();
    let run = |value: Option<&str>| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_polyreel"));
        command.current_dir(folder.path("")).args(["render", "--plan", "plan.json"]);
        command.args(["-o", "there", "--chunk", "env:POLYREEL_TEST"]).env_remove("POLYREEL_TEST");
        let output = command.envs(value.map(|v| ("POLYREEL_TEST", v))).output();
        let output = output.expect("the program");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    assert_eq!(run(Some("2")).0, Some(0));
    assert!(folder.path("there/0002.json").exists());
    for (value, why) in
        [(None, "no variable POLYREEL_TEST"), (Some("x"), "write a number"), (Some("4"), "0 to 3")]
    {
        let (code, said) = run(value);
        assert!(code == Some(2) && said.contains(why), "{said}");
    }
    folder.run("render --plan plan.json").code(2);
}

#[test]
fn a_long_shot_is_whole_unless_it_may_be_split() {
    let folder = Folder::new();
    folder.write("in.y4m", &film(&[25, 5]));
    folder.run("plan in.y4m -o whole.json --max-frames 10").success();
    assert_eq!(chunks(&folder, "whole.json"), 2);
    let said = stderr(
        &folder
            .run("plan in.y4m -o split.json --max-frames 10 --split-long-shots --warm-up 6")
            .success(),
    );
    assert!(said.contains("close to a render of the whole film, not the same"), "{said}");
    let plan = folder.json("split.json");
    let all = plan["chunks"].as_array().expect("a list");
    let kinds: Vec<_> = all.iter().map(|c| (c["frames"].as_u64(), c["exact"].as_bool())).collect();
    let (ten, five) = (Some(10), Some(5));
    assert_eq!(
        kinds,
        [(ten, Some(true)), (ten, Some(false)), (five, Some(false)), (five, Some(true))]
    );
    folder.run("render --plan split.json --all").success();
    folder.run("join split.json -o joined.y4m").success();
    folder.run("render in.y4m -o one.y4m").success();
    let (joined, one) = (folder.read("joined.y4m"), folder.read("one.y4m"));
    let frame = SIZE.0 * SIZE.1 * 3 / 2 + b"FRAME\n".len();
    let head = one.len() - 30 * frame;
    let same = |n: usize| joined[head + n * frame..][..frame] == one[head + n * frame..][..frame];
    assert_eq!(joined.len(), one.len());
    assert!((0..10).chain(25..30).all(same), "exact chunks are exact");
}

#[test]
#[cfg(unix)]
fn a_killed_render_goes_on_where_it_was() {
    let folder = Folder::new();
    folder.write("in.y4m", &film(&[140; 5]));
    let line = ["render", "in.y4m", "-o", "out.gif", "--resume", "--jobs", "2"];
    let command = |quiet: bool| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_polyreel"));
        command.current_dir(folder.path("")).args(line).args(quiet.then_some("-q"));
        command
    };
    let complete = || {
        let names = folder.listing();
        let is_report = |name: &&String| name.ends_with(".json") && !name.ends_with("plan.json");
        names.iter().filter(is_report).cloned().collect::<Vec<_>>()
    };
    let mut child = command(true).stderr(Stdio::null()).spawn().expect("the program");
    until("a part that is complete", || (!complete().is_empty()).then_some(()));
    child.kill().expect("it runs");
    child.wait().expect("its end");
    // Its processes end with it: then nothing becomes complete any more.
    let in_work = || {
        let open =
            Command::new("pgrep").args(["-f", folder.path("").to_str().expect("text")]).output();
        open.is_ok_and(|found| found.stdout.is_empty())
    };
    until("an end of its processes", || in_work().then_some(()));
    let before = complete();
    assert!(!before.is_empty() && before.len() < 5, "{before:?}");
    let output = command(false).output().expect("the program");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(said.contains("goes on with what is there"), "{said}");
    assert!(said.contains(&format!("5 chunks are there, {} were before", before.len())), "{said}");
    folder.run("render in.y4m -o whole.gif").success();
    assert!(folder.read("out.gif") == folder.read("whole.gif"));
    assert_eq!(folder.listing(), ["in.y4m", "out.gif", "whole.gif"], "no part is left");
    folder.run("render in.y4m -o out.gif --resume").code(1);
}
