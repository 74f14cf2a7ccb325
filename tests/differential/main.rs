//! Random pictures of every format, read by the library and by two independent readers: Pillow (with libwebp,
//! libtiff and libjpeg-turbo) and ffmpeg. `make.py` makes them, from a seed.
//!
//! Needs Python with Pillow: without them the test is skipped, loudly, or fails if `REQUIRE_PYTHON=1`. `PYTHON`
//! names another interpreter, `SEED` and `COUNT` other files and more of them.
//!
//! Where both readers agree with each other, the library must agree with both; else with one of them.

use std::path::Path;
use std::process::Command;

use polyreel::frame::Frame;
use polyreel::source::{self, SourceOptions};

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/differential/make.py");

fn setting(name: &str, default: &str) -> String {
    std::env::var(name).unwrap_or_else(|_| default.to_owned())
}

/// Whether there is a Python that can make the files.
fn has_python(python: &str) -> bool {
    let asked = Command::new(python).args(["-c", "import PIL.Image"]).output();
    let there = asked.is_ok_and(|output| output.status.success());
    if !there {
        let words =
            format!("{python} with Pillow is not there: the differential test does not run");
        assert!(std::env::var("REQUIRE_PYTHON").is_err(), "{words}");
        eprintln!("SKIPPED: {words}");
    }
    there
}

/// How far two pictures are apart: the mean and the largest difference of a channel, colours multiplied by
/// alpha, since readers blend what is nearly transparent in more or fewer bits.
fn distance(ours: &[u8], theirs: &[u8]) -> (f64, u8) {
    let (mut sum, mut most) = (0u64, 0);
    let multiplied = |&[r, g, b, a]: &[u8; 4]| {
        let part = |v: u8| ((u32::from(v) * u32::from(a) + 127) / 255) as u8;
        [part(r), part(g), part(b), a]
    };
    for (a, b) in ours.as_chunks::<4>().0.iter().zip(theirs.as_chunks::<4>().0) {
        for (a, b) in multiplied(a).iter().zip(multiplied(b)) {
            sum += u64::from(a.abs_diff(b));
            most = most.max(a.abs_diff(b));
        }
    }
    (sum as f64 / ours.len().max(1) as f64, most)
}

/// What a reader made of a file.
struct Answer {
    name: String,
    size: (u32, u32),
    frames: Vec<Vec<u8>>,
}

impl Answer {
    /// Reads `name:width:height:frames` and the file with the frames.
    fn read(file: &Path, field: &str) -> Self {
        let parts: Vec<&str> = field.split(':').collect();
        let number = |i: usize| parts[i].parse::<u32>().expect("a number");
        let size = (number(1), number(2));
        let raw = std::fs::read(format!("{}.{}.rgba", file.display(), parts[0])).expect("frames");
        let length = (size.0 * size.1 * 4) as usize;
        let frames = raw.chunks(length).map(<[u8]>::to_vec).collect();
        Self { name: parts[0].to_owned(), size, frames }
    }

    /// Why this is not like the other frames; `None` if it is.
    fn differs(
        &self,
        size: (u32, u32),
        frames: &[&[u8]],
        (mean, most): (f64, u8),
    ) -> Option<String> {
        let name = &self.name;
        if self.size != size || self.frames.len() != frames.len() {
            let (n, of) = (self.frames.len(), frames.len());
            return Some(format!(
                "{name} has {n} frames of {:?}, here {of} of {size:?}",
                self.size
            ));
        }
        self.frames.iter().zip(frames).enumerate().find_map(|(i, (theirs, ours))| {
            let (apart, at_most) = distance(ours, theirs);
            (apart > mean || at_most > most)
                .then(|| format!("frame {i} is {apart:.2} and at most {at_most} from {name}'s"))
        })
    }
}

/// All frames, as the library decodes them.
fn decoded(file: &Path) -> Result<Vec<Frame>, String> {
    let input = source::open(&[file], &SourceOptions::default()).map_err(|e| e.to_string())?;
    let mut source = input.start().map_err(|e| e.to_string())?;
    let mut frames = Vec::new();
    while let Some(next) = source.next().map_err(|e| e.to_string())? {
        frames.push(next.frame);
    }
    Ok(frames)
}

/// What is wrong with the library's reading of the file of one line of `cases.txt`.
fn check(folder: &Path, line: &str) -> Option<String> {
    let fields: Vec<&str> = line.split('\t').collect();
    let file = folder.join(fields[0]);
    let tolerance = (fields[1].parse().expect("a mean"), fields[2].parse().expect("a difference"));
    let answers: Vec<Answer> = fields[3..].iter().map(|field| Answer::read(&file, field)).collect();
    let ours = match decoded(&file) {
        Ok(frames) => frames,
        Err(error) => return Some(format!("{}: {error}", fields[0])),
    };
    let size = ours.first().map_or((0, 0), |f| (f.size().width, f.size().height));
    let frames: Vec<&[u8]> = ours.iter().map(|f| f.pixels().as_flattened()).collect();
    let reasons: Vec<String> =
        answers.iter().filter_map(|a| a.differs(size, &frames, tolerance)).collect();
    let alike = match answers.as_slice() {
        [a, b] => {
            let frames: Vec<&[u8]> = b.frames.iter().map(Vec::as_slice).collect();
            a.differs(b.size, &frames, tolerance).is_none()
        }
        _ => true,
    };
    let wrong = if alike { !reasons.is_empty() } else { reasons.len() == answers.len() };
    wrong.then(|| format!("{}: {}", fields[0], reasons.join("; ")))
}

#[test]
fn every_format_is_read_as_other_readers_do() {
    let python = setting("PYTHON", "python3");
    if !has_python(&python) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (seed, count) = (setting("SEED", "1"), setting("COUNT", "20"));
    let made = Command::new(&python)
        .args([SCRIPT, "--seed", &seed, "--count", &count])
        .arg(folder.path())
        .status()
        .expect("python runs");
    assert!(made.success(), "make.py failed");
    let cases = std::fs::read_to_string(folder.path().join("cases.txt")).expect("cases");
    let wrong: Vec<String> = cases.lines().filter_map(|line| check(folder.path(), line)).collect();
    let all = cases.lines().count();
    assert!(wrong.is_empty(), "{} of {all} differ:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
#[cfg(target_os = "linux")]
fn files_that_claim_more_than_they_hold_take_little_memory() {
    let python = setting("PYTHON", "python3");
    if !has_python(&python) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/differential/memory.py");
    let run = Command::new(&python)
        .args([script, env!("CARGO_BIN_EXE_polyreel")])
        .arg(folder.path())
        .output()
        .expect("python runs");
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success() && said.is_empty(), "{said}");
}
