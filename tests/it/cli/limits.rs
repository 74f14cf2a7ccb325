//! A standard error that is full or gone, limits of the system, links, modes, and names that are no text.
#![cfg(unix)]

use std::fs::{self, File};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::process::{Command, Stdio};

use super::{Folder, stderr};

/// Runs the program by way of a shell that has first done `limit`. Its exit code, and what it said.
fn limited(folder: &Folder, limit: &str, line: &str) -> (Option<i32>, String) {
    let done = Command::new("sh")
        .arg("-c")
        .arg(format!("{limit}; exec \"$0\" {line}"))
        .arg(env!("CARGO_BIN_EXE_polyreel"))
        .current_dir(folder.path(""))
        .output()
        .expect("a shell");
    (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
}

#[test]
fn a_standard_error_that_is_full_or_closed_is_no_failure() {
    let folder = Folder::new();
    folder.still("in.png", 48, 32);
    for (n, redirect) in ["2>/dev/full", "2>&-"].into_iter().enumerate() {
        let (code, _) =
            limited(&folder, "true", &format!("render in.png -o {n}.png -v {redirect}"));
        assert_eq!(code, Some(0), "{redirect}");
        assert_eq!(folder.open(&format!("{n}.png")).dimensions(), (48, 32));
        let (code, _) = limited(&folder, "true", &format!("render none.png -o x.png {redirect}"));
        assert_eq!(code, Some(1), "{redirect}");
    }
    let full = File::options().write(true).open("/dev/full").expect("Linux has it");
    let status = Command::new(env!("CARGO_BIN_EXE_polyreel"))
        .args(["render", "none.png", "-o", "x.png"])
        .stderr(Stdio::from(full))
        .status()
        .expect("the program");
    assert_eq!(status.code(), Some(1));
}

#[test]
fn threads_are_limited() {
    let folder = Folder::new();
    folder.still("in.png", 48, 32);
    for threads in ["257", "5000", "4294967295"] {
        folder.run(&format!("render in.png -o out.png --threads {threads}")).failure().code(2);
    }
    folder.run("render in.png -o out.png --threads 3").success();
}

#[test]
fn limits_of_files_and_memory_are_errors_that_leave_nothing() {
    let folder = Folder::new();
    folder.sequence("in", 12);
    let before = folder.listing();
    let (code, said) = limited(&folder, "ulimit -f 4", "render in -o out.y4m");
    assert_eq!(code, Some(1), "{said}");
    assert!(said.starts_with("polyreel: error: "), "{said}");
    assert_eq!(folder.listing(), before);
    folder.write(
        "vast.gif",
        b"GIF89a\0\x40\0\x40\x80\0\0\0\0\0\xff\xff\xff,\0\0\0\0\0\x40\0\x40\0\x02\x02L\x01\0;",
    );
    let (code, said) = limited(&folder, "ulimit -v 700000", "render vast.gif -o out.gif");
    assert_eq!(code, Some(1), "{said}");
    assert!(!folder.listing().iter().any(|name| name.contains("out") || name.starts_with('.')));
}

#[test]
fn control_characters_reach_no_terminal() {
    let folder = Folder::new();
    folder.write("in.y4m", b"YUV4MPEG2 W16 H16 C\x1b]0;owned\x07\x1b[31mred\nFRAME\n");
    let said = stderr(&folder.run("render in.y4m -o out.gif").failure().code(1));
    assert!(said.contains("\\u{1b}") && !said.contains('\x1b') && !said.contains('\x07'), "{said}");
    folder.write("a\u{9b}\u{202e}.png", b"x");
    let args = ["render", "a\u{9b}\u{202e}.png", "-o", "out.png"];
    let said = stderr(&folder.run_args(&args).failure().code(1));
    assert!(!said.contains(['\u{9b}', '\u{202e}']), "{said}");
}

#[test]
fn links_are_written_through_and_modes_are_kept() {
    let folder = Folder::new();
    folder.still("in.png", 48, 32);
    symlink("there.png", folder.path("link.png")).expect("a link");
    folder.run("render in.png -o link.png").success();
    folder.run("render in.png -o link.png").failure().code(1);
    fs::set_permissions(folder.path("there.png"), PermissionsExt::from_mode(0o640))
        .expect("a mode");
    folder.run("render in.png -o link.png -y").success();
    assert!(fs::symlink_metadata(folder.path("link.png")).expect("a link").is_symlink());
    let mode = fs::metadata(folder.path("there.png")).expect("a file").permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
}
