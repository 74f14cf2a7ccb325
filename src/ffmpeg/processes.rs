//! The list of running child processes, owned by the caller, by which they can be ended together.

use std::collections::BTreeMap;
#[cfg(feature = "ffmpeg")]
use std::io;
#[cfg(any(feature = "ffmpeg", windows))]
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The child processes that were started with this list or a clone of it. A program keeps one for its Ctrl-C handler;
/// other users can ignore it.
#[derive(Clone, Debug, Default)]
pub struct Processes(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    list: Mutex<List>,
    /// No more frames are needed. It is not part of the list: the watcher of a child reads it while it holds a lock
    /// that is taken inside the list's lock when the child is reaped.
    stopping: AtomicBool,
}

#[derive(Debug, Default)]
struct List {
    /// Process groups, and whether frames are read from each.
    running: BTreeMap<u32, bool>,
    /// Whether no child may be started any more.
    closed: bool,
}

/// Lists are equal when they are the same list.
impl PartialEq for Processes {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Processes {
    /// While the lock is held no child is started or reaped, so that all numbers in the list are valid.
    fn list(&self) -> MutexGuard<'_, List> {
        self.0.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Kills the processes that frames are read from, after a request to stop. Otherwise a camera, a network or a
    /// broken decoder could block the run.
    pub fn end_readers(&self) {
        let list = self.list();
        self.0.stopping.store(true, Ordering::SeqCst);
        list.running.iter().filter(|(_, reader)| **reader).for_each(|(&group, _)| kill(group));
    }

    /// Kills all processes, and prevents new ones.
    pub fn end_all(&self) {
        let mut list = self.list();
        list.closed = true;
        self.0.stopping.store(true, Ordering::SeqCst);
        list.running.keys().for_each(|&group| kill(group));
    }
}

#[cfg(feature = "ffmpeg")]
impl Processes {
    /// Whether [`Processes::end_readers`] was called.
    pub(crate) fn is_stopping(&self) -> bool {
        self.0.stopping.load(Ordering::SeqCst)
    }

    /// Starts `command` and enters it in the list.
    ///
    /// # Errors
    /// When it cannot be started, or after [`Processes::end_all`].
    pub(crate) fn start(&self, command: &mut Command) -> io::Result<std::process::Child> {
        let mut list = self.list();
        if list.closed {
            return Err(io::Error::other("the program is being ended"));
        }
        let child = command.spawn()?;
        list.running.insert(child.id(), false);
        Ok(child)
    }

    /// Makes the child `pid` one that [`Processes::end_readers`] ends.
    pub(crate) fn mark_reader(&self, pid: u32) {
        self.list().running.entry(pid).and_modify(|reader| *reader = true);
    }

    /// Runs `reap` while no process can be killed; if it returns true, removes the child `pid` from the list.
    pub(crate) fn reap<T>(&self, pid: u32, reap: impl FnOnce() -> (bool, T)) -> T {
        let mut list = self.list();
        let (gone, value) = reap();
        if gone {
            list.running.remove(&pid);
        }
        value
    }
}

/// Kills the process group `group`, which must not have been reaped.
#[cfg(unix)]
pub(crate) fn kill(group: u32) {
    use rustix::process::{Pid, Signal, kill_process_group};
    if let Some(pid) = i32::try_from(group).ok().and_then(Pid::from_raw) {
        // It may have ended by itself.
        let _ = kill_process_group(pid, Signal::KILL);
    }
}

/// Kills the process `pid` and its children.
#[cfg(windows)]
pub(crate) fn kill(pid: u32) {
    // Windows has no process groups; its own tool kills the process tree.
    let mut command = Command::new("taskkill");
    command.args(["/F", "/T", "/PID", &pid.to_string()]);
    command.stdin(std::process::Stdio::null()).stdout(std::process::Stdio::null());
    let _ = command.stderr(std::process::Stdio::null()).status();
}

#[cfg(not(any(unix, windows)))]
pub(crate) fn kill(_pid: u32) {}

#[cfg(all(test, unix, feature = "ffmpeg"))]
mod tests {
    use super::*;

    #[test]
    fn a_watcher_does_not_wait_for_the_reaper() {
        let processes = Processes::default();
        let (done, ended) = std::sync::mpsc::channel();
        let asking = processes.clone();
        processes.reap(1, || {
            std::thread::spawn(move || done.send(asking.is_stopping()));
            let asked = ended.recv_timeout(std::time::Duration::from_secs(60));
            assert_eq!(asked, Ok(false), "a watcher that is asked holds what the reaper waits for");
            (false, ())
        });
    }

    #[test]
    fn a_closed_list_starts_nothing() {
        let processes = Processes::default();
        let mut child = processes.start(Command::new("sleep").arg("1000")).expect("coreutils");
        child.kill().expect("it runs");
        processes.reap(child.id(), || (child.wait().is_ok(), ()));
        processes.end_all();
        assert!(processes.start(&mut Command::new("true")).is_err());
        assert!(processes.is_stopping());
    }
}
