//! Release archives: the program with completions, man pages and licences.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::run::{cargo, output, run};
use crate::{Result, root, target};

const SHELLS: [&str; 5] = ["bash", "elvish", "fish", "powershell", "zsh"];
const PAPERS: [&str; 4] = ["README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT"];
const WINDOWS: &str = "x86_64-pc-windows-gnu";

/// A file of an archive.
struct Entry {
    name: String,
    bytes: Vec<u8>,
    is_program: bool,
}

/// Packs archives for `systems` (all where none is named) into `target/dist-archives`.
///
/// # Errors
/// When a system is unknown, a build fails, or a file cannot be written.
pub(crate) fn dist(systems: &[&str]) -> Result<()> {
    if let Some(unknown) = systems.iter().find(|name| !["linux", "windows"].contains(name)) {
        return Err(format!("there is no system '{unknown}': there are linux and windows").into());
    }
    let is_wanted = |name: &str| systems.is_empty() || systems.contains(&name);
    // Completions and man pages are printed by the program of this machine, for all systems.
    let native = build_here()?;
    let papers = papers(&native)?;
    let folder = target().join("dist-archives");
    fs::create_dir_all(&folder)?;
    let stem = format!("polyreel-{}", env!("CARGO_PKG_VERSION"));
    if is_wanted("linux") {
        let stem = format!("{stem}-{}-linux", std::env::consts::ARCH);
        let archive = folder.join(format!("{stem}.tar.gz"));
        write_tar(&archive, &stem, &with_program("polyreel", &native, &papers)?)?;
        println!("{}", archive.display());
    }
    if is_wanted("windows") {
        let program = build_for_windows()?;
        let stem = format!("{stem}-x86_64-windows");
        let archive = folder.join(format!("{stem}.zip"));
        write_zip(&archive, &stem, &with_program("polyreel.exe", &program, &papers)?)?;
        println!("{}", archive.display());
    }
    Ok(())
}

fn build_here() -> Result<PathBuf> {
    run(cargo(root()).args(["build", "--locked", "--profile", "dist", "--bin", "polyreel"]))?;
    Ok(target().join("dist").join(format!("polyreel{}", std::env::consts::EXE_SUFFIX)))
}

/// Builds with the target that rustup has installed, or else in the Debian root of `.ci/forky`.
fn build_for_windows() -> Result<PathBuf> {
    let args = ["build", "--locked", "--profile", "dist", "--bin", "polyreel", "--target", WINDOWS];
    let libraries =
        output(Command::new("rustc").args(["--print", "target-libdir", "--target", WINDOWS]))?;
    if Path::new(String::from_utf8_lossy(&libraries).trim()).is_dir() {
        run(cargo(root()).args(args))?;
        return Ok(target().join(WINDOWS).join("dist/polyreel.exe"));
    }
    let mut inside = Command::new(root().join(".ci/in-forky"));
    inside.args(["env", "RUSTC_BOOTSTRAP=1", "cargo"]).args(args);
    run(inside.arg("-Zbuild-std=std,panic_unwind"))?;
    let forky = output(&mut Command::new(root().join(".ci/forky")))?;
    let forky = PathBuf::from(String::from_utf8_lossy(&forky).trim());
    Ok(forky.join("target").join(WINDOWS).join("dist/polyreel.exe"))
}

/// The files of every archive besides the program: texts, completions and man pages.
fn papers(program: &Path) -> Result<Vec<Entry>> {
    let text = |name: String, bytes| Entry { name, bytes, is_program: false };
    let mut entries = Vec::new();
    for name in PAPERS {
        entries.push(text(name.into(), fs::read(root().join(name))?));
    }
    for shell in SHELLS {
        let script = output(Command::new(program).args(["completions", shell]))?;
        entries.push(text(format!("completions/{}", completion_file(shell)), script));
    }
    entries.push(text("man/polyreel.1".into(), output(Command::new(program).arg("man"))?));
    for command in commands(program)? {
        let page = output(Command::new(program).args(["man", &command]))?;
        entries.push(text(format!("man/polyreel-{command}.1"), page));
    }
    Ok(entries)
}

/// The file name of the completion script of a shell.
fn completion_file(shell: &str) -> &'static str {
    match shell {
        "bash" => "polyreel",
        "elvish" => "polyreel.elv",
        "fish" => "polyreel.fish",
        "powershell" => "_polyreel.ps1",
        _ => "_polyreel",
    }
}

/// The program's commands, as its help lists them.
fn commands(program: &Path) -> Result<Vec<String>> {
    let help = String::from_utf8(output(Command::new(program).arg("--help"))?)?;
    let list = help.split("Commands:").nth(1).ok_or("the help lists no commands")?;
    let lines = list.lines().skip(1).take_while(|line| !line.trim().is_empty());
    // Lines that go on a description are indented further.
    let first = lines.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = first.filter_map(|line| line.split_whitespace().next());
    Ok(names.filter(|&name| name != "help").map(String::from).collect())
}

fn with_program(name: &str, program: &Path, papers: &[Entry]) -> Result<Vec<Entry>> {
    let program = Entry { name: name.into(), bytes: fs::read(program)?, is_program: true };
    let copies = papers.iter().map(|entry| Entry {
        name: entry.name.clone(),
        bytes: entry.bytes.clone(),
        ..*entry
    });
    Ok(std::iter::once(program).chain(copies).collect())
}

/// Times and owners are constant, so that the same files give the same archive.
fn write_tar(path: &Path, stem: &str, entries: &[Entry]) -> Result<()> {
    let mut archive = tar::Builder::new(GzEncoder::new(File::create(path)?, Compression::best()));
    for entry in entries {
        let mut header = tar::Header::new_gnu();
        header.set_size(entry.bytes.len() as u64);
        header.set_mode(if entry.is_program { 0o755 } else { 0o644 });
        header.set_mtime(0);
        archive.append_data(&mut header, format!("{stem}/{}", entry.name), &entry.bytes[..])?;
    }
    archive.into_inner()?.finish()?.sync_all()?;
    Ok(())
}

fn write_zip(path: &Path, stem: &str, entries: &[Entry]) -> Result<()> {
    let mut archive = zip::ZipWriter::new(File::create(path)?);
    for entry in entries {
        let mode = if entry.is_program { 0o755 } else { 0o644 };
        let options = zip::write::SimpleFileOptions::default().unix_permissions(mode);
        archive.start_file(format!("{stem}/{}", entry.name), options)?;
        archive.write_all(&entry.bytes)?;
    }
    archive.finish()?.sync_all()?;
    Ok(())
}
