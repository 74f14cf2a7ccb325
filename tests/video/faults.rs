//! The whole program when something goes wrong, or somebody presses Ctrl-C.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use tempfile::TempDir;

use crate::given::*;
use crate::program::*;
use crate::wait::until;

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

#[test]
fn a_decoder_that_fails_is_no_video_that_breaks_off() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "160x120", 2);
    let frames = 160 * 120 * 3 / 2 * 20;
    for (end, words) in [
        ("kill -9 $$", "signal: 9"),
        ("echo 'out of cheese' >&2; exit 1", "out of cheese"),
        ("sleep 1000", "stopped working"),
    ] {
        stand_in(&dir, &format!("ffmpeg \"$@\" 2>/dev/null | head -c {frames}; {end}"));
        let line = "render in.mp4 -o out.gif --points 60 --allow-truncated --ffmpeg ./stand-in";
        let ended = run(&dir, line);
        assert_eq!(ended.status.code(), Some(1), "{end}: {}", said(&ended));
        assert!(said(&ended).contains("ffmpeg failed: "), "{end}: {}", said(&ended));
        assert!(said(&ended).contains(words), "{end}: {}", said(&ended));
        assert_eq!(listing(&dir), ["in.mp4", "stand-in"], "{end}");
    }
}

#[test]
fn a_damaged_video_fails_unless_that_is_allowed() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mkv", "160x120", 4);
    let mut bytes = fs::read(dir.path().join("in.mkv")).expect("the clip");
    let middle = bytes.len() / 2;
    bytes[middle..middle + 2000].iter_mut().for_each(|byte| *byte ^= 0x5A);
    fs::write(dir.path().join("in.mkv"), bytes).expect("damaged");
    let ended = run(&dir, "render in.mkv -o out.gif --points 60");
    assert_eq!(ended.status.code(), Some(1), "{}", said(&ended));
    assert!(said(&ended).contains("the video is damaged: "), "{}", said(&ended));
    assert!(said(&ended).contains("--allow-truncated"), "{}", said(&ended));
    assert_eq!(listing(&dir), ["in.mkv"]);
    let ended = run(&dir, "render in.mkv -o out.gif --points 60 --allow-truncated");
    assert_eq!(ended.status.code(), Some(0), "{}", said(&ended));
    assert!(said(&ended).contains("warning: in.mkv, frame "), "{}", said(&ended));
}

/// The processes that were begun, in their order.
fn pids(dir: &TempDir) -> Vec<String> {
    let text = fs::read_to_string(dir.path().join("pids")).unwrap_or_default();
    text.lines().map(String::from).collect()
}

/// Whether the process `pid` is there and has not ended.
fn is_there(pid: &str) -> bool {
    let stat = fs::read_to_string(Path::new("/proc").join(pid).join("stat"));
    stat.is_ok_and(|stat| !stat.contains(") Z "))
}

/// Starts a render that takes a while and waits until the encoder has begun its file. Every ffmpeg
/// that is begun notes its number in `pids`, that which reads the clip in `decoder`, too; the encoder
/// does `after` when it is done.
fn begin(dir: &TempDir, after: &str) -> Child {
    clip(dir, "in.mp4", "320x240", 60);
    stand_in(
        dir,
        &format!(
            "echo $$ >> pids; case \"$*\" in *pipe:0*) ffmpeg \"$@\"; {after};; \
             *) echo $$ > decoder; exec ffmpeg \"$@\";; esac"
        ),
    );
    let child =
        polyreel(dir, "render in.mp4 -o out.mp4 --ffmpeg ./stand-in --encoder-preset ultrafast")
            .stderr(Stdio::null())
            .spawn()
            .expect("the program");
    let has_begun = |name: &String| {
        name.starts_with(".polyreel-")
            && fs::metadata(dir.path().join(name)).is_ok_and(|file| file.len() > 0)
    };
    until("the encoder begins its file", || listing(dir).iter().any(has_begun).then_some(()));
    child
}

fn press_ctrl_c(child: &Child) {
    let pid = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &pid]).status().expect("kill is there");
    assert!(sent.success(), "the program has ended already");
}

/// Fails unless every ffmpeg is gone, or about to go.
fn assert_gone(dir: &TempDir) {
    until("ffmpeg ends", || (!pids(dir).iter().any(|pid| is_there(pid))).then_some(()));
}

#[test]
fn the_first_ctrl_c_gives_a_shorter_video() {
    if !require() {
        return;
    }
    let dir = folder();
    let mut child = begin(&dir, "exit $?");
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
    // The file is not finished before the second one comes, and the encoder is not taken for hung.
    let mut child = begin(&dir, "while :; do :; done");
    press_ctrl_c(&child);
    // Signals that come together are one: the first has come when the decoder is ended.
    let decoder = fs::read_to_string(dir.path().join("decoder")).expect("it has begun");
    until("the decoder ends", || (!is_there(decoder.trim())).then_some(()));
    press_ctrl_c(&child);
    assert_eq!(child.wait().expect("its end").code(), Some(130));
    assert_gone(&dir);
    assert_eq!(listing(&dir), ["decoder", "in.mp4", "pids", "stand-in"]);
}

#[test]
fn a_decoder_that_only_talks_is_ended_by_one_signal() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 1);
    stand_in(&dir, "echo $$ >> pids; exec yes >&2");
    let mut child = polyreel(&dir, "render in.mp4 -o out.gif -q --ffmpeg ./stand-in")
        .stderr(Stdio::null())
        .spawn()
        .expect("the program");
    until("the decoder begins", || pids(&dir).pop());
    press_ctrl_c(&child);
    until("the program ends", || child.try_wait().expect("ours"));
    assert_gone(&dir);
    assert_eq!(listing(&dir), ["in.mp4", "pids", "stand-in"]);
}

#[test]
fn an_ffmpeg_that_is_too_old_is_told_with_the_floor() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 1);
    stand_in(&dir, "echo \"Unrecognized option 'fps_mode'.\" >&2; exit 1");
    let output = run(&dir, "render in.mp4 -o out.gif --ffmpeg ./stand-in");
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("5.1 or later"), "{}", said(&output));
}

#[test]
fn an_encoder_that_is_not_there_is_a_wrong_request_that_names_the_right_ones() {
    if !require() {
        return;
    }
    let dir = folder();
    clip(&dir, "in.mp4", "96x64", 1);
    let output = run(&dir, "render in.mp4 -o out.mp4 --codec h246 --points 30");
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("no encoder 'h246'"), "{}", said(&output));
    assert!(said(&output).contains("h264, h265"), "{}", said(&output));
    assert_eq!(listing(&dir), ["in.mp4"]);
}
