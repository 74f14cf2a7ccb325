//! Feeds an input that can be read only once, a pipe, to ffprobe and then to ffmpeg: what the first has read is kept for
//! the second.

use std::io::{self, Read, Write};
use std::process::ChildStdin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

use super::Pipe;

/// Bytes that are moved at once.
const PART: usize = 1 << 16;
/// The most bytes that are kept of what ffprobe reads. It looks at 5 MB, but reads on where a file's tables come after
/// its frames, which cannot be read through a pipe.
const MOST: usize = 64 << 20;

/// An input that can be read only once. Clones are the same one.
#[derive(Clone)]
pub(crate) struct PipedInput(Arc<Mutex<State>>);

struct State {
    /// `None` while a thread reads it, and once it was read to its end.
    input: Option<Box<dyn Read + Send>>,
    /// What ffprobe was given.
    head: Vec<u8>,
}

impl std::fmt::Debug for PipedInput {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PipedInput").finish_non_exhaustive()
    }
}

impl PipedInput {
    /// The input `input`, of which nothing was read.
    pub(crate) fn new(input: Box<dyn Read + Send>) -> Self {
        Self(Arc::new(Mutex::new(State { input: Some(input), head: Vec::new() })))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives what comes in to `child` on a thread, and keeps it, until the child has had enough.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub(crate) fn probe(&self, child: Pipe<ChildStdin>) -> io::Result<thread::JoinHandle<()>> {
        let this = self.clone();
        let name = thread::Builder::new().name("pipe-probe".into());
        name.spawn(move || {
            let state = &mut *this.state();
            let Some(input) = &mut state.input else { return };
            pump(input.as_mut(), child, |part| {
                state.head.extend_from_slice(part);
                state.head.len() < MOST
            });
        })
    }

    /// Gives `child` all of it on a thread: what was kept, and the rest.
    ///
    /// # Errors
    /// When the system gives no thread, or it was given before.
    pub(crate) fn give(&self, mut child: Pipe<ChildStdin>) -> io::Result<()> {
        let mut state = self.state();
        let head = std::mem::take(&mut state.head);
        let again = || io::Error::other("a pipe can be read only once");
        let mut input = state.input.take().ok_or_else(again)?;
        thread::Builder::new().name("pipe-input".into()).spawn(move || {
            if child.write_all(&head).is_ok() {
                drop(head);
                pump(input.as_mut(), child, |_| true);
            }
        })?;
        Ok(())
    }
}

/// Moves bytes until the input ends, `child` takes no more, or `seen`, which sees all that was read, says no.
fn pump(input: &mut dyn Read, mut child: Pipe<ChildStdin>, mut seen: impl FnMut(&[u8]) -> bool) {
    let mut part = vec![0; PART];
    loop {
        match input.read(&mut part) {
            Ok(0) => return,
            Ok(count) => {
                if !seen(&part[..count]) || child.write_all(&part[..count]).is_err() {
                    return;
                }
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(_) => return,
        }
    }
}
