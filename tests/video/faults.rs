//! The whole program when something goes wrong, or somebody presses Ctrl-C.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use tempfile::TempDir;

use crate::given::*;
use crate::program::*;

/// A stand-in that does `script` as the encoder and is ffmpeg else.
fn encoder(dir: &TempDir, script: &str) {
    stand_in(dir, &format!("case \"$*\" in *pipe:0*) {script};; *) exec ffmpeg \"$@\";; esac"));
}

#[test]
fn encoders_that_fail_leave_nothing() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "160x120", 2);
    for (script, words) in [
        ("head -c 290000 >/dev/null; echo 'no more' >&2; exit 1", "no more"),
        ("head -c 290000 >/dev/null; kill -9 $$", "signal: 9"),
        ("head -c 290000 >/dev/null; sleep 1000", "stopped working"),
    ] {
        encoder(&dir, script);
        let output = run(&dir, "render in.mp4 -o out.mp4 --ffmpeg ./stand-in");
        assert_eq!(output.status.code(), Some(1), "{script}");
        assert!(said(&output).contains(words), "{script}: {}", said(&output));
        assert_eq!(listing(&dir), ["in.mp4", "stand-in"], "{script}");
    }
    encoder(&dir, "yes 'many words' | head -c 5000000 >&2; exec ffmpeg \"$@\"");
    let output = run(&dir, "render in.mp4 -o out.mp4 --ffmpeg ./stand-in");
    assert!(output.status.success(), "{}", said(&output));
    assert_sound(&dir.path().join("out.mp4"));
}

#[test]
fn a_missing_ffmpeg_is_told_with_its_cure() {
    let dir = folder();
    fs::write(dir.path().join("in.mp4"), "no picture").expect("a file");
    let output = polyreel(&dir, "render in.mp4 -o out.mp4").env("PATH", "").output().expect("ours");
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("apt-get install ffmpeg"), "{}", said(&output));
    assert!(said(&output).contains("--ffmpeg PATH"), "{}", said(&output));
}

#[test]
fn a_video_that_breaks_off_fails_unless_that_is_allowed() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mkv", "160x120", 4);
    let bytes = fs::read(dir.path().join("in.mkv")).expect("the clip");
    fs::write(dir.path().join("cut.mkv"), &bytes[..bytes.len() * 6 / 10]).expect("shorter");
    for output in ["out.mp4", "out.gif", "f/"] {
        let ended = run(&dir, &format!("render cut.mkv -o {output}"));
        assert_eq!(ended.status.code(), Some(1), "{}", said(&ended));
        assert!(said(&ended).contains("prematurely"), "{}", said(&ended));
        assert_eq!(listing(&dir), ["cut.mkv", "in.mkv"], "{output}");
    }
    let ended = run(&dir, "render cut.mkv -o out.mp4 --allow-truncated -q");
    assert_eq!(ended.status.code(), Some(0), "{}", said(&ended));
    assert!(said(&ended).contains("warning: cut.mkv, frame "), "{}", said(&ended));
    let path = dir.path().join("out.mp4");
    assert_sound(&path);
    let frames = times(&path).len();
    assert!((30..90).contains(&frames), "{frames} frames");
}

/// Starts a render that takes a while and waits until frames arrive at the encoder. Every ffmpeg
/// that is begun notes its number in `pids`.
fn begin(dir: &TempDir) -> Child {
    clip(dir, "in.mp4", "320x240", 60);
    stand_in(dir, "echo $$ >> pids; exec ffmpeg \"$@\"");
    let child = polyreel(dir, "render in.mp4 -o out.mp4 --ffmpeg ./stand-in")
        .stderr(Stdio::null())
        .spawn()
        .expect("the program");
    while fs::read_to_string(dir.path().join("pids")).map_or(0, |pids| pids.lines().count()) < 2 {
        sleep(Duration::from_millis(5));
    }
    sleep(Duration::from_millis(700));
    child
}

fn press_ctrl_c(child: &Child) {
    let pid = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &pid]).status().expect("kill is there");
    assert!(sent.success(), "the program has ended already");
}

/// Fails unless every ffmpeg is gone, or about to go.
fn assert_gone(dir: &TempDir) {
    let pids = fs::read_to_string(dir.path().join("pids")).expect("some have begun");
    for pid in pids.lines() {
        let there = || {
            let stat = fs::read_to_string(Path::new("/proc").join(pid).join("stat"));
            stat.is_ok_and(|stat| !stat.contains(") Z "))
        };
        let mut patience = 100;
        while there() {
            patience -= 1;
            assert!(patience > 0, "ffmpeg {pid} is left");
            sleep(Duration::from_millis(20));
        }
    }
}

#[test]
fn the_first_ctrl_c_gives_a_shorter_video() {
    if !require() {
        return;
    }
    let dir = folder();
    let mut child = begin(&dir);
    press_ctrl_c(&child);
    assert_eq!(child.wait().expect("its end").code(), Some(130));
    assert_gone(&dir);
    let path = dir.path().join("out.mp4");
    assert_sound(&path);
    let frames = times(&path).len();
    assert!(frames > 0 && frames < 1500, "{frames} frames");
    let (_, end) = sound(&path).expect("sound");
    assert!((end - frames as f64 / 25.0).abs() < 0.06, "{end} s of sound to {frames} frames");
}

#[test]
fn the_second_ctrl_c_ends_all_at_once() {
    if !require() {
        return;
    }
    let dir = folder();
    let mut child = begin(&dir);
    press_ctrl_c(&child);
    sleep(Duration::from_millis(10));
    press_ctrl_c(&child);
    assert_eq!(child.wait().expect("its end").code(), Some(130));
    assert_gone(&dir);
    assert_eq!(listing(&dir), ["in.mp4", "pids", "stand-in"]);
}
