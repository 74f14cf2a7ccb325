//! `polyreel render --plan --all`: all chunks, by several processes.

use std::io;
use std::num::NonZeroUsize;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use polyreel::error::{Error, Result};
use polyreel::film::part::{self, Stale};
use polyreel::film::plan::Chunk;

use super::Work;
use super::bar::Bar;
use super::chunk::{name, render_chunk};
use crate::program::{itself, terminal};

/// The cores of this machine that may be used.
pub(super) fn cores() -> NonZeroUsize {
    thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

/// Renders all chunks that are not there, `jobs` at a time. The longest come first, so that none is left
/// alone at the end.
///
/// # Errors
/// When a chunk failed; the others are rendered all the same.
pub(super) fn render_all(
    work: &Work,
    jobs: NonZeroUsize,
    threads: Option<NonZeroUsize>,
) -> Result<()> {
    let began = Instant::now();
    let mut missing: Vec<&Chunk> =
        work.plan.chunks.iter().filter(|chunk| !is_there(work, chunk)).collect();
    let there = work.plan.chunks.len() - missing.len();
    let frames: u64 = missing.iter().map(|chunk| chunk.frames).sum();
    let jobs = jobs.get().min(missing.len().max(1));
    let failed = if jobs == 1 {
        missing
            .iter()
            .find_map(|chunk| render_chunk(work, chunk, threads).err().map(|error| (1, error)))
    } else {
        missing.sort_by_key(|chunk| chunk.frames);
        let threads = threads.unwrap_or_else(|| share(jobs));
        by_processes(work, missing, jobs, threads)
    };
    if let Some((count, error)) = failed {
        if count > 1 {
            terminal::say(format_args!("{count} chunks failed; run the same command again"));
        }
        return Err(error);
    }
    if !work.quiet {
        let wall = began.elapsed().as_secs_f64();
        let folder = work.folder.display();
        let total = work.plan.chunks.len();
        terminal::say(format_args!(
            "{folder}: {total} chunks are there, {there} were before; {frames} frames in {wall:.2} s ({:.1} fps)",
            frames as f64 / wall
        ));
    }
    Ok(())
}

fn is_there(work: &Work, chunk: &Chunk) -> bool {
    match part::check(&work.plan, chunk, &work.folder) {
        Ok(()) => true,
        Err(Stale::Missing) => false,
        Err(stale) => {
            if !work.quiet {
                terminal::say(format_args!("{}: {stale}; it is rendered anew", name(work, chunk)));
            }
            part::forget(chunk, &work.folder);
            false
        }
    }
}

/// The threads of one of `jobs` processes.
fn share(jobs: usize) -> NonZeroUsize {
    NonZeroUsize::new(cores().get() / jobs).unwrap_or(NonZeroUsize::MIN)
}

/// Renders `chunks`, the last first, each by a process; how many failed, and the first error.
fn by_processes(
    work: &Work,
    chunks: Vec<&Chunk>,
    jobs: usize,
    threads: NonZeroUsize,
) -> Option<(usize, Error)> {
    let frames = chunks.iter().map(|chunk| chunk.frames).sum();
    let bar = Mutex::new(Bar::new(Some(frames), work.quiet));
    let (queue, failures) = (Mutex::new(chunks), Mutex::new(Vec::new()));
    let done = AtomicU64::new(0);
    thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                while let Some(chunk) = lock(&queue).pop() {
                    match one(work, chunk, threads) {
                        Ok(()) => {
                            done.fetch_add(chunk.frames, Ordering::Relaxed);
                            lock(&bar).add(chunk.frames);
                        }
                        Err(error) => lock(&failures).push(error),
                    }
                }
            });
        }
    });
    if let Ok(bar) = bar.into_inner() {
        bar.finish();
    }
    let failures = failures.into_inner().unwrap_or_else(PoisonError::into_inner);
    let count = failures.len();
    failures.into_iter().next().map(|error| (count, error))
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    // Lists and bars are sound whoever panicked.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Renders `chunk` by a process of its own, which ends with this one.
fn one(work: &Work, chunk: &Chunk, threads: NonZeroUsize) -> Result<()> {
    let failed = |what: String| Error::output(part::meshes(&work.folder, chunk.chunk), what);
    let status = run(work, chunk, threads).map_err(|error| {
        failed(format!("the process that was to render it cannot be run: {error}")).caused_by(error)
    })?;
    if status.success() {
        return Ok(());
    }
    Err(failed(format!("the process that was to render it failed ({status})")))
}

fn run(work: &Work, chunk: &Chunk, threads: NonZeroUsize) -> io::Result<ExitStatus> {
    let mut command = itself()?;
    command.arg("render").arg("--plan").arg(&work.path);
    command.args(["--chunk", &chunk.chunk.to_string(), "--threads", &threads.to_string()]);
    command.args(["--quiet", "--until-input-ends", "-o"]).arg(&work.folder);
    let option = |command: &mut Command, name: &str, path: Option<&Path>| {
        if let Some(path) = path {
            command.arg(name).arg(path);
        }
    };
    option(&mut command, "--film", work.film.as_deref());
    option(&mut command, "--ffmpeg", work.ffmpeg.program.as_deref());
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::null()).spawn()?;
    // Held open until it has ended: it ends when this closes, however this process ends.
    let pipe = child.stdin.take();
    let status = child.wait();
    drop(pipe);
    status
}
