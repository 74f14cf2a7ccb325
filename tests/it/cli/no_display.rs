//! Where there is no window to be had.

use assert_cmd::Command;

use super::stderr;

/// What the program says about `args` without any display. It fails with one sentence.
fn said(args: &[&str]) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    image::RgbImage::new(40, 30).save(folder.path().join("in.png")).expect("a writable folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_polyreel"));
    command.current_dir(folder.path()).args(args);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    let said = stderr(&command.assert().code(1));
    assert!(!said.contains("panicked"), "{said}");
    assert!(!folder.path().join("out.png").exists(), "nothing was rendered");
    assert_eq!(said.lines().count(), 1, "{said}");
    said
}

#[test]
fn no_display_is_one_sentence() {
    let expected = if cfg!(feature = "preview") { "display" } else { "built without its window" };
    for args in [&["preview", "in.png"][..], &["render", "in.png", "-o", "out.png", "--preview"]] {
        let said = said(args);
        assert!(said.starts_with("polyreel: error: preview: "), "{said}");
        assert!(said.contains(expected), "{said}");
    }
}
