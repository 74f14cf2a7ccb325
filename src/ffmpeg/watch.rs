//! Watches a child process while a thread waits for it, and kills it if it hangs.
//!
//! A child that transfers no bytes and uses no processor time for [`PATIENCE`] hangs. So does one that transfers no
//! bytes but keeps writing messages, and, after a much longer time, one that only uses the processor: an encoder may
//! compute for minutes, but not for ever. Killing it wakes the waiting thread.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::processes::{Processes, kill};

/// Interval between checks of a child.
pub(crate) const TICK: Duration = Duration::from_millis(250);
/// Ticks without any activity after which a child hangs: 4 s. Ticks are counted, not a clock, so that nothing is
/// counted while this process is suspended.
const PATIENCE: u32 = 16;
/// The same if processor times cannot be read, and for children that wait for a network or a camera: a minute. Also
/// the limit for ticks with messages but without a byte.
pub(crate) const LONG_PATIENCE: u32 = 240;
/// Ticks without a byte, whatever the processor time, for a child that we read from: 2 minutes.
pub(crate) const READER_LIMIT: u32 = 480;
/// The same for a child that we write to, which may have many frames in its look-ahead: 30 minutes.
const WRITER_LIMIT: u32 = 7200;

/// The state that the watching thread shares with the waiting ones.
pub(crate) struct Watch {
    pub(crate) pid: u32,
    /// A thread waits for the child.
    pub(crate) waiting: AtomicBool,
    /// Bytes transferred through its pipes.
    pub(crate) moved: AtomicU64,
    /// Bytes of its messages.
    pub(crate) said: AtomicU64,
    /// The seconds without activity when it was killed because it hung; otherwise 0.
    pub(crate) hung: AtomicU32,
    /// Ticks without any activity that are allowed.
    pub(crate) patience: AtomicU32,
    /// Ticks without a byte that are allowed, whatever the processor time.
    pub(crate) limit: AtomicU32,
    /// Whether the child has been reaped: its number may then belong to another.
    pub(crate) reaped: Mutex<bool>,
    pub(crate) ended: Condvar,
    processes: Processes,
}

/// Locks `mutex`; its data is valid even after a panic of another thread.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Numbers of ticks in a row without activity.
#[derive(Default)]
struct Idle {
    /// Without a byte, a message or processor time.
    all: u32,
    /// Without a byte, but with messages.
    noisy: u32,
    /// Without a byte.
    silent: u32,
}

/// The activity of a child so far.
#[derive(Clone, Copy, Default, PartialEq)]
struct Seen {
    moved: u64,
    said: u64,
    activity: Option<Activity>,
}

impl Watch {
    /// The watch over the child `pid`.
    pub(crate) fn over(pid: u32, processes: Processes) -> Self {
        Self {
            pid,
            waiting: AtomicBool::new(false),
            moved: AtomicU64::new(0),
            said: AtomicU64::new(0),
            hung: AtomicU32::new(0),
            patience: AtomicU32::new(PATIENCE),
            limit: AtomicU32::new(WRITER_LIMIT),
            reaped: Mutex::new(false),
            ended: Condvar::new(),
            processes,
        }
    }

    /// Checks the child every [`TICK`] until it is reaped.
    pub(crate) fn run(&self) {
        let (mut idle, mut before) = (Idle::default(), Seen::default());
        let mut reaped = lock(&self.reaped);
        while !*reaped {
            let (guard, waited) =
                self.ended.wait_timeout(reaped, TICK).unwrap_or_else(PoisonError::into_inner);
            reaped = guard;
            // Only whole ticks count.
            if *reaped || !waited.timed_out() {
                continue;
            }
            if !self.waiting.load(Ordering::Relaxed) {
                idle = Idle::default();
                continue;
            }
            let now = self.look();
            idle.count(&before, &now);
            before = now;
            if let Some(ticks) = self.hung(&idle, now.activity.is_some()) {
                self.hung.store((TICK * ticks).as_secs().max(1) as u32, Ordering::Relaxed);
                kill(self.pid);
                idle = Idle::default();
            }
        }
    }

    fn look(&self) -> Seen {
        Seen {
            moved: self.moved.load(Ordering::Relaxed),
            said: self.said.load(Ordering::Relaxed),
            activity: activity(self.pid),
        }
    }

    /// The number of ticks for which it has hung, if it hangs.
    fn hung(&self, idle: &Idle, activity_known: bool) -> Option<u32> {
        let patience = self.patience.load(Ordering::Relaxed);
        let patience = if activity_known { patience } else { LONG_PATIENCE };
        // After a stop, messages do not count as activity.
        let noisy = if self.processes.is_stopping() { PATIENCE } else { LONG_PATIENCE };
        let limit = self.limit.load(Ordering::Relaxed);
        [(idle.all, patience), (idle.noisy, noisy), (idle.silent, limit)]
            .into_iter()
            .find_map(|(ticks, most)| (ticks >= most).then_some(ticks))
    }
}

impl Idle {
    fn count(&mut self, before: &Seen, now: &Seen) {
        if now.moved != before.moved {
            *self = Self::default();
            return;
        }
        self.silent += 1;
        self.noisy += u32::from(now.said != before.said);
        let busy = now.activity == Some(Activity::Waits) || now != before;
        self.all = if busy { 0 } else { self.all + 1 };
    }
}

/// The activity of a process and its children, by the system.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Activity {
    /// Processor time, in the system's units.
    Used(u64),
    /// A thread waits for a disk or for a busy processor: that is not a hang.
    Waits,
}

/// The activity of the process `pid` and its children. `None` if the system does not report it.
fn activity(pid: u32) -> Option<Activity> {
    let process = std::path::Path::new("/proc").join(pid.to_string());
    let stat = std::fs::read_to_string(process.join("stat")).ok()?;
    // Fields of proc(5) after the name, which may hold anything: state first, times of the process and of its
    // reaped children from the twelfth on.
    let fields = stat.rsplit_once(')')?.1.split_whitespace();
    let mut used: u64 = fields.skip(11).take(4).filter_map(|text| text.parse::<u64>().ok()).sum();
    for task in std::fs::read_dir(process.join("task")).ok()?.flatten() {
        let state = std::fs::read_to_string(task.path().join("stat")).unwrap_or_default();
        if state.rsplit_once(") ").is_some_and(|(_, rest)| rest.starts_with(['D', 'R'])) {
            return Some(Activity::Waits);
        }
        let Ok(children) = std::fs::read_to_string(task.path().join("children")) else {
            if task.path().exists() {
                // A kernel without CONFIG_PROC_CHILDREN: unknown.
                return None;
            }
            // The thread has just ended.
            continue;
        };
        for child in children.split_whitespace().filter_map(|pid| pid.parse().ok()) {
            match activity(child) {
                Some(Activity::Used(more)) => used += more,
                Some(Activity::Waits) => return Some(Activity::Waits),
                // It has just ended.
                None => {}
            }
        }
    }
    Some(Activity::Used(used))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(moved: u64, said: u64, used: u64) -> Seen {
        Seen { moved, said, activity: Some(Activity::Used(used)) }
    }

    #[test]
    fn messages_and_processor_time_are_no_progress_for_ever() {
        let watch = Watch::over(0, Processes::default());
        watch.limit.store(READER_LIMIT, Ordering::Relaxed);
        let ticks = |step: fn(u64) -> Seen| {
            let mut idle = Idle::default();
            (1..).find(|&i| {
                idle.count(&step(i - 1), &step(i));
                watch.hung(&idle, true).is_some()
            })
        };
        assert_eq!(ticks(|_| seen(0, 0, 0)), Some(u64::from(PATIENCE)));
        assert_eq!(ticks(|i| seen(0, i, i)), Some(u64::from(LONG_PATIENCE)));
        assert_eq!(ticks(|i| seen(0, 0, i)), Some(u64::from(READER_LIMIT)));
        watch.processes.end_readers();
        assert_eq!(ticks(|i| seen(0, i, i)), Some(u64::from(PATIENCE)));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_time_of_children_counts() {
        assert!(activity(std::process::id()).is_some());
        assert_eq!(activity(u32::MAX), None);
    }
}
