//! ffmpeg and ffprobe as child processes that cannot hang us, outlive us or go unreaped.
//!
//! `ffmpeg-sidecar` builds the command; process and pipes are ours. Standard error is drained on a
//! thread of its own from the start, else a talkative child fills that pipe and stops for ever. A
//! second thread watches the moments in which we wait for the child, and ends one that hangs.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{self, Read};
use std::path::Path;
use std::process::{ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use ffmpeg_sidecar::command::FfmpegCommand;

use super::Ffmpeg;
use super::failure::FfmpegError;
use super::pipe::Pipe;
use super::processes::{Processes, kill};
use super::watch::{LONG_PATIENCE, READER_LIMIT, Watch, lock};

/// Lines of standard error that are kept, and their length in bytes.
const TAIL: usize = 20;
const LINE: usize = 400;

/// The longest that the end of a child may go unnoticed.
const MOST_PAUSE: Duration = Duration::from_millis(20);

/// By how much a child that [gives way](Child::give_way) is nicer than we are: what `nice` gives.
#[cfg(unix)]
const NICE: i32 = 10;

/// What a child has said on standard error.
#[derive(Default)]
struct Words {
    tail: VecDeque<String>,
    /// Of these, lines that ffmpeg itself calls errors.
    errors: VecDeque<String>,
    over: bool,
}

/// A running child.
pub(crate) struct Child {
    inner: std::process::Child,
    processes: Processes,
    watch: Arc<Watch>,
    words: Arc<(Mutex<Words>, Condvar)>,
    status: Option<ExitStatus>,
}

impl Child {
    /// Starts ffmpeg with `args`.
    ///
    /// # Errors
    /// When it cannot be started; for a missing program the message says how to get it.
    pub(crate) fn ffmpeg(ffmpeg: &Ffmpeg, args: &[OsString]) -> Result<Self, FfmpegError> {
        Self::spawn(&ffmpeg.ffmpeg(), args, None, &ffmpeg.processes)
    }

    /// The same with `stdout` as its standard output.
    ///
    /// # Errors
    /// As [`Child::ffmpeg`].
    pub(crate) fn ffmpeg_to(
        stdout: Stdio,
        ffmpeg: &Ffmpeg,
        args: &[OsString],
    ) -> Result<Self, FfmpegError> {
        Self::spawn(&ffmpeg.ffmpeg(), args, Some(stdout), &ffmpeg.processes)
    }

    /// Starts ffprobe with `args`.
    ///
    /// # Errors
    /// As [`Child::ffmpeg`].
    pub(crate) fn ffprobe(ffmpeg: &Ffmpeg, args: &[OsString]) -> Result<Self, FfmpegError> {
        Self::spawn(&ffmpeg.ffprobe(), args, None, &ffmpeg.processes)
    }

    /// Starts `program`, all three pipes ours, in a process group of its own: a Ctrl-C in the
    /// terminal is for us to act on, and must not end an encoder before it can finish its file.
    fn spawn(
        program: &Path,
        args: &[OsString],
        stdout: Option<Stdio>,
        processes: &Processes,
    ) -> Result<Self, FfmpegError> {
        let mut command = FfmpegCommand::new_with_path(program);
        // The crate puts `-loglevel level+info` in front: ours comes later and counts.
        command.args(args.iter().map(OsString::as_os_str));
        // Spawned as a plain command: the crate's own `spawn` adds `-n`, which ffprobe does not know
        // and which would refuse an output that we have made room for.
        let mut command: Command = command.into();
        if let Some(stdout) = stdout {
            command.stdout(stdout);
        }
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        spawn_patiently(&mut command, processes)
            .and_then(|inner| Self::watched(inner, processes.clone()))
            .map_err(|error| no_start(program, error))
    }

    fn watched(mut inner: std::process::Child, processes: Processes) -> io::Result<Self> {
        let watch = Arc::new(Watch::over(inner.id(), processes.clone()));
        let words = Arc::new((Mutex::new(Words::default()), Condvar::new()));
        let stderr = inner.stderr.take();
        // From here on the child is killed and reaped if anything fails.
        let child = Self { inner, processes, watch, words, status: None };
        if let Some(stderr) = stderr {
            let (words, watch) = (Arc::clone(&child.words), Arc::clone(&child.watch));
            thread::Builder::new()
                .name("ffmpeg-stderr".into())
                .spawn(move || drain(stderr, &words, &watch))?;
        }
        let watch = Arc::clone(&child.watch);
        thread::Builder::new().name("ffmpeg-watch".into()).spawn(move || watch.run())?;
        Ok(child)
    }

    /// Gives it a minute to go on: it waits for a network or a camera.
    pub(crate) fn be_patient(&self) {
        self.watch.patience.store(LONG_PATIENCE, Ordering::Relaxed);
    }

    /// Gives it all the time in the world: it waits for a reader who may pause.
    pub(crate) fn wait_for_ever(&self) {
        self.watch.patience.store(u32::MAX, Ordering::Relaxed);
        self.watch.limit.store(u32::MAX, Ordering::Relaxed);
    }

    /// Lets other threads go first where there are not cores enough. To be called before it has threads
    /// of its own, which on Linux keep the priority that they were begun with.
    pub(crate) fn give_way(&self) {
        #[cfg(unix)]
        {
            use rustix::process::{Pid, getpriority_process, setpriority_process};
            let nice = getpriority_process(None).map_or(0, |own| own + NICE);
            // Where it is not allowed it stays as it is.
            let _ = setpriority_process(Some(Pid::from_child(&self.inner)), nice);
        }
    }

    /// The child's standard input. There is one only once.
    pub(crate) fn stdin(&mut self) -> Option<Pipe<ChildStdin>> {
        let pipe = self.inner.stdin.take()?;
        Some(Pipe::new(pipe, Arc::clone(&self.watch)))
    }

    /// The child's standard output, which makes it one of those that [`Processes::end_readers`] ends. There is
    /// one only once.
    pub(crate) fn stdout(&mut self) -> Option<Pipe<ChildStdout>> {
        let pipe = self.inner.stdout.take()?;
        self.processes.mark_reader(self.watch.pid);
        self.watch.limit.store(READER_LIMIT, Ordering::Relaxed);
        Some(Pipe::new(pipe, Arc::clone(&self.watch)))
    }

    /// Waits for the end of the child, which is killed if it hangs. Pipes must have been taken and
    /// dropped before, or emptied.
    ///
    /// # Errors
    /// When the system cannot tell.
    pub(crate) fn wait(&mut self) -> io::Result<ExitStatus> {
        drop(self.inner.stdin.take());
        self.watch.waiting.store(true, Ordering::Relaxed);
        let mut pause = Duration::from_millis(1);
        while self.status.is_none() {
            self.reap()?;
            // Its standard error ends when it does, unless a grandchild holds on to that.
            if self.status.is_none() && self.words_within(MOST_PAUSE).over {
                thread::sleep(pause);
                pause = (pause * 2).min(MOST_PAUSE);
            }
        }
        self.watch.waiting.store(false, Ordering::Relaxed);
        self.status.ok_or_else(|| io::Error::other("a child without a status"))
    }

    fn reap(&mut self) -> io::Result<()> {
        let Self { inner, processes, watch, status, .. } = self;
        processes.reap(watch.pid, || {
            let mut reaped = lock(&watch.reaped);
            if status.is_none() {
                match inner.try_wait() {
                    Ok(ended) => *status = ended,
                    Err(error) => return (false, Err(error)),
                }
            }
            *reaped = status.is_some();
            // Only its end: a watch that is woken counts no tick.
            if *reaped {
                watch.ended.notify_all();
            }
            (*reaped, Ok(()))
        })
    }

    /// Why the child failed: its own last words, or how it ended. Called after [`Child::wait`]. `from_network` is
    /// whether it reads from one.
    pub(crate) fn failure(&self, from_network: bool) -> FfmpegError {
        let hung = self.watch.hung.load(Ordering::Relaxed) > 0;
        FfmpegError::ended(self.last_words(), self.status, hung, from_network)
    }

    fn last_words(&self) -> String {
        let said = self.said();
        let hung = self.watch.hung.load(Ordering::Relaxed);
        let mut text = if hung > 0 {
            format!("it stopped working and was ended after {hung} s")
        } else {
            match self.status {
                Some(status) if !status.success() => status.to_string(),
                _ => String::new(),
            }
        };
        if !said.is_empty() {
            text = if text.is_empty() { said } else { format!("{said} ({text})") };
        }
        if TOO_OLD.iter().any(|words| text.contains(words)) {
            text +=
                "; this ffmpeg is too old: 5.1 or later is needed, name another with --ffmpeg PATH";
        }
        if text.is_empty() { "it said nothing".into() } else { text }
    }

    /// The last lines of standard error, those that are errors if there are any.
    fn said(&self) -> String {
        let words = self.words();
        let lines = if words.errors.is_empty() { &words.tail } else { &words.errors };
        let first = lines.len().saturating_sub(3);
        lines.range(first..).map(|line| line.trim()).collect::<Vec<_>>().join("; ")
    }

    /// Whether the child complained of an error.
    pub(crate) fn complained(&self) -> bool {
        !self.words().errors.is_empty()
    }

    /// What was said, once all of it has arrived. A grandchild may hold the pipe open: after a second
    /// what there is must do.
    fn words(&self) -> MutexGuard<'_, Words> {
        self.words_within(Duration::from_secs(1))
    }

    /// What was said, once all of it has arrived or `time` is over.
    fn words_within(&self, time: Duration) -> MutexGuard<'_, Words> {
        let (words, over) = &*self.words;
        over.wait_timeout_while(lock(words), time, |words| !words.over)
            .unwrap_or_else(PoisonError::into_inner)
            .0
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        if self.reap().is_ok() && self.status.is_none() {
            kill(self.watch.pid);
            // Falls through to the child itself where there are no process groups.
            let _ = self.inner.kill();
            let Self { inner, processes, watch, .. } = self;
            processes.reap(watch.pid, || {
                let mut reaped = lock(&watch.reaped);
                let _ = inner.wait();
                *reaped = true;
                watch.ended.notify_all();
                (true, ())
            });
        }
    }
}

/// Starts the command; a program that is being written this moment (a wrapper script, say) is tried
/// again.
fn spawn_patiently(
    command: &mut Command,
    processes: &Processes,
) -> io::Result<std::process::Child> {
    for _ in 0..20 {
        match processes.start(command) {
            Err(error) if error.kind() == io::ErrorKind::ExecutableFileBusy => {
                thread::sleep(Duration::from_millis(10));
            }
            other => return other,
        }
    }
    processes.start(command)
}

fn no_start(program: &Path, error: io::Error) -> FfmpegError {
    let name = program.display();
    let words = if error.kind() == io::ErrorKind::NotFound {
        format!(
            "'{name}' was not found, and video needs it: install it (apt-get install ffmpeg, brew \
             install ffmpeg) or name it with --ffmpeg PATH"
        )
    } else {
        format!("'{name}' cannot be run: {error}; name another with --ffmpeg PATH")
    };
    FfmpegError::new(words).caused_by(error)
}

/// Reads `stderr` to its end and keeps the last lines.
fn drain(mut stderr: ChildStderr, words: &(Mutex<Words>, Condvar), watch: &Watch) {
    let mut buffer = [0; 8192];
    let mut line = Vec::with_capacity(LINE);
    loop {
        let count = match stderr.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => break,
        };
        watch.said.fetch_add(count as u64, Ordering::Relaxed);
        for &byte in &buffer[..count] {
            if byte == b'\n' || byte == b'\r' {
                keep(&mut lock(&words.0), &line);
                line.clear();
            } else if line.len() < LINE {
                line.push(byte);
            }
        }
    }
    let mut said = lock(&words.0);
    keep(&mut said, &line);
    said.over = true;
    words.1.notify_all();
}

/// What makes a line a complaint: ffmpeg's level, or a damage that it only warns of.
const SERIOUS: [&str; 4] = ["[error]", "[fatal]", "[panic]", "corrupt decoded frame"];

/// What an ffmpeg says that does not know our options. All came with 5.1 or before.
const TOO_OLD: [&str; 2] = ["Unrecognized option 'fps_mode'", "Option fps_mode not found"];

/// Remarks that sound files and our own options cause. The last one is of packets that are only read so that
/// ffmpeg mends the clocks of all streams alike, and then go nowhere.
const HARMLESS: [&str; 4] = [
    "mmco: unref short failure",
    "co located POCs unavailable",
    "deprecated pixel format",
    "null: Application provided invalid, non monotonically increasing dts",
];

fn keep(words: &mut Words, line: &[u8]) {
    let line = String::from_utf8_lossy(line);
    let line = line.trim();
    if line.is_empty() {
        return;
    }
    let serious = SERIOUS.iter().any(|mark| line.contains(mark));
    let text = plain(line);
    if HARMLESS.iter().any(|remark| text.contains(remark)) {
        return;
    }
    if serious {
        push(&mut words.errors, text.clone());
    }
    push(&mut words.tail, text);
}

fn push(lines: &mut VecDeque<String>, line: String) {
    if lines.len() == TAIL {
        lines.pop_front();
    }
    lines.push_back(line);
}

/// `line` without its level and the address of the context: `[mov @ 0x55] [error] x` is `mov: x`.
fn plain(line: &str) -> String {
    let mut rest = line;
    let mut context = "";
    while let Some((inside, after)) = rest.strip_prefix('[').and_then(|r| r.split_once(']')) {
        if let Some((name, _)) = inside.split_once(" @ ") {
            context = name;
        } else if !inside.bytes().all(|b| b.is_ascii_lowercase()) {
            break;
        }
        rest = after.trim_start();
    }
    if context.is_empty() { rest.into() } else { format!("{context}: {rest}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_lose_level_and_address() {
        assert_eq!(plain("[mov,mp4 @ 0x55d0] [error] partial file"), "mov,mp4: partial file");
        assert_eq!(plain("[error] x.mp4: No such file"), "x.mp4: No such file");
        assert_eq!(plain("[out#0/mp4 @ 0x1] [vost#0:0 @ 0x2] [fatal] no"), "vost#0:0: no");
        assert_eq!(plain("frame 10: I give up"), "frame 10: I give up");
        assert_eq!(plain("[unclosed"), "[unclosed");
    }

    #[test]
    fn only_the_tail_is_kept() {
        let mut words = Words::default();
        for i in 0..1000 {
            keep(&mut words, format!("[x @ 0x1] [error] {i}").as_bytes());
        }
        assert_eq!((words.tail.len(), words.errors.len()), (TAIL, TAIL));
        assert_eq!(words.errors.back().map(String::as_str), Some("x: 999"));
    }

    #[test]
    fn a_missing_program_is_told_with_its_cure() {
        let ffmpeg = Ffmpeg::from(std::path::PathBuf::from("/nowhere/ffmpeg"));
        let error = Child::ffmpeg(&ffmpeg, &[]).err().expect("it is missing");
        let error = crate::Error::input("a.mp4", error.to_string()).caused_by(error);
        assert_eq!(error.io_kind(), Some(io::ErrorKind::NotFound));
        let text = error.to_string();
        assert!(text.contains("apt-get install ffmpeg") && text.contains("--ffmpeg"), "{text}");
    }
}
