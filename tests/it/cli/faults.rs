//! What the system does to a run: folders that cannot be written to or vanish, full disks, few open files, no
//! `/proc`, two runs of one output.
#![cfg(target_os = "linux")]

use std::fs;
use std::io::Write;
use std::process::{Child, ChildStdin, Command, Output, Stdio};

use super::Folder;
use crate::wait::until;

/// A render of y4m that comes in bit by bit.
struct Fed {
    child: Child,
    input: ChildStdin,
}

impl Fed {
    /// Starts a render to `output`, and waits until that is begun.
    fn begin(folder: &Folder, output: &str, more: &[&str]) -> Self {
        let place = folder.path(output).parent().expect("a folder").canonicalize();
        let place = place.expect("a folder");
        // A sequence waits in a folder of its own, other files have no name.
        let waiting = || {
            let names = fs::read_dir(&place).expect("a folder").flatten();
            names.filter(|name| name.file_name().to_string_lossy().starts_with('.')).count()
        };
        let before = waiting();
        let mut child = Command::new(env!("CARGO_BIN_EXE_polyreel"))
            .args(["render", "-", "-o", output, "--points", "20", "-q"])
            .args(more)
            .current_dir(folder.path(""))
            .stdin(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program");
        let mut input = child.stdin.take().expect("a pipe");
        input.write_all(b"YUV4MPEG2 W32 H24 F10:1 C420jpeg\n").expect("it reads");
        let id = child.id();
        until("an output that is begun", || {
            let open = fs::read_dir(format!("/proc/{id}/fd")).into_iter().flatten().flatten();
            let mut files = open.filter_map(|entry| fs::read_link(entry.path()).ok());
            let has_begun = files.any(|file| file.starts_with(&place)) || waiting() > before;
            has_begun.then_some(())
        });
        Self { child, input }
    }

    /// Feeds it a frame of one `level`, and ends the input.
    fn end(mut self, level: u8) -> Output {
        self.input.write_all(b"FRAME\n").expect("it reads");
        self.input.write_all(&[level; 32 * 24 * 3 / 2]).expect("it reads");
        drop(self.input);
        self.child.wait_with_output().expect("its end")
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn assert_failed(output: &Output, words: &str) {
    let said = said(output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("polyreel: error: ") && said.contains(words), "{said}");
}

#[test]
fn of_two_runs_of_one_output_the_second_to_end_is_refused() {
    let folder = Folder::new();
    fs::create_dir(folder.path("out")).expect("a new folder");
    for output in ["out/a.gif", "out/a.y4m", "out/a.polyreel"] {
        let (one, other) = (Fed::begin(&folder, output, &[]), Fed::begin(&folder, output, &[]));
        let first = other.end(40);
        assert!(first.status.success(), "{}", said(&first));
        let there = folder.read(output);
        assert_failed(&one.end(200), "exists already");
        assert!(folder.read(output) == there, "{output} is the first's");
        // With -y the last one wins, whole.
        let (one, other) =
            (Fed::begin(&folder, output, &["-y"]), Fed::begin(&folder, output, &["-y"]));
        assert!(other.end(200).status.success() && one.end(40).status.success());
        assert!(folder.read(output) == there);
        fs::remove_file(folder.path(output)).expect("it is there");
        assert_eq!(folder.listing(), ["out"], "{output}");
    }
}

#[test]
fn of_two_runs_of_one_sequence_the_second_to_end_is_refused() {
    let folder = Folder::new();
    let pattern = "a_%02d.png";
    let (one, other) = (Fed::begin(&folder, pattern, &[]), Fed::begin(&folder, pattern, &[]));
    assert!(other.end(40).status.success());
    let there = folder.read("a_01.png");
    assert_failed(&one.end(200), "exists already");
    assert_eq!(folder.listing(), ["a_01.png"]);
    assert!(folder.read("a_01.png") == there);
}

#[test]
fn a_folder_that_vanishes_is_an_error() {
    let folder = Folder::new();
    for output in ["out/a.gif", "out/a.y4m", "out/a_%d.png", "out/a.svg"] {
        fs::create_dir(folder.path("out")).expect("a new folder");
        let run = Fed::begin(&folder, output, &[]);
        fs::remove_dir_all(folder.path("out")).expect("it is there");
        assert_failed(&run.end(90), "out/a");
        assert!(folder.listing().is_empty(), "{output}: {:?}", folder.listing());
    }
}

#[test]
fn a_folder_that_cannot_be_written_to_is_an_error() {
    let folder = Folder::new();
    folder.still("in.png", 32, 24);
    // Nobody makes files there, root included.
    for output in ["/proc/polyreel.png", "/sys/polyreel.gif", "/proc/polyreel/", "/sys/%d.png"] {
        let output = folder.run(&format!("render in.png -o {output}")).failure().code(1);
        let said = super::stderr(&output);
        assert!(said.contains("cannot be written to"), "{said}");
    }
    assert_eq!(folder.listing(), ["in.png"]);
}

/// Runs `script` in `sh`, with the program as `$0`.
fn shell(folder: &Folder, script: &str) -> Output {
    Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_polyreel")])
        .current_dir(folder.path(""))
        .output()
        .expect("a shell")
}

#[test]
fn few_open_files_are_enough_or_an_error() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 40]);
    for files in 3..24 {
        let run =
            shell(&folder, &format!("ulimit -n {files}; exec \"$0\" render in.gif -o out.gif"));
        let there = fs::remove_file(folder.path("out.gif")).is_ok();
        assert_eq!(folder.listing(), ["in.gif"]);
        match run.status.code() {
            Some(0) => assert!(there, "{files} files"),
            // The system's loader may lack files, too: then the program does not even start.
            Some(1) | Some(127) => assert!(!there && files < 20, "{files} files: {}", said(&run)),
            code => panic!("{files} files: exit code {code:?}: {}", said(&run)),
        }
        assert!(!said(&run).contains("panicked"), "{files} files: {}", said(&run));
    }
}

#[test]
fn a_full_standard_output_is_an_error() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 40]);
    let full = shell(&folder, "exec \"$0\" render in.gif -o - >/dev/full");
    assert_failed(&full, "No space left");
    assert_eq!(folder.listing(), ["in.gif"]);
}

/// Runs `script` where file systems can be mounted; `None` where that is not allowed.
fn mounting(folder: &Folder, script: &str) -> Option<Output> {
    let may = Command::new("unshare").args(["-m", "mount", "-t", "tmpfs", "none", "/mnt"]).output();
    if !may.is_ok_and(|output| output.status.success()) {
        let _ = writeln!(std::io::stderr(), "SKIPPED: this test needs unshare and its permission");
        return None;
    }
    let run = Command::new("unshare")
        .args(["-m", "sh", "-c", script, env!("CARGO_BIN_EXE_polyreel")])
        .current_dir(folder.path(""))
        .output();
    Some(run.expect("unshare"))
}

#[test]
fn a_full_disk_is_an_error_that_leaves_nothing() {
    let folder = Folder::new();
    folder.sequence("in", 60);
    fs::create_dir(folder.path("small")).expect("a new folder");
    for output in ["a.gif", "a.y4m", "a_%d.png", "a.polyreel", "new/"] {
        let script = format!(
            "mount -t tmpfs -o size=4k none small && \"$0\" render in -o small/{output}; \
             code=$?; ls -A small; exit $code"
        );
        let Some(run) = mounting(&folder, &script) else { return };
        assert_failed(&run, "No space left");
        assert_eq!(String::from_utf8_lossy(&run.stdout), "", "{output}");
    }
}

#[test]
fn without_proc_outputs_are_the_same() {
    let folder = Folder::new();
    folder.gif("in.gif", &[100, 40]);
    folder.run("render in.gif -o usual.gif").success();
    let script = "mount -t tmpfs none /proc && \"$0\" render in.gif -o out.gif && \
                  \"$0\" render in.gif -o out/ && \"$0\" render in.gif -o out.gif -y";
    let Some(run) = mounting(&folder, script) else { return };
    assert!(run.status.success(), "{}", said(&run));
    assert!(folder.read("out.gif") == folder.read("usual.gif"));
    let wanted = ["in.gif", "out", "out.gif", "out/0001.png", "out/0002.png", "usual.gif"];
    assert_eq!(folder.listing(), wanted);
}
