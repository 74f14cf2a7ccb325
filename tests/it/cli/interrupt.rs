//! Ctrl-C: once for a shorter output, twice to end at once.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use super::{Folder, picture};
use crate::wait::until;

/// Starts a long render to `output` and waits until it has begun to write.
fn begin(folder: &Folder, side: u32, frames: u32, output: &str) -> Child {
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
        let is_begun = folder.listing().iter().any(|name| name.starts_with("out/"));
        (is_begun || has_open(&child, &folder.path("out"))).then_some(())
    });
    child
}

/// Whether a process has a file in `place` open: an unfinished one has no name where the system allows it.
fn has_open(child: &Child, place: &Path) -> bool {
    let place = place.canonicalize().expect("a folder");
    let open = fs::read_dir(format!("/proc/{}/fd", child.id())).into_iter().flatten().flatten();
    let mut files = open.filter_map(|entry| fs::read_link(entry.path()).ok());
    files.any(|file| file.starts_with(&place))
}

fn press_ctrl_c(child: &Child) {
    let pid = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &pid]).status().expect("kill is there");
    assert!(sent.success(), "the program has ended already");
}

fn end(mut child: Child) -> ExitStatus {
    child.wait().expect("the program's end")
}

fn outputs(folder: &Folder) -> Vec<String> {
    let names = folder.listing().into_iter();
    names.filter(|name| name.starts_with("out/")).collect()
}

#[test]
fn the_first_gives_a_shorter_output() {
    let folder = Folder::new();
    let child = begin(&folder, 400, 600, "out/a.gif");
    std::thread::sleep(Duration::from_millis(150));
    press_ctrl_c(&child);
    assert_eq!(end(child).code(), Some(130));
    match &outputs(&folder)[..] {
        // A slow machine may not have had a frame yet.
        [] => {}
        [name] => {
            assert_eq!(name, "out/a.gif");
            let frames = folder.delays(name).len();
            assert!(frames > 0 && frames < 600, "{frames} frames");
        }
        more => panic!("{more:?}"),
    }
}

#[test]
fn the_second_ends_at_once_and_leaves_nothing() {
    for output in ["out/a.gif", "out/%03d.png", "out/new/"] {
        let folder = Folder::new();
        let child = begin(&folder, 2400, 40, output);
        press_ctrl_c(&child);
        // Signals that come together are one.
        std::thread::sleep(Duration::from_millis(50));
        press_ctrl_c(&child);
        assert_eq!(end(child).code(), Some(130));
        assert_eq!(outputs(&folder), [""; 0], "{output}");
    }
}
