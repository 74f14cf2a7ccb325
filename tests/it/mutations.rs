//! Inputs that lie: every format, mutated by a seed. Whatever comes in, the program ends in time and in bounds
//! with exit code 0, 1 or 2, without a panic, and leaves nothing behind where it fails.
//!
//! `POLYREEL_MUTATIONS=10000 cargo test --test it mutations` tries more than the usual number, and
//! `POLYREEL_MUTATIONS_SEED=7` others.

mod corpus;
mod mend;
mod mutate;
#[cfg(unix)]
mod program;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::time::Duration;

use polyreel::options::{Options, Points};
use polyreel::render::Renderer;
use polyreel::source::{self, SourceOptions};

use corpus::{Seed, Use};
use mutate::Random;

/// How long one input may take, on a machine that is busy with other things.
const DEADLINE: Duration = Duration::from_secs(60);

/// Frames that are read of a stream.
const FRAMES: usize = 8;

/// The number in an environment variable.
fn setting(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// Inputs in all; POLYREEL_MUTATIONS says another number.
fn count() -> u64 {
    setting("POLYREEL_MUTATIONS").unwrap_or(1000)
}

/// Mutation number `n`: its seed, and its bytes.
fn mutation(seeds: &[Seed], n: u64) -> (&Seed, Vec<u8>) {
    let seed = &seeds[n as usize % seeds.len()];
    let first = setting("POLYREEL_MUTATIONS_SEED").unwrap_or(0) << 32;
    let mut random = Random::new(first.wrapping_add(n));
    let other = &seeds[random.below(seeds.len())];
    (seed, mutate::mutated(&seed.bytes, &other.bytes, seed.mend, &mut random))
}

#[test]
fn the_library_refuses_mutated_inputs_or_reads_them() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let seeds = corpus::seeds(folder.path());
    // Run in turns by this many threads: one that hangs is seen by who waits for it.
    let (done, ended) = channel();
    let root = folder.path().to_owned();
    std::thread::spawn(move || {
        for n in 0..count() {
            let (seed, bytes) = mutation(&seeds, n);
            let path = root.join(format!("mutated.{}", seed.extension));
            let read = catch_unwind(AssertUnwindSafe(|| read(&path, &bytes, seed)));
            if read.is_err() {
                let _ = done.send(Err(kept(&bytes, seed, n)));
                return;
            }
            if done.send(Ok(n)).is_err() {
                return;
            }
        }
    });
    let mut last = None;
    while last.is_none_or(|n| n + 1 < count()) {
        match ended.recv_timeout(DEADLINE) {
            Ok(Ok(n)) => last = Some(n),
            Ok(Err(input)) => panic!("{} makes the library panic", input.display()),
            Err(_) => panic!("the mutation after {last:?} does not end"),
        }
    }
}

/// Reads `bytes` as what they are a mutation of, and renders the first frame of what is small enough.
fn read(path: &Path, bytes: &[u8], seed: &Seed) {
    std::fs::write(path, bytes).expect("a writable folder");
    match seed.used_as {
        Use::Preset => {
            let _ = polyreel::preset::from_toml(&String::from_utf8_lossy(bytes));
        }
        Use::Report => {
            let _ = polyreel::pipeline::Script::read(path);
        }
        Use::Input => {
            let options = SourceOptions {
                // Nothing here is for ffmpeg, and nothing that looks like it may reach it.
                ffmpeg: std::path::PathBuf::from("/nonexistent/ffmpeg").into(),
                ..SourceOptions::default()
            };
            let Ok(input) = source::open(&[path], &options) else { return };
            if input.info().size.pixels() > 1 << 20 {
                return;
            }
            let Ok(mut source) = input.start() else { return };
            let mut first = None;
            for _ in 0..FRAMES {
                let Ok(Some(decoded)) = source.next() else { break };
                first.get_or_insert(decoded.frame);
            }
            if let Some(frame) = first.filter(|frame| frame.size().pixels() <= 1 << 14) {
                let options = Options { points: Points::Count(20), ..Options::default() };
                let mut renderer = Renderer::new(&options).expect("sound options");
                renderer.render(&frame).expect("any frame can be rendered");
            }
        }
    }
}

/// Where mutation `n` is kept, for whoever mends what it found.
fn kept(bytes: &[u8], seed: &Seed, n: u64) -> PathBuf {
    let path = std::env::temp_dir().join(format!("polyreel-mutation-{n}.{}", seed.extension));
    std::fs::write(&path, bytes).expect("a writable folder");
    path
}
