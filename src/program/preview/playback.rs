//! Playback: which frame is admitted to the pipeline, and when.
//!
//! A monitor connects three threads: the [feed](super::feed) reads ahead, the window controls, and the pipeline's
//! decoding thread asks for the next frame. [`State::decide`], which gets the time, decides what to do.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use polyreel::error::{Error, Result};
use polyreel::frame::Rational;
use polyreel::source::{Decoded, Source};
use polyreel::stream::Span;

use super::mailbox::Mailbox;
use super::pace::Pace;

/// Frames in the pipeline at a time. With two, a change is visible after two frames at most; two stages work
/// meanwhile.
const IN_FLIGHT: u64 = 2;

/// Frames of a file that are read ahead: they bridge the start of a decoder for the next round.
const AHEAD: usize = 4;

/// A frame that was read, waiting for its time.
#[derive(Debug)]
struct Waiting {
    decoded: Decoded,
    /// Whether it is the first after a jump, or of a new round.
    first: bool,
}

/// The next action.
#[derive(Debug, PartialEq)]
enum Decision {
    /// Admit the first waiting frame.
    Admit,
    /// Admit the frame on the screen once more.
    Again,
    /// Wait until this time, or until something changes.
    Wait(Option<Duration>),
    /// No more frames come.
    End,
}

#[derive(Debug, Default)]
struct State {
    live: bool,
    waiting: VecDeque<Waiting>,
    /// The input broke off or could not be opened.
    fault: Option<Error>,
    /// Where the feed has to read next, until it has started.
    seek: Option<Rational>,
    /// After a jump: its first frame is shown even while paused.
    jumped: bool,
    /// The target of the last jump, until its first frame is on the screen.
    aim: Option<Rational>,
    /// The number of that frame among those admitted, once it is one of them.
    landing: Option<u64>,
    paused: bool,
    /// Frames to be shown one by one.
    steps: u32,
    again: bool,
    over: bool,
    admitted: u64,
    arrived: u64,
    dropped: u64,
    decode: Duration,
    pace: Pace,
}

impl State {
    fn room(&self) -> bool {
        self.admitted - self.arrived < IN_FLIGHT
    }

    /// The action at `now`. Late frames of a file are dropped and counted if a later one is due as well, so that
    /// playback keeps its time.
    fn decide(&mut self, now: Duration) -> Decision {
        if self.over {
            return Decision::End;
        }
        if self.again && self.arrived > 0 {
            // The frame on the screen is the last one admitted once all have arrived.
            return if self.admitted == self.arrived {
                Decision::Again
            } else {
                Decision::Wait(None)
            };
        }
        let free = self.live || self.jumped || self.steps > 0;
        if self.paused && !self.jumped && self.steps == 0 {
            return Decision::Wait(None);
        }
        while let Some(front) = self.waiting.front() {
            if front.first && self.waiting.len() == 1 {
                // It was waited for: no frame is dropped because a decoder starts late.
                let due = self.pace.due(&front.decoded.span, now);
                if due < now {
                    self.pace.forget();
                }
            }
            let span = front.decoded.span;
            let due = if free { now } else { self.pace.due(&span, now) };
            if now < due {
                return Decision::Wait(Some(due));
            }
            let mut after = self.pace.clone();
            after.mark(due, span);
            let next = self.waiting.get(1).map(|next| after.due(&next.decoded.span, now));
            if !free && next.is_some_and(|next| next <= now) {
                self.waiting.pop_front();
                self.pace = after;
                self.dropped += 1;
                continue;
            }
            if !self.room() {
                return Decision::Wait(next.filter(|_| !free));
            }
            self.pace = after;
            return Decision::Admit;
        }
        match self.fault {
            Some(_) => Decision::End,
            None => Decision::Wait(None),
        }
    }

    /// The first waiting frame, for the pipeline.
    fn admit(&mut self) -> Option<Decoded> {
        let Waiting { decoded, .. } = self.waiting.pop_front()?;
        if self.steps > 0 || self.jumped {
            self.pace.forget();
        }
        self.steps = self.steps.saturating_sub(1);
        self.admitted += 1;
        if std::mem::take(&mut self.jumped) {
            self.landing = Some(self.admitted);
        }
        Some(decoded)
    }

    /// A picture has come out of the pipeline.
    fn arrive(&mut self) {
        self.arrived += 1;
        if self.landing.is_some_and(|landing| landing <= self.arrived) {
            (self.aim, self.landing) = (None, None);
        }
    }

    /// Goes on `seconds` from where it is, or is going to be after the last jump: `shown` is on the
    /// screen, of a stream that is `length` long.
    fn seek(&mut self, shown: Span, seconds: f64, length: Option<Rational>) {
        let from = Span { start: self.aim.unwrap_or(shown.start), ..shown };
        self.jump(sought(&from, seconds, length));
    }

    /// Goes on from `aim`.
    fn jump(&mut self, aim: Rational) {
        (self.seek, self.aim, self.landing) = (Some(aim), Some(aim), None);
        self.jumped = false;
        self.waiting.clear();
        self.pace.forget();
        self.again = false;
    }
}

/// Messages from the window to playback.
#[derive(Debug)]
pub(super) struct Deck {
    state: Mutex<State>,
    changed: Condvar,
    began: Instant,
}

/// The state of playback.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Going {
    /// Whether it is paused.
    pub(super) paused: bool,
    /// Number of dropped frames.
    pub(super) dropped: u64,
    /// Time that reading the last frame took.
    pub(super) decode: Duration,
}

impl Deck {
    /// Playback at its beginning, of a `live` source or of a file.
    pub(super) fn new(live: bool) -> Self {
        let state = State { live, ..State::default() };
        Self { state: Mutex::new(state), changed: Condvar::new(), began: Instant::now() }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // The state is valid even after a panic of another thread.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.lock());
        self.changed.notify_all();
    }

    /// Pauses, or goes on. Whether it is paused now.
    pub(super) fn pause(&self) -> bool {
        self.change(|state| {
            state.paused = !state.paused;
            state.steps = 0;
            state.pace.forget();
        });
        self.going().paused
    }

    /// Shows the next frame, and pauses.
    pub(super) fn step(&self) {
        self.change(|state| {
            state.paused = true;
            state.steps += 1;
        });
    }

    /// Goes on `seconds` from the picture `shown`, or from where the last jump goes if it is not there
    /// yet, in a stream that is `length` long.
    pub(super) fn seek(&self, shown: Span, seconds: f64, length: Option<Rational>) {
        self.change(|state| state.seek(shown, seconds, length));
    }

    /// Goes on `seconds` after the beginning. The rest is as for [`Deck::seek`].
    pub(super) fn seek_to(&self, shown: Span, seconds: f64, length: Option<Rational>) {
        let beginning = Span { start: Rational::ZERO, ..shown };
        self.change(|state| state.jump(sought(&beginning, seconds, length)));
    }

    /// Renders the frame on the screen once more, if no other replaces it anyway.
    pub(super) fn again(&self, alone: bool) {
        self.change(|state| state.again = alone || state.paused);
    }

    /// No more frames.
    pub(super) fn end(&self) {
        self.change(|state| state.over = true);
    }

    /// A picture has come out of the pipeline.
    pub(super) fn arrived(&self) {
        self.change(State::arrive);
    }

    /// The state of playback.
    pub(super) fn going(&self) -> Going {
        let state = self.lock();
        Going { paused: state.paused, dropped: state.dropped, decode: state.decode }
    }

    /// For the feed: where to read from if somebody wants to jump. Asked for once a jump.
    pub(super) fn sought(&self) -> Option<Rational> {
        let mut state = self.lock();
        let sought = state.seek.take();
        state.jumped |= sought.is_some();
        sought
    }

    /// For the feed: adds a frame that took `decode` to read, waiting for room; live, it takes the place
    /// of the one before. Whether to read on from here: not if all is over or somebody wants to jump.
    pub(super) fn feed(&self, decoded: Decoded, first: bool, decode: Duration) -> bool {
        let mut state = self.lock();
        let room = if state.live { 1 } else { AHEAD };
        while !state.live && state.waiting.len() >= room && !state.over && state.seek.is_none() {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if state.over || state.seek.is_some() {
            return false;
        }
        if state.waiting.len() >= room {
            state.waiting.pop_front();
            state.dropped += u64::from(!state.paused);
        }
        state.waiting.push_back(Waiting { decoded, first });
        state.decode = decode;
        drop(state);
        self.changed.notify_all();
        true
    }

    /// For the feed, when there is nothing to read any more: waits until somebody wants to jump.
    /// `false` when all is over.
    pub(super) fn wait_for_jump(&self) -> bool {
        let mut state = self.lock();
        while !state.over && state.seek.is_none() {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        !state.over
    }

    /// For the feed: whether the frames that it reads now are not needed, because of a jump
    /// or all is over.
    pub(super) fn looks_away(&self) -> bool {
        let state = self.lock();
        state.over || state.seek.is_some()
    }

    /// Whether no more frames are wanted.
    pub(super) fn is_over(&self) -> bool {
        self.lock().over
    }

    /// For the feed: the input cannot be read any further.
    pub(super) fn fail(&self, error: Error) {
        self.change(|state| state.fault = Some(error));
    }
}

/// The source that the pipeline sees.
pub(super) struct Playback {
    deck: Arc<Deck>,
    mailbox: Arc<Mailbox>,
    /// The frame that is due.
    ready: Option<Decoded>,
}

impl Playback {
    /// What `deck` lets in; what is shown once more comes out of `mailbox`.
    pub(super) fn new(deck: Arc<Deck>, mailbox: Arc<Mailbox>) -> Self {
        Self { deck, mailbox, ready: None }
    }

    /// The frame on the screen.
    fn on_screen(&self) -> Option<Decoded> {
        let shown = self.mailbox.newest()?;
        Some(Decoded::new(shown.origin.frame.clone(), shown.span))
    }
}

impl Source for Playback {
    fn wait(&mut self) {
        let deck = self.deck.clone();
        let mut state = deck.lock();
        loop {
            let now = deck.began.elapsed();
            match state.decide(now) {
                Decision::End => return,
                Decision::Admit => {
                    self.ready = state.admit();
                    // The feed has room.
                    deck.changed.notify_all();
                    return;
                }
                Decision::Again => {
                    state.again = false;
                    self.ready = self.on_screen();
                    if self.ready.is_some() {
                        state.admitted += 1;
                        return;
                    }
                }
                Decision::Wait(None) => {
                    state = deck.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                }
                Decision::Wait(Some(moment)) => {
                    let time = moment.saturating_sub(now);
                    let waited = deck.changed.wait_timeout(state, time);
                    state = waited.unwrap_or_else(PoisonError::into_inner).0;
                }
            }
        }
    }

    fn next(&mut self) -> Result<Option<Decoded>> {
        match self.ready.take() {
            Some(decoded) => Ok(Some(decoded)),
            None => self.deck.lock().fault.take().map_or(Ok(None), Err),
        }
    }
}

/// The position `seconds` away from `now` in a stream of this `length`, if known; not before its beginning, and not
/// so near to its end that no frame is left.
fn sought(now: &Span, seconds: f64, length: Option<Rational>) -> Rational {
    let frame = now.length.map_or(0.1, Rational::to_f64);
    let latest = length.map_or(f64::INFINITY, |length| length.to_f64() - 1.5 * frame);
    let target = (now.start.to_f64() + seconds).min(latest).max(0.0);
    Rational::new((target * 1000.0).floor() as i64, 1000)
}

#[cfg(test)]
#[path = "playback_tests.rs"]
mod tests;
