//! Watches a child process while somebody waits for it, and ends it if it hangs.
//!
//! A child that moves no bytes and spends no processor time for [`PATIENCE`] is hung and is killed,
//! which wakes whoever waits. A slow encoder spends time and is left in peace.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How often a child is looked at.
pub(crate) const TICK: Duration = Duration::from_millis(250);
/// Ticks without any sign of life before a child counts as hung: 4 s. Ticks, not a clock: while we
/// are suspended ourselves nothing is counted.
pub(crate) const PATIENCE: u32 = 16;
/// The same where processor times cannot be read, and for those who wait for somebody else, a network
/// or a camera: a minute.
pub(crate) const LONG_PATIENCE: u32 = 240;

/// Running children by their process groups, and whether each reads what may never end.
static RUNNING: Mutex<BTreeMap<u32, bool>> = Mutex::new(BTreeMap::new());

/// The running children. While this is held none is begun and none is reaped, so that all numbers in
/// it are theirs.
pub(crate) fn running() -> MutexGuard<'static, BTreeMap<u32, bool>> {
    lock(&RUNNING)
}

/// Ends all children. Only for a process that ends right after: no child can be begun any more.
pub(crate) fn end_all() {
    let running = running();
    running.keys().for_each(|&group| kill(group));
    std::mem::forget(running);
}

/// Ends the programs that read cameras and addresses, which may never deliver another frame. For after
/// a stop has been asked for, when nobody wants one.
pub fn hang_up() {
    running().iter().filter(|(_, endless)| **endless).for_each(|(&group, _)| kill(group));
}

/// What the watching thread shares with those who wait.
pub(crate) struct Watch {
    pub(crate) pid: u32,
    /// Somebody waits for the child.
    pub(crate) waiting: AtomicBool,
    /// Bytes that went through its pipes.
    pub(crate) moved: AtomicU64,
    pub(crate) hung: AtomicBool,
    /// Ticks of patience.
    pub(crate) patience: AtomicU32,
    /// Whether the child has been reaped: its number may then belong to another.
    pub(crate) reaped: Mutex<bool>,
    pub(crate) ended: Condvar,
}

/// Locks `mutex`; what a panicking thread has left behind is still sound here.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Watch {
    /// The watch over the child `pid`.
    pub(crate) fn over(pid: u32) -> Self {
        Self {
            pid,
            waiting: AtomicBool::new(false),
            moved: AtomicU64::new(0),
            hung: AtomicBool::new(false),
            patience: AtomicU32::new(PATIENCE),
            reaped: Mutex::new(false),
            ended: Condvar::new(),
        }
    }

    /// Looks at the child every [`TICK`] until it is reaped.
    pub(crate) fn run(&self) {
        let (mut idle, mut before) = (0, (0, None));
        let mut reaped = lock(&self.reaped);
        while !*reaped {
            reaped = match self.ended.wait_timeout(reaped, TICK) {
                Ok((guard, _)) => guard,
                Err(poisoned) => poisoned.into_inner().0,
            };
            if *reaped {
                return;
            }
            if !self.waiting.load(Ordering::Relaxed) {
                idle = 0;
                continue;
            }
            let now = (self.moved.load(Ordering::Relaxed), activity(self.pid));
            idle = if now == before { idle + 1 } else { 0 };
            before = now;
            let patience = self.patience.load(Ordering::Relaxed);
            let patience = if now.1.is_some() { patience } else { LONG_PATIENCE };
            if idle >= patience {
                self.hung.store(true, Ordering::Relaxed);
                kill(self.pid);
                idle = 0;
            }
        }
    }
}

/// Processor time that the process group `group` has used, in the system's units, and whether one
/// of them waits for a disk (which is no hang; then the value never repeats). `None` where the
/// system does not tell.
fn activity(group: u32) -> Option<u64> {
    static NEVER: AtomicU64 = AtomicU64::new(1 << 63);
    let mut used = None;
    for entry in std::fs::read_dir("/proc").ok()?.flatten() {
        if !entry.file_name().as_encoded_bytes().iter().all(u8::is_ascii_digit) {
            continue;
        }
        let Ok(stat) = std::fs::read_to_string(entry.path().join("stat")) else { continue };
        // Fields of proc(5) after the name, which may hold anything: state, parent, group, ...,
        // user and system time.
        let fields: Vec<&str> =
            stat.rsplit_once(')').map_or("", |(_, rest)| rest).split_whitespace().collect();
        let field = |i: usize| fields.get(i).and_then(|text| text.parse::<u64>().ok());
        if field(2) != Some(u64::from(group)) {
            continue;
        }
        if fields.first() == Some(&"D") {
            return Some(NEVER.fetch_add(1, Ordering::Relaxed));
        }
        used = Some(used.unwrap_or(0) + field(11).unwrap_or(0) + field(12).unwrap_or(0));
    }
    used
}

/// Ends the process group `group`, which must not have been reaped.
#[cfg(unix)]
pub(crate) fn kill(group: u32) {
    use rustix::process::{Pid, Signal, kill_process_group};
    if let Some(pid) = i32::try_from(group).ok().and_then(Pid::from_raw) {
        // It may have ended by itself.
        let _ = kill_process_group(pid, Signal::KILL);
    }
}

#[cfg(not(unix))]
pub(crate) fn kill(_group: u32) {}
