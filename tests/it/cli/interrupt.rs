//! Ctrl-C: once for a shorter output, twice to end at once.
#![cfg(unix)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use super::{Folder, picture};
use crate::wait::until;

/// Starts a long render to `output` and waits until it has begun to write: `bytes` bytes of it.
fn begin(folder: &Folder, side: u32, frames: u32, output: &str, bytes: u64) -> Child {
    fs::create_dir(folder.path("in")).expect("a new folder");
    fs::create_dir(folder.path("out")).expect("a new folder");
    let first = folder.path("in/0.png");
    picture(side, side, 0).save(&first).expect("a writable folder");
    for t in 1..frames {
        fs::hard_link(&first, folder.path(&format!("in/{t}.png"))).expect("a link");
    }
    let mut child = Command::new(env!("CARGO_BIN_EXE_polyreel"))
        .args(["render", "in", "-o", output])
        .current_dir(folder.path(""))
        .stderr(Stdio::null())
        .spawn()
        .expect("the program");
    until("an output that is begun", || {
        let ended = child.try_wait().expect("a child");
        assert_eq!(ended, None, "the program has ended already");
        let named = folder.listing().into_iter().filter(|name| name.starts_with("out/"));
        let mut begun =
            named.map(|name| folder.path(&name)).chain(open(&child, &folder.path("out")));
        begun.any(|file| fs::metadata(file).is_ok_and(|file| file.len() >= bytes)).then_some(())
    });
    child
}

/// The files in `place` that a process has open: an unfinished one has no name where the system allows it.
fn open(child: &Child, place: &Path) -> Vec<PathBuf> {
    let place = place.canonicalize().expect("a folder");
    let open = fs::read_dir(format!("/proc/{}/fd", child.id())).into_iter().flatten().flatten();
    let is_there = |file: &PathBuf| fs::read_link(file).is_ok_and(|file| file.starts_with(&place));
    open.map(|entry| entry.path()).filter(is_there).collect()
}

/// Bytes of a frame of 400x400 in a y4m.
const FRAME: usize = 6 + 400 * 400 * 3 / 2;

fn press_ctrl_c(child: &Child) {
    let pid = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &pid]).status().expect("kill is there");
    assert!(sent.success(), "the program has ended already");
}

fn outputs(folder: &Folder) -> Vec<String> {
    let names = folder.listing().into_iter();
    names.filter(|name| name.starts_with("out/")).collect()
}

#[test]
fn the_first_gives_a_shorter_output() {
    let folder = Folder::new();
    // A frame or more is in the file.
    let mut child = begin(&folder, 400, 600, "out/a.y4m", 1);
    press_ctrl_c(&child);
    assert_eq!(child.wait().expect("the program's end").code(), Some(130));
    assert_eq!(outputs(&folder), ["out/a.y4m"]);
    let bytes = folder.read("out/a.y4m");
    let header = bytes.iter().position(|&byte| byte == b'\n').expect("a line") + 1;
    let (frames, rest) = ((bytes.len() - header) / FRAME, (bytes.len() - header) % FRAME);
    assert!(frames > 0 && frames < 600 && rest == 0, "{frames} frames and {rest} bytes");
}

#[test]
fn the_second_ends_at_once_and_leaves_nothing() {
    for output in ["out/a.gif", "out/%03d.png", "out/new/"] {
        let folder = Folder::new();
        let mut child = begin(&folder, 2400, 40, output, 0);
        // Signals that come together are one: more are sent, until there were two.
        let ended = until("the program's end", || {
            press_ctrl_c(&child);
            child.try_wait().expect("a child")
        });
        assert_eq!(ended.code(), Some(130));
        assert_eq!(outputs(&folder), [""; 0], "{output}");
    }
}
