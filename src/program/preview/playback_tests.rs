//! Playback with invented times.

use super::*;
use polyreel::frame::Frame;
use polyreel::geom::Size;

const FRAME: Duration = Duration::from_micros(41_667);

fn decoded(index: i64) -> Decoded {
    let frame = Frame::filled(Size::new(1, 1), [0; 4]).expect("a frame");
    let span = Span { start: Rational::new(index, 24), length: Some(Rational::new(1, 24)) };
    Decoded::new(frame, span)
}

fn playing(frames: std::ops::Range<i64>) -> State {
    let waiting = frames.map(|i| Waiting { decoded: decoded(i), first: i == 0 }).collect();
    State { waiting, ..State::default() }
}

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// The frame in front is let in and arrives at once.
fn show(state: &mut State) -> Rational {
    let decoded = state.admit().expect("a frame");
    state.arrived += 1;
    decoded.span.start
}

/// Plays for `seconds`, the pipeline taking `work` for a frame, one at a time. Frames shown.
fn play(state: &mut State, seconds: u64, work: Duration) -> u64 {
    let (mut now, mut next, mut shown) = (Duration::ZERO, 0, 0);
    while now < Duration::from_secs(seconds) {
        while state.waiting.len() < AHEAD {
            state.waiting.push_back(Waiting { decoded: decoded(next % 48), first: next % 48 == 0 });
            next += 1;
        }
        match state.decide(now) {
            Decision::Admit => {
                show(state);
                shown += 1;
                now += work;
            }
            Decision::Wait(Some(moment)) => now = moment,
            other => panic!("{other:?}"),
        }
    }
    shown
}

#[test]
fn a_file_plays_at_its_own_rate_round_after_round() {
    let mut state = State::default();
    let shown = play(&mut state, 60, ms(10));
    assert!((24 * 60 - 1..=24 * 60 + 1).contains(&shown), "{shown}");
    assert_eq!(state.dropped, 0);
}

#[test]
fn where_rendering_is_too_slow_time_is_kept_right() {
    let mut state = State::default();
    let shown = play(&mut state, 60, ms(100));
    assert!((9 * 60..=10 * 60).contains(&shown), "{shown}");
    let all = shown + state.dropped;
    assert!((24 * 60 - 4..=24 * 60 + 4).contains(&all), "{all}");
}

#[test]
fn a_late_frame_is_left_out_only_for_one_that_is_due() {
    let mut state = playing(0..1);
    assert_eq!(state.decide(ms(0)), Decision::Admit);
    show(&mut state);
    state.waiting.push_back(Waiting { decoded: decoded(1), first: false });
    assert_eq!(state.decide(ms(500)), Decision::Admit, "late, but there is nothing newer");
    assert_eq!(state.dropped, 0);
}

#[test]
fn the_pipeline_holds_two_frames_at_most() {
    let mut state = playing(0..3);
    for now in [Duration::ZERO, FRAME] {
        assert_eq!(state.decide(now), Decision::Admit);
        state.admit().expect("a frame");
    }
    assert_eq!(state.decide(2 * FRAME), Decision::Wait(None));
    state.arrived += 1;
    assert_eq!(state.decide(2 * FRAME), Decision::Admit);
}

#[test]
fn nothing_moves_while_paused_but_steps_and_jumps() {
    let mut state = playing(0..4);
    state.paused = true;
    assert_eq!(state.decide(ms(5000)), Decision::Wait(None));
    state.steps = 2;
    for frame in [0, 1] {
        assert_eq!(state.decide(ms(5000)), Decision::Admit, "a step does not wait for its time");
        assert_eq!(show(&mut state), Rational::new(frame, 24));
    }
    assert_eq!(state.decide(ms(9000)), Decision::Wait(None));
    state.jumped = true;
    assert_eq!(state.decide(ms(9000)), Decision::Admit);
    show(&mut state);
    assert_eq!(state.decide(ms(9000)), Decision::Wait(None));
    assert_eq!(state.dropped, 0);
}

/// Two quick presses used to go where one goes: the second began from the same picture.
#[test]
fn every_jump_begins_where_the_one_before_goes() {
    let span = |second: i64| Span { start: Rational::new(second, 1), ..decoded(0).span };
    let length = Some(Rational::new(60, 1));
    let mut state = playing(0..2);
    show(&mut state);
    state.seek(span(0), 5.0, length);
    state.seek(span(0), 5.0, length);
    assert_eq!(state.seek.take(), Some(Rational::new(10, 1)));
    // Of its first frame nothing is on the screen yet.
    state.jumped = true;
    state.waiting = playing(240..243).waiting;
    state.admit().expect("a frame");
    state.seek(span(0), -2.5, length);
    assert_eq!(state.seek.take(), Some(Rational::new(15, 2)));
    state.arrive();
    state.jumped = true;
    state.waiting = playing(180..183).waiting;
    state.admit().expect("a frame");
    state.arrive();
    state.admit().expect("a frame");
    state.seek(span(8), 5.0, length);
    assert_eq!(state.seek, Some(Rational::new(13, 1)), "the picture on the screen counts again");
}

#[test]
fn a_change_while_paused_shows_the_same_frame_again_and_alone() {
    let mut state = playing(0..4);
    assert_eq!(state.decide(ms(0)), Decision::Admit);
    state.admit().expect("a frame");
    (state.paused, state.again) = (true, true);
    assert_eq!(state.decide(ms(1)), Decision::Wait(None), "it has not arrived yet");
    state.arrived += 1;
    assert_eq!(state.decide(ms(2)), Decision::Again);
}

#[test]
fn after_a_pause_playback_goes_on_from_there() {
    let deck = Deck::new(false);
    {
        let mut state = deck.lock();
        state.waiting = playing(0..3).waiting;
        assert_eq!(state.decide(ms(0)), Decision::Admit);
        show(&mut state);
    }
    deck.pause();
    deck.pause();
    let mut state = deck.lock();
    assert_eq!(state.decide(ms(9000)), Decision::Admit);
    show(&mut state);
    assert_eq!(state.decide(ms(9000)), Decision::Wait(Some(ms(9000) + step_of_a_frame())));
    assert_eq!(state.dropped, 0);
}

fn step_of_a_frame() -> Duration {
    super::super::pace::step(&decoded(0).span, &decoded(1).span)
}

#[test]
fn live_sources_keep_the_newest_and_count_the_others() {
    let deck = Deck::new(true);
    for i in 0..5 {
        assert!(deck.feed(decoded(i), i == 0, Duration::ZERO));
    }
    assert_eq!(deck.going().dropped, 4);
    let mut state = deck.lock();
    assert_eq!(state.decide(ms(0)), Decision::Admit);
    assert_eq!(show(&mut state), Rational::new(4, 24));
}

#[test]
fn a_jump_forgets_what_was_read_ahead() {
    let deck = Deck::new(false);
    assert!(deck.feed(decoded(0), true, Duration::ZERO));
    deck.seek(decoded(0).span, 3.0, None);
    assert!(!deck.feed(decoded(1), false, Duration::ZERO), "read before the jump");
    assert_eq!(deck.sought(), Some(Rational::new(3, 1)));
    assert!(deck.feed(decoded(72), true, Duration::ZERO));
    let mut state = deck.lock();
    assert_eq!(state.decide(ms(0)), Decision::Admit);
    assert_eq!(show(&mut state), Rational::new(3, 1));
}

#[test]
fn faults_come_after_the_frames_before_them() {
    let mut state = playing(0..1);
    state.fault = Some(Error::usage("broken"));
    assert_eq!(state.decide(ms(0)), Decision::Admit);
    show(&mut state);
    assert_eq!(state.decide(ms(1)), Decision::End);
    state.over = true;
    assert_eq!(state.decide(ms(1)), Decision::End);
}

#[test]
fn jumps_stay_in_the_stream() {
    let at = |seconds: i64| Span {
        start: Rational::new(seconds, 1),
        length: Some(Rational::new(1, 25)),
    };
    let length = Some(Rational::new(10, 1));
    assert_eq!(sought(&at(4), 5.0, length), Rational::new(9, 1));
    assert_eq!(sought(&at(4), -5.0, length), Rational::ZERO);
    let last = sought(&at(8), 5.0, length).to_f64();
    assert!(last < 9.96 && last > 9.9, "{last}: the last frame starts at 9.96");
    assert_eq!(sought(&at(8), 5.0, None), Rational::new(13, 1));
}
