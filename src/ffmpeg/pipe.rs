//! Pipes to and from a child process, watched for stalls.

use std::io::{self, Read, Write};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::watch::Watch;

/// A pipe to or from a child, watched.
pub(crate) struct Pipe<P> {
    pipe: P,
    watch: Arc<Watch>,
}

/// Requested capacity of a pipe in bytes: the limit for all users of Linux (`/proc/sys/fs/pipe-max-size`), instead of
/// the default of 64 KiB, so that a frame passes in few reads.
#[cfg(target_os = "linux")]
const ROOM: usize = 1 << 20;

#[cfg(target_os = "linux")]
impl<P: std::os::fd::AsFd> Pipe<P> {
    /// The pipe to or from the child that `watch` watches.
    pub(super) fn new(pipe: P, watch: Arc<Watch>) -> Self {
        // Refused if the user has too many pipes: then the capacity stays.
        let _ = rustix::pipe::fcntl_setpipe_size(&pipe, ROOM);
        Self { pipe, watch }
    }
}

#[cfg(not(target_os = "linux"))]
impl<P> Pipe<P> {
    /// The pipe to or from the child that `watch` watches.
    pub(super) fn new(pipe: P, watch: Arc<Watch>) -> Self {
        Self { pipe, watch }
    }
}

impl<P> Pipe<P> {
    fn watched(&mut self, act: impl FnOnce(&mut P) -> io::Result<usize>) -> io::Result<usize> {
        self.watch.waiting.store(true, Ordering::Relaxed);
        let result = act(&mut self.pipe);
        self.watch.waiting.store(false, Ordering::Relaxed);
        if let Ok(count) = result {
            self.watch.moved.fetch_add(count as u64, Ordering::Relaxed);
        }
        result
    }
}

impl<P: Read> Read for Pipe<P> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.watched(|pipe| pipe.read(buffer))
    }
}

impl<P: Write> Write for Pipe<P> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        self.watched(|pipe| pipe.write(buffer))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.pipe.flush()
    }
}
