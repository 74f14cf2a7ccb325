//! The program itself, on inputs made here: what it writes, says and returns.

mod bad;
mod batch;
mod budget;
mod evaluate;
mod faults;
mod films;
mod interrupt;
mod limits;
mod looks;
mod manners;
mod no_display;
mod player;
mod render;
mod tell;
mod usd;
mod vector;

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use image::{Delay, RgbaImage};
use tempfile::TempDir;

/// A folder to work in, in which `polyreel` is run.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs `polyreel` with the words of `line`.
    fn run(&self, line: &str) -> Assert {
        self.run_args(&line.split_whitespace().collect::<Vec<_>>())
    }

    fn run_args(&self, args: &[&str]) -> Assert {
        Command::new(env!("CARGO_BIN_EXE_polyreel")).current_dir(self.0.path()).args(args).assert()
    }

    /// Everything in the folder, folders with what is in them, sorted.
    fn listing(&self) -> Vec<String> {
        fn walk(folder: &Path, prefix: &str, names: &mut Vec<String>) {
            for entry in fs::read_dir(folder).expect("a folder") {
                let entry = entry.expect("an entry");
                let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
                if entry.path().is_dir() {
                    walk(&entry.path(), &format!("{name}/"), names);
                }
                names.push(name);
            }
        }
        let mut names = Vec::new();
        walk(self.0.path(), "", &mut names);
        names.sort();
        names
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).expect("a writable folder");
    }

    /// Writes a picture, in the format that its name says.
    fn still(&self, name: &str, width: u32, height: u32) {
        picture(width, height, 0).save(self.path(name)).expect("a writable folder");
    }

    /// Writes `frames` pictures of 48x32 to `folder`.
    fn sequence(&self, folder: &str, frames: u32) {
        fs::create_dir(self.path(folder)).expect("a new folder");
        for t in 0..frames {
            let name = self.path(folder).join(format!("f{t}.png"));
            picture(48, 32, t).save(name).expect("a writable folder");
        }
    }

    /// Writes an endless GIF of 48x32 with the `delays` in milliseconds.
    fn gif(&self, name: &str, delays: &[u32]) {
        use image::codecs::gif::{GifEncoder, Repeat};
        let file = fs::File::create(self.path(name)).expect("a writable folder");
        let mut encoder = GifEncoder::new(file);
        encoder.set_repeat(Repeat::Infinite).expect("a GIF");
        for (&delay, t) in delays.iter().zip(0..) {
            let picture = image::DynamicImage::from(picture(48, 32, t)).to_rgba8();
            let delay = Delay::from_numer_denom_ms(delay, 1);
            encoder.encode_frame(image::Frame::from_parts(picture, 0, 0, delay)).expect("a GIF");
        }
    }

    fn open(&self, name: &str) -> RgbaImage {
        image::open(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}")).to_rgba8()
    }

    /// The delays of a GIF's frames in milliseconds.
    fn delays(&self, name: &str) -> Vec<u32> {
        use image::AnimationDecoder;
        let bytes = std::io::Cursor::new(self.read(name));
        let decoder = image::codecs::gif::GifDecoder::new(bytes).expect("a GIF");
        let frames = decoder.into_frames().collect_frames().expect("complete frames");
        frames.iter().map(|frame| frame.delay().numer_denom_ms().0).collect()
    }

    fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(name)).expect("JSON")
    }
}

/// A disc over a gradient; it wanders with `t`.
fn picture(width: u32, height: u32, t: u32) -> image::RgbImage {
    image::RgbImage::from_fn(width, height, |x, y| {
        let (cx, cy) = ((width / 3 + 2 * t) as f64, f64::from(height) / 2.0);
        if (f64::from(x) - cx).hypot(f64::from(y) - cy) < f64::from(height) / 3.5 {
            image::Rgb([210, 40, 60])
        } else {
            image::Rgb([(x * 200 / width) as u8, (y * 200 / height) as u8, 120])
        }
    })
}

fn stderr(assert: &Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stderr).into_owned()
}

fn stdout(assert: &Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stdout).into_owned()
}
