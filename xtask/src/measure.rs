//! Measures a constant again: the program is built with each of several values, and each build renders the
//! clips of the corpus.
//!
//! A comment in the sources names its measurement, `cargo xtask measure NAME`; the constant is the first one
//! below that comment. `constants.toml` has the values to try. The sources are copied, so that the working
//! tree stays as it is.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;
use serde_json::Value;

use crate::corpus::{self, Clip};
use crate::run::{cargo, output, run};
use crate::{Result, root, target};

#[derive(Deserialize)]
struct Manifest {
    constant: Vec<Experiment>,
}

/// An entry of the manifest.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Experiment {
    name: String,
    about: String,
    /// Rust expressions that are compared with the value in the sources.
    values: Vec<String>,
    /// Names of clips.
    clips: Vec<String>,
    /// Options of the program.
    #[serde(default)]
    args: Vec<String>,
}

/// A constant as it stands in a source file.
struct Constant {
    file: PathBuf,
    name: String,
    value: String,
    /// Where the value stands in the file.
    range: std::ops::Range<usize>,
}

/// What one build gave on one clip.
struct Figures {
    /// Median milliseconds of a frame on one thread, without decoding and encoding.
    ms: f64,
    mse: f64,
    ssim: f64,
    /// Flicker; `None` for a still.
    fdb: Option<f64>,
}

/// Prints what can be measured. Each entry of the manifest must have its constant.
///
/// # Errors
/// When a constant is not found.
pub(crate) fn list() -> Result<()> {
    for experiment in experiments()? {
        let constant = find(root(), &experiment.name)?;
        println!(
            "{:24} {} = {}: {}",
            experiment.name, constant.name, constant.value, experiment.about
        );
    }
    Ok(())
}

/// Measures the constant of the experiment `name` and prints a table.
///
/// # Errors
/// When no experiment has that name, an option is unknown, or a build or a render fails.
pub(crate) fn measure(name: &str, options: &[&str]) -> Result<()> {
    let (mut frames, mut word) = (None, "");
    for pair in options.chunks(2) {
        match *pair {
            ["--frames", count] => frames = Some(count.parse::<u32>()?),
            ["--clips", part] => word = part,
            _ => return Err(format!("unknown option: {}", pair.join(" ")).into()),
        }
    }
    let all = experiments()?;
    let found = all.into_iter().find(|experiment| experiment.name == name);
    let experiment =
        found.ok_or_else(|| format!("there is no '{name}': cargo xtask measure lists them"))?;
    let clips: Vec<Clip> = corpus::clips()?
        .into_iter()
        .filter(|clip| experiment.clips.contains(&clip.name) && clip.name.contains(word))
        .collect();
    let copy = target().join("measure/source");
    copy_sources(&copy)?;
    let constant = find(&copy, name)?;
    let mut values = vec![constant.value.clone()];
    values.extend(experiment.values.iter().filter(|&value| *value != constant.value).cloned());

    println!("{}, {} (the first value is that of the sources)\n", constant.name, experiment.about);
    println!("| value | clip | ms a frame | MSE | 1 - SSIM | FDB |\n|---|---|--:|--:|--:|--:|");
    let mut before = BTreeMap::new();
    for value in values {
        let program = build(&copy, &constant, &value)?;
        for clip in &clips {
            let figures = figures(&program, clip, frames.unwrap_or(clip.frames), &experiment.args)?;
            let first = before.entry(clip.name.clone()).or_insert_with(|| figures.as_list());
            println!("| {value} | {} | {} |", clip.name, figures.relative_to(first).join(" | "));
        }
    }
    Ok(())
}

impl Figures {
    fn as_list(&self) -> [Option<f64>; 4] {
        [Some(self.ms), Some(self.mse), Some(1.0 - self.ssim), self.fdb]
    }

    /// Each figure, and its ratio to the one of the value in the sources.
    fn relative_to(&self, first: &[Option<f64>; 4]) -> Vec<String> {
        let pairs = self.as_list().into_iter().zip(first);
        let cell = |(now, first): (Option<f64>, &Option<f64>)| match (now, first) {
            (Some(now), Some(first)) => format!("{now:.3} ({:.3})", now / first),
            _ => String::new(),
        };
        pairs.map(cell).collect()
    }
}

fn experiments() -> Result<Vec<Experiment>> {
    let text = fs::read_to_string(root().join("xtask/constants.toml"))?;
    Ok(toml::from_str::<Manifest>(&text)?.constant)
}

/// Files of the repository that builds need.
fn tracked() -> Result<Vec<PathBuf>> {
    let names = output(Command::new("git").current_dir(root()).args(["ls-files", "-z"]))?;
    let names = String::from_utf8(names)?;
    Ok(names.split('\0').filter(|name| !name.is_empty()).map(PathBuf::from).collect())
}

/// Copies what has changed, so that builds are incremental.
fn copy_sources(to: &Path) -> Result<()> {
    for name in tracked()? {
        let (from, to) = (root().join(&name), to.join(&name));
        let Ok(bytes) = fs::read(&from) else { continue };
        if fs::read(&to).is_ok_and(|there| there == bytes) {
            continue;
        }
        fs::create_dir_all(to.parent().ok_or("a file has a folder")?)?;
        fs::write(to, bytes)?;
    }
    Ok(())
}

/// The constant below the comment that names `name`.
fn find(root: &Path, name: &str) -> Result<Constant> {
    let words = format!("cargo xtask measure {name}`");
    let mut found = Vec::new();
    for file in tracked()? {
        let is_source = file.extension().is_some_and(|extension| extension == "rs");
        if !is_source || file.starts_with("xtask") {
            continue;
        }
        let Ok(text) = fs::read_to_string(root.join(&file)) else { continue };
        // A comment may break the line between two words.
        if let Some(at) = position(&text, &words) {
            found.push(constant_after(&text, at, file)?);
        }
    }
    match found.len() {
        1 => Ok(found.remove(0)),
        count => {
            Err(format!("{count} comments name `cargo xtask measure {name}`, there must be one")
                .into())
        }
    }
}

/// Where `words` end in `text`, spaces standing for line breaks of a comment too.
fn position(text: &str, words: &str) -> Option<usize> {
    let pieces: Vec<&str> = words.split(' ').collect();
    text.match_indices(pieces[0]).find_map(|(at, first)| {
        let mut end = at + first.len();
        for piece in &pieces[1..] {
            let skipped = text[end..].trim_start_matches([' ', '\n', '/']);
            end = text.len() - skipped.len();
            end += skipped.starts_with(piece).then_some(piece.len())?;
        }
        Some(end)
    })
}

/// The first `const NAME: TYPE = VALUE;` after `at`.
fn constant_after(text: &str, at: usize, file: PathBuf) -> Result<Constant> {
    let wrong = || format!("{}: no constant follows the comment", file.display());
    let start = at + text[at..].find("const ").ok_or_else(wrong)? + "const ".len();
    let colon = start + text[start..].find(':').ok_or_else(wrong)?;
    let equals = start + text[start..].find(" = ").ok_or_else(wrong)? + 3;
    let end = equals + text[equals..].find(';').ok_or_else(wrong)?;
    let (name, value) = (text[start..colon].to_string(), text[equals..end].to_string());
    Ok(Constant { file, name, value, range: equals..end })
}

/// Builds the copy with `value` in place of the constant's.
fn build(copy: &Path, constant: &Constant, value: &str) -> Result<PathBuf> {
    let mut text = fs::read_to_string(root().join(&constant.file))?;
    text.replace_range(constant.range.clone(), value);
    fs::write(copy.join(&constant.file), text)?;
    let target = target().join("measure/target");
    let mut command = cargo(copy);
    command.args(["build", "--quiet", "--release", "--locked", "--bin", "polyreel"]);
    run(command.env("CARGO_TARGET_DIR", &target))?;
    Ok(target.join("release").join(format!("polyreel{}", std::env::consts::EXE_SUFFIX)))
}

/// Renders a clip for its time, and evaluates it for likeness and flicker.
fn figures(program: &Path, clip: &Clip, frames: u32, args: &[String]) -> Result<Figures> {
    let (path, frames) = (clip.get()?, frames.to_string());
    let report = target().join("measure/report.json");
    let mut ms = f64::INFINITY;
    // The least of three: what else the machine does only adds to it.
    for _ in 0..3 {
        let mut render = Command::new(program);
        render.arg("render").arg(&path).args([
            "-o",
            "null:",
            "-q",
            "--threads",
            "1",
            "--frames",
            &frames,
        ]);
        run(render.args(args).arg("--report").arg(&report))?;
        ms = ms.min(frame_ms(&json(&report)?));
    }
    let mut evaluate = Command::new(program);
    evaluate.arg("evaluate").arg(&path).args(["--methods", "hrlp", "--no-robustness", "-q", "-y"]);
    evaluate.args(["--frames", &frames]).arg(format!("--json={}", report.display()));
    run(evaluate.args(args))?;
    let found = json(&report)?;
    let kind = if frames == "1" { "stills" } else { "clips" };
    let refined = &found["evaluation"][kind][0]["refined"][0];
    let figure = |name: &str| refined[name].as_f64();
    let missing = || format!("the evaluation of {} has no figures", clip.name);
    Ok(Figures {
        ms,
        mse: figure("mse").ok_or_else(missing)?,
        ssim: figure("ssim").ok_or_else(missing)?,
        fdb: figure("fdb"),
    })
}

fn json(path: &Path) -> Result<Value> {
    Ok(serde_json::from_slice(&fs::read(path)?)?)
}

/// Median time of a frame over the stages that compute.
fn frame_ms(report: &Value) -> f64 {
    let stages = ["features", "sample", "triangulate", "refine", "rasterise"];
    let frames = report["per_frame"].as_array().map_or(&[][..], Vec::as_slice);
    let time =
        |frame: &Value| stages.iter().filter_map(|stage| frame["ms"][stage].as_f64()).sum::<f64>();
    let mut times: Vec<f64> = frames.iter().map(time).collect();
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_is_found_below_its_comment_whatever_the_line_breaks() {
        let text = "const A: u32 = 1;\n/// So it is (`cargo xtask\n/// measure some-share`).\n\
                    pub(crate) const SHARE: f64 = 1.0 / 4.0;\n";
        let at = position(text, "cargo xtask measure some-share`").expect("it is named");
        let found = constant_after(text, at, "a.rs".into()).expect("a constant follows");
        assert_eq!((found.name.as_str(), found.value.as_str()), ("SHARE", "1.0 / 4.0"));
        assert_eq!(&text[found.range], "1.0 / 4.0");
        assert_eq!(position(text, "cargo xtask measure some`"), None);
    }

    #[test]
    fn the_manifest_and_the_corpus_can_be_read() {
        let clips = corpus::clips().expect("a corpus");
        for experiment in experiments().expect("a manifest") {
            for clip in &experiment.clips {
                assert!(clips.iter().any(|known| known.name == *clip), "there is no clip {clip}");
            }
        }
    }
}
