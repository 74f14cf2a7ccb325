//! Videos that lie: containers, mutated by a seed. Whatever ffmpeg makes of them, the program ends in time with
//! exit code 0, 1 or 2, without a panic, and leaves nothing behind where it fails.
//!
//! `POLYREEL_MUTATIONS=10000 cargo test --test video mutations` tries more of them: one in 25 of that number.

#[path = "../it/mutations/mutate.rs"]
mod mutate;

use std::fs::{self, File};
use std::process::Stdio;

use tempfile::TempDir;

use crate::given::*;
use crate::program::*;
use crate::wait::until;
use mutate::Random;

/// Runs of ffmpeg take long: this many take the time of one mutation without.
const SHARE: u64 = 25;

fn count() -> u64 {
    let more = std::env::var("POLYREEL_MUTATIONS").ok().and_then(|text| text.parse().ok());
    more.unwrap_or(1000u64).div_ceil(SHARE)
}

/// Small videos of every container that matters, by their extension.
fn seeds(dir: &TempDir) -> Vec<(&'static str, Vec<u8>)> {
    let scene = "-f lavfi -i testsrc2=s=48x32:r=10:d=0.6";
    let tone = "-f lavfi -i sine=d=0.6";
    let x264 = "-c:v libx264 -preset ultrafast -pix_fmt yuv420p";
    let vp9 = "-c:v libvpx-vp9 -pix_fmt yuva420p -deadline realtime -cpu-used 8";
    let rest = [
        ("mp4", format!("{scene} {tone} {x264} -bf 2 -c:a aac -shortest")),
        ("mkv", format!("{scene} {tone} {x264} -c:a aac -metadata title=seed")),
        ("webm", format!("{scene} {vp9}")),
        ("mov", format!("{scene} -c:v mjpeg -pix_fmt yuvj420p")),
        ("ts", format!("{scene} -c:v mpeg2video")),
        ("avi", format!("{scene} -c:v mpeg4")),
        ("flv", format!("{scene} {x264}")),
        ("nut", format!("{scene} -c:v ffv1")),
    ];
    let seed = |(ending, args): (&'static str, String)| {
        let path = make(dir, &format!("seed.{ending}"), &args);
        (ending, fs::read(path).expect("the seed"))
    };
    rest.into_iter().map(seed).collect()
}

#[test]
fn mutated_videos_are_refused_or_rendered() {
    if !require() {
        return;
    }
    let (made, work) = (folder(), folder());
    let seeds = seeds(&made);
    for n in 0..count() {
        let mut random = Random::new(n);
        let (ending, bytes) = &seeds[n as usize % seeds.len()];
        let (_, other) = &seeds[random.below(seeds.len())];
        let bytes = mutate::mutated(bytes, other, None, &mut random);
        let name = format!("in.{ending}");
        fs::write(work.path().join(&name), &bytes).expect("a writable folder");
        if let Err(fault) = tried(&work, &made, &name, n) {
            let kept = std::env::temp_dir().join(format!("polyreel-video-{n}.{ending}"));
            fs::write(&kept, &bytes).expect("a writable folder");
            panic!("{}: {fault}", kept.display());
        }
        fs::remove_file(work.path().join(&name)).expect("the input is left");
    }
}

/// Renders `name` in `work`, every other one with what can be kept. What is wrong with how that ended.
fn tried(work: &TempDir, made: &TempDir, name: &str, n: u64) -> Result<(), String> {
    let more = if n.is_multiple_of(2) { "--allow-truncated" } else { "" };
    // A video that claims to have many frames, or large ones, takes its time.
    let line = format!("render {name} -o out.gif --points 30 --frames 12 --max-size 64 {more}");
    let said = made.path().join("said");
    let mut child = polyreel(work, &line)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(File::create(&said).expect("a file"))
        .spawn()
        .expect("the program");
    let code = until("the program's end", || child.try_wait().expect("ours")).code();
    let said = String::from_utf8_lossy(&fs::read(&said).expect("what it said")).into_owned();
    let left = listing(work);
    let _ = fs::remove_file(work.path().join("out.gif"));
    if !matches!(code, Some(0..=2)) || said.contains("panicked") {
        return Err(format!("{line}: exit code {code:?}: {said}"));
    }
    let wanted = if code == Some(0) { vec![name, "out.gif"] } else { vec![name] };
    if left != wanted {
        return Err(format!("{line}: exit code {code:?}, and left {left:?}: {said}"));
    }
    Ok(())
}
