//! A share of the mutations goes through the program itself, with little memory.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::corpus::{self, Seed, Use};
use super::{DEADLINE, count, kept, mutation};

/// One in this many.
const SHARE: u64 = 10;

/// The address space that the program may have: what its threads and a small picture take, and what a
/// decoder may ask for.
const KIB: u64 = 3 << 20;

#[test]
fn the_program_ends_in_bounds_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let seeds = corpus::seeds(folder.path());
    let work = folder.path().join("work");
    fs::create_dir(&work).expect("a new folder");
    fs::write(
        work.join("sound.gif"),
        &seeds.iter().find(|s| s.extension == "gif").expect("one").bytes,
    )
    .expect("a writable folder");
    for n in (0..count()).step_by(SHARE as usize) {
        // All seeds have their turn, whatever their number is.
        let (seed, bytes) = mutation(&seeds, n + n / SHARE % SHARE);
        fs::write(work.join(format!("in.{}", seed.extension)), &bytes).expect("a writable folder");
        if let Err(fault) = tried(&work, seed) {
            panic!("{}: {fault}", kept(&bytes, seed, n).display());
        }
    }
}

/// Runs the program on the mutation in `work` and cleans up. What is wrong with how it ended.
fn tried(work: &Path, seed: &Seed) -> Result<(), String> {
    let name = format!("in.{}", seed.extension);
    let line = match seed.used_as {
        Use::Input => format!("render {name} -o out.gif --points 30 --threads 1"),
        Use::Preset => format!("render sound.gif -o out.gif --preset {name} --threads 1"),
        Use::Report => format!("render sound.gif -o out.gif --replay {name} --threads 1"),
    };
    let before = listed(work);
    let (code, said) = run(work, &line)?;
    let after = listed(work);
    let _ = fs::remove_file(work.join("out.gif"));
    let _ = fs::remove_file(work.join(&name));
    if !matches!(code, Some(0..=2)) {
        return Err(format!("{line}: exit code {code:?}: {said}"));
    }
    // Warnings may come before the error.
    let explained = said.lines().any(|line| line.starts_with("polyreel: error: "));
    if said.contains("panicked") || (code != Some(0) && !explained) {
        return Err(format!("{line}: {said}"));
    }
    if code != Some(0) && before != after {
        return Err(format!("{line}: exit code {code:?}, and left {after:?}"));
    }
    if code == Some(0) && !after.contains(&"out.gif".to_owned()) {
        return Err(format!("{line}: exit code 0, and no output"));
    }
    Ok(())
}

/// The exit code and what was said, within the time and the memory that there is.
fn run(work: &Path, line: &str) -> Result<(Option<i32>, String), String> {
    let said = work.with_extension("said");
    let mut child = Command::new("sh")
        .arg("-c")
        .arg(format!("ulimit -v {KIB}; exec \"$0\" {line} --ffmpeg /nonexistent/ffmpeg"))
        .arg(env!("CARGO_BIN_EXE_polyreel"))
        .current_dir(work)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(File::create(&said).map_err(|error| error.to_string())?)
        .spawn()
        .map_err(|error| error.to_string())?;
    let began = Instant::now();
    let code = loop {
        if let Some(status) = child.try_wait().map_err(|error| error.to_string())? {
            break status.code();
        }
        if began.elapsed() > DEADLINE {
            let _ = child.kill();
            let _ = child.wait();
            return Err(format!("{line}: it does not end"));
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let said = fs::read(&said).map_err(|error| error.to_string())?;
    Ok((code, String::from_utf8_lossy(&said).into_owned()))
}

fn listed(work: &Path) -> Vec<String> {
    let entries = fs::read_dir(work).expect("a folder");
    let mut names: Vec<String> = entries
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}
