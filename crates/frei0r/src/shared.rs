//! Assigns streams to instances of the plug-in.
//!
//! Most hosts make one instance for a filter, and each has its own stream. MLT (melt, Kdenlive, Shotcut) makes one
//! for each of its worker threads and distributes the frames among them. There the instances of one filter share a
//! stream, and a frame that is early waits for the one before it.

use std::ffi::c_void;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

use polyreel_core::Size;

use crate::stream::Stream;

/// The longest wait of a frame for the one before it. If the host drops frames, that one never comes.
const PATIENCE: Duration = Duration::from_millis(250);

/// The longest wait of a stream's first two frames, when the distance of frames is unknown.
const SETTLE_TIME: Duration = Duration::from_millis(100);

/// A stream, and the threads whose instances feed it.
#[derive(Debug)]
pub(crate) struct Shared {
    size: Size,
    /// Whether several threads may feed it.
    open: bool,
    state: Mutex<State>,
    /// Signalled when a frame comes, and when one has been rendered.
    changed: Condvar,
}

#[derive(Debug)]
struct State {
    stream: Stream,
    threads: Vec<ThreadId>,
    /// Times of the waiting frames.
    waiting: Vec<f64>,
}

impl State {
    /// The remaining wait of a frame at `time` that came `since` ago; `None` when it is next.
    fn wait(&self, time: f64, since: Duration) -> Option<Duration> {
        if !self.stream.goes_on(time) {
            return None;
        }
        let earlier = self.waiting.iter().any(|&other| other < time && self.stream.goes_on(other));
        let patience = match self.stream.last() {
            _ if earlier => PATIENCE,
            None if time <= 0.0 => return None,
            Some(_) if self.stream.knows_step() => {
                if self.stream.is_next(time) {
                    return None;
                }
                PATIENCE
            }
            _ => SETTLE_TIME,
        };
        patience.checked_sub(since).filter(|left| !left.is_zero())
    }
}

/// The streams of this process that instances can join, in order of their start. A host gives instances nothing else
/// in common.
static STREAMS: Mutex<Vec<Weak<Shared>>> = Mutex::new(Vec::new());

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    fn new(size: Size, open: bool) -> Arc<Self> {
        let threads = vec![thread::current().id()];
        let state = State { stream: Stream::default(), threads, waiting: Vec::new() };
        Arc::new(Self { size, open, state: Mutex::new(state), changed: Condvar::new() })
    }

    /// The stream for an instance whose first frame, of `size`, is at `time`. With `join` it can be one that other
    /// threads feed already.
    pub(crate) fn find(size: Size, time: f64, join: bool) -> Arc<Self> {
        if !join {
            return Self::new(size, false);
        }
        let mut streams = lock(&STREAMS);
        streams.retain(|stream| stream.strong_count() > 0);
        let mine = streams.iter().filter_map(Weak::upgrade).find(|stream| stream.takes(size, time));
        mine.unwrap_or_else(|| {
            let stream = Self::new(size, true);
            streams.push(Arc::downgrade(&stream));
            stream
        })
    }

    /// Whether this thread joins: no instance of it feeds the stream yet (otherwise it is that of another filter),
    /// and the stream lacks a frame at `time`.
    fn takes(&self, size: Size, time: f64) -> bool {
        let (mut state, me) = (lock(&self.state), thread::current().id());
        let joins = self.size == size
            && !state.threads.contains(&me)
            && !state.waiting.contains(&time)
            && state.stream.last().is_none_or(|last| last < time)
            && state.stream.goes_on(time);
        if joins {
            state.threads.push(me);
        }
        joins
    }

    /// Calls `work` with the stream when the frame at `time` is next.
    pub(crate) fn in_turn<T>(&self, time: f64, work: impl FnOnce(&mut Stream) -> T) -> T {
        let mut state = lock(&self.state);
        if self.open {
            state.waiting.push(time);
            self.changed.notify_all();
            let came = Instant::now();
            while let Some(left) = state.wait(time, came.elapsed()) {
                let waited = self.changed.wait_timeout(state, left);
                state = waited.unwrap_or_else(PoisonError::into_inner).0;
            }
        }
        let done = work(&mut state.stream);
        if let Some(at) = state.waiting.iter().position(|&other| other == time) {
            state.waiting.swap_remove(at);
        }
        drop(state);
        self.changed.notify_all();
        done
    }
}

/// Whether the host is built on MLT: its library is part of this process.
pub(crate) fn is_in_mlt() -> bool {
    // SAFETY: dlsym is given a valid name and only looked at for null.
    let symbol: *mut c_void =
        unsafe { libc::dlsym(libc::RTLD_DEFAULT, c"mlt_factory_init".as_ptr()) };
    !symbol.is_null()
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel_core::{Options, Rgba};

    fn feed(shared: &Shared, time: f64) -> Vec<Rgba> {
        let (input, mut out) = (picture(shared.size, time), vec![[0; 4]; shared.size.pixels()]);
        shared.in_turn(time, |stream| {
            stream
                .render(shared.size, &Options::default(), time, &input, &mut out)
                .expect("a small frame");
        });
        out
    }

    fn picture(size: Size, time: f64) -> Vec<Rgba> {
        (0..size.pixels())
            .map(|i| [(i % 48 * 5) as u8, (i / 48 * 7) as u8, time as u8 * 3, 255])
            .collect()
    }

    // Each test has a size of its own: the list of streams is the process's.

    #[test]
    fn workers_of_one_filter_share_a_stream_and_keep_its_order() {
        let size = Size::new(48, 32);
        let own = Shared::new(size, false);
        let alone: Vec<_> = (0..12).map(|i| feed(&own, f64::from(i))).collect();

        let worker = |mine: [i32; 6]| {
            move || {
                let stream = Shared::find(size, f64::from(mine[0]), true);
                mine.map(|i| (i, feed(&stream, f64::from(i)))).to_vec()
            }
        };
        let (odd, even) = (worker([1, 3, 5, 7, 9, 11]), worker([0, 2, 4, 6, 8, 10]));
        let (odd, even) = (thread::spawn(odd), thread::spawn(even));
        let mut rest = odd.join().expect("a worker");
        rest.extend(even.join().expect("a worker"));
        rest.sort_by_key(|(i, _)| *i);
        let shared: Vec<_> = rest.into_iter().map(|(_, picture)| picture).collect();
        assert!(shared == alone, "the workers' pictures are those of one");
    }

    #[test]
    fn two_filters_of_one_thread_are_two_streams() {
        let size = Size::new(48, 31);
        let (one, two) = (Shared::find(size, 0.0, true), Shared::find(size, 0.0, true));
        assert!(!Arc::ptr_eq(&one, &two));
    }

    #[test]
    fn other_hosts_share_nothing() {
        let size = Size::new(48, 30);
        let one = Shared::find(size, 0.0, false);
        feed(&one, 0.0);
        let two = thread::spawn(move || Shared::find(size, 1.0, false)).join().expect("a thread");
        assert!(!Arc::ptr_eq(&one, &two));
        assert!(!is_in_mlt());
    }
}
