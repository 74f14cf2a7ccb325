//! Inputs and command lines that cannot be meant: one clear message, exit code 1 or 2, nothing left.

use std::fs;

use assert_cmd::Command;

use super::{Folder, stderr, stdout};

/// Asserts that `line` fails with `code`, says something with `words` in it, in one line, and leaves
/// the folder as it was.
fn refused(folder: &Folder, line: &str, code: i32, words: &[&str]) {
    let before = folder.listing();
    let done = folder.run(line).failure().code(code);
    let said = stderr(&done);
    assert!(said.starts_with("polyreel: error: "), "{line}: {said}");
    assert_eq!(said.lines().count(), 1, "{line}: {said}");
    assert!(words.iter().all(|word| said.contains(word)), "{line}: {said}");
    assert_eq!(stdout(&done), "", "{line}");
    assert_eq!(folder.listing(), before, "{line} left something behind");
}

#[test]
fn files_that_are_no_pictures() {
    let folder = Folder::new();
    folder.write("empty.png", b"");
    folder.write("text.png", b"Dear diary,\ntoday I am a picture.\n");
    fs::create_dir(folder.path("bare")).expect("a new folder");
    for command in ["render", "inspect"] {
        let output = if command == "render" { "out.png" } else { "out" };
        for input in ["empty.png", "text.png", "none.png", "bare", "none/%d.png", "none*.png"] {
            refused(&folder, &format!("{command} {input} -o {output}"), 1, &[]);
        }
    }
    refused(&folder, "info text.png", 1, &["text.png"]);
}

#[test]
fn what_can_be_read_only_once_cannot_be_looped() {
    let folder = Folder::new();
    folder.still("in.png", 48, 32);
    let done = Command::new(env!("CARGO_BIN_EXE_polyreel"))
        .current_dir(folder.path("."))
        .args(["render", "-", "-o", "out.gif", "--loop"])
        .write_stdin(*b"YUV4MPEG2 W4 H4 F25:1 C420jpeg\nFRAME\n012345670123456701234567")
        .assert()
        .code(2);
    assert!(stderr(&done).contains("only once"), "{}", stderr(&done));
    assert_eq!(folder.listing(), ["in.png"]);
    // A still has no end that could lead anywhere.
    folder.run("render in.png -o out.png --loop").success();
    folder.run("render in.png -o plain.png").success();
    assert!(folder.read("out.png") == folder.read("plain.png"));
}

#[test]
fn pictures_that_break_off() {
    let folder = Folder::new();
    folder.still("in.png", 120, 90);
    folder.still("in.jpg", 120, 90);
    folder.gif("in.gif", &[100; 5]);
    for (name, output) in [("in.png", "out.png"), ("in.jpg", "out.png"), ("in.gif", "out.gif")] {
        let whole = folder.read(name);
        for part in [whole.len() / 2, whole.len() - 20, 30] {
            folder.write(&format!("cut-{name}"), &whole[..part]);
            refused(
                &folder,
                &format!("render cut-{name} -o {output}"),
                1,
                &[&format!("cut-{name}")],
            );
        }
    }
}

#[test]
fn a_gif_that_breaks_off_can_be_kept() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100; 6]);
    let whole = folder.read("in.gif");
    folder.write("cut.gif", &whole[..whole.len() / 2]);
    folder.run("render cut.gif -o out.gif --allow-truncated").success();
    let kept = folder.delays("out.gif").len();
    assert!((1..6).contains(&kept), "{kept} frames");
}

#[test]
fn a_broken_frame_of_a_sequence_is_named() {
    let folder = Folder::new();
    folder.sequence("in", 5);
    let whole = folder.read("in/f3.png");
    folder.write("in/f3.png", &whole[..whole.len() / 2]);
    refused(&folder, "render in -o out.gif", 1, &["f3.png"]);
    refused(&folder, "render in -o out/", 1, &["f3.png"]);
    refused(&folder, "render in -o out_%d.png", 1, &["f3.png"]);
}

#[test]
fn frames_of_two_sizes() {
    let folder = Folder::new();
    folder.sequence("in", 3);
    folder.still("in/f9.png", 20, 20);
    refused(&folder, "render in -o out.gif", 1, &["f9.png", "20x20", "48x32"]);
}

/// A PNG header that promises `side` x `side` pixels.
fn huge_png(side: u32) -> Vec<u8> {
    let mut chunk = b"IHDR".to_vec();
    chunk.extend([side.to_be_bytes(), side.to_be_bytes()].concat());
    chunk.extend([8, 6, 0, 0, 0]);
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\x0d".to_vec();
    png.extend(&chunk);
    png.extend(crc32(&chunk).to_be_bytes());
    png.extend(b"\0\0\0\x0aIDAT");
    png.extend([0u8; 14]);
    png
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

#[test]
fn headers_that_claim_too_much() {
    let folder = Folder::new();
    folder.write("huge.png", &huge_png(60_000));
    folder.write(
        "huge.gif",
        b"GIF89a\x60\xea\x60\xea\x80\0\0\0\0\0\xff\xff\xff,\0\0\0\0\x60\xea\x60\xea\0\x02\x02L\x01\0;",
    );
    refused(&folder, "render huge.png -o out.png", 1, &["huge.png", "60000"]);
    refused(&folder, "render huge.gif -o out.gif", 1, &["huge.gif", "60000"]);
    refused(&folder, "inspect huge.png -o out", 1, &["60000"]);
}

#[test]
fn outputs_that_cannot_be() {
    let folder = Folder::new();
    folder.still("in.png", 40, 30);
    folder.gif("in.gif", &[100; 3]);
    fs::create_dir(folder.path("folder.png")).expect("a new folder");
    folder.write("file", b"x");
    refused(&folder, "render in.png -o none/out.png", 1, &["none"]);
    refused(&folder, "render in.png -o file/out.png", 1, &["file"]);
    refused(&folder, "render in.png -o in.png", 1, &["input"]);
    refused(&folder, "render in.png -o in.png -y", 1, &["input"]);
    refused(&folder, "render in.gif -o ./in.gif -y", 1, &["input"]);
    refused(&folder, "render in.png -o out.xyz", 2, &["out.xyz"]);
    refused(&folder, "render in.png -o out", 2, &["out"]);
    refused(&folder, "inspect in.png -o file", 1, &["file"]);
}

#[test]
fn an_animation_does_not_fit_into_a_picture() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100; 3]);
    refused(&folder, "render in.gif -o out.png", 2, &["out_%04d.png", "out.gif"]);
}

#[test]
fn command_lines_that_cannot_be_meant() {
    let folder = Folder::new();
    folder.still("in.png", 40, 30);
    refused(&folder, "render in.png", 2, &["-o"]);
    refused(&folder, "render in.png out.gif", 2, &["did you mean -o out.gif?"]);
    refused(&folder, "render in.png -o out.png --points 0", 2, &["points"]);
    refused(&folder, "render in.png -o out.png --points 200%", 2, &["points"]);
    refused(&folder, "render in.png -o out.png --clusters 1", 2, &["clusters"]);
    refused(&folder, "render in.png -o out.png --preset nothing", 2, &["nothing", "paper"]);
    refused(&folder, "render in.png -o out.png --max-size 0", 2, &["0"]);
    // These are clap's own messages.
    for line in ["", "render", "paint in.png", "render in.png -o out.png --fps never", "info"] {
        folder.run(line).failure().code(2);
    }
    assert_eq!(folder.listing(), ["in.png"]);
}
