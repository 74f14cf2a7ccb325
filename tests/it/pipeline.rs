//! The threaded pipeline against the serial renderer, and its ways to end.

mod trial;

use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::Ordering::SeqCst;
use std::time::{Duration, Instant};

use polyreel::error::Error;
use polyreel::options::Points;
use polyreel::pipeline::{Ending, FrameReport, IN_FLIGHT, Observer, Settings, Stop, run};
use polyreel::render::Renderer;
use polyreel::stage::Stage;

use trial::{Log, Mishap, StubSink, Trial, Watcher, assert_written, finished, frame};
#[test]
fn painted_frames_are_recycled_by_the_source() {
    let trial = Trial { frames: 4 * IN_FLIGHT as u64, ..Trial::default() };
    let (ended, log) = trial.run(&mut ());
    ended.expect("renders");
    let recycled = log.recycled.lock().expect("the lock");
    assert!(
        !recycled.is_empty(),
        "the source waits for a channel, so that frames are painted before its end"
    );
    // In order; some may have been dropped because the channel was full.
    let mut film = (0..trial.frames).map(|index| frame(index).frame);
    assert!(recycled.iter().all(|recycled| film.any(|frame| frame == *recycled)));
}

#[test]
fn threads_make_the_pictures_of_the_serial_renderer() {
    for threads in [None, NonZeroUsize::new(1), NonZeroUsize::new(2), NonZeroUsize::new(8)] {
        let mut trial = Trial::default();
        trial.settings.threads = threads;
        let mut watcher = Watcher::default();
        let (ended, log) = trial.run(&mut watcher);
        let summary = ended.expect("a run without mishaps");
        assert!(matches!(summary.ending, Ending::Complete));
        assert!(finished(&log));
        assert_eq!((summary.frames, summary.dropped), (12, 0));
        assert_written(&log, 12);
        let order: Vec<_> = watcher.reports.iter().map(|report| report.index).collect();
        assert_eq!(order, (0..12).collect::<Vec<_>>());
    }
}

#[test]
fn reports_tell_what_the_renderer_counts() {
    let mut watcher = Watcher::default();
    let began = Instant::now();
    let (ended, _) = Trial::default().run(&mut watcher);
    let wall = began.elapsed();
    let summary = ended.expect("a run without mishaps");
    let mut renderer = Renderer::new(&Trial::default().settings.options).expect("sound options");
    for (report, index) in watcher.reports.iter().zip(0..) {
        let rendered = renderer.render(&frame(index).frame).expect("renders");
        assert_eq!(report.candidates, rendered.candidates);
        assert_eq!(report.seeds, rendered.mesh.seeds().len());
        assert_eq!(report.triangles, rendered.mesh.triangles.len());
        assert_eq!(report.seeds_born, rendered.life.born);
        assert_eq!(report.pts_s, index as f64 / 25.0);
        let stages = [Stage::Features, Stage::Sample, Stage::Triangulate, Stage::Rasterise];
        for stage in stages {
            assert!(report.timing.get(stage) > Duration::ZERO, "{stage} took no time");
        }
        let spent: Duration = stages.into_iter().map(|stage| report.timing.get(stage)).sum();
        assert!(spent < wall, "{spent:?} of {wall:?}");
    }
    let mut times: Vec<_> =
        watcher.reports.iter().map(|report| report.timing.get(Stage::Triangulate)).collect();
    times.sort();
    let median = summary.stages.get(Stage::Triangulate).p50_ms;
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    // The summary counts in classes of a few per cent.
    assert!(median >= 0.9 * ms(times[5]) && median <= 1.1 * ms(times[6]), "{median} {times:?}");
    assert!(summary.fps() >= 12.0 / wall.as_secs_f64(), "{} in {wall:?}", summary.fps());
}

#[test]
fn waiting_is_not_work() {
    // Long enough that a busy machine does not take as long for anything else.
    let sink_pace = Duration::from_millis(100);
    let (ended, _) = Trial { frames: 14, sink_pace, ..Trial::default() }.run(&mut ());
    let stages = ended.expect("a slow sink is no mishap").stages;
    assert!(stages.get(Stage::Encode).p50_ms >= 100.0);
    // More frames than there is room for: all stages wait for the sink, and none counts it as work.
    for stage in [Stage::Decode, Stage::Features, Stage::Refine, Stage::Rasterise] {
        let ms = stages.get(stage).p50_ms;
        assert!(ms < 80.0, "{stage}: {ms} ms");
    }
}

#[test]
fn a_source_that_fails_delivers_the_frames_before_and_no_output() {
    for at in [0, 1, 7] {
        let trial = Trial { source: Some((at, Mishap::Error)), ..Trial::default() };
        let (ended, log) = trial.run(&mut ());
        let error = ended.expect_err("the source failed").to_string();
        assert_eq!(error, format!("frame {at}, decode: stub: an invented error"));
        assert_written(&log, at);
        assert!(!finished(&log));
    }
}

#[test]
fn an_input_that_breaks_off_is_kept_where_that_is_allowed() {
    for mishap in [Mishap::Truncation, Mishap::Corruption] {
        let mut trial = Trial { source: Some((5, mishap)), ..Trial::default() };
        let (ended, log) = trial.run(&mut ());
        ended.expect_err("not allowed");
        assert!(!finished(&log));

        trial.settings.allow_truncated = true;
        let (ended, log) = trial.run(&mut ());
        let summary = ended.expect("allowed");
        assert!(matches!(summary.ending, Ending::Truncated(_)), "{:?}", summary.ending);
        assert_written(&log, 5);
        assert!(finished(&log));

        trial.source = Some((0, mishap));
        let (ended, log) = trial.run(&mut ());
        ended.expect_err("nothing can be kept of nothing");
        assert!(!finished(&log));
    }
}

#[test]
fn what_fails_is_no_shorter_input() {
    let mut trial = Trial { source: Some((5, Mishap::Error)), ..Trial::default() };
    trial.settings.allow_truncated = true;
    let (ended, log) = trial.run(&mut ());
    ended.expect_err("a decoder that fails is no truncated input");
    assert!(!finished(&log));

    let mut trial = Trial { sink: Some((5, Mishap::Error)), ..Trial::default() };
    trial.settings.allow_truncated = true;
    let (ended, log) = trial.run(&mut ());
    ended.expect_err("a failing output is no truncated input");
    assert!(!finished(&log));
}

#[test]
fn a_sink_that_fails_ends_the_run_unfinished() {
    for at in [0, 1, 7, 11] {
        let trial = Trial { sink: Some((at, Mishap::Error)), ..Trial::default() };
        let (ended, log) = trial.run(&mut ());
        let error = ended.expect_err("the sink failed").to_string();
        assert_eq!(error, format!("frame {at}, encode: stub: an invented error"));
        assert_written(&log, at);
        assert!(!finished(&log));
    }
}

#[test]
fn the_first_error_in_frame_order_wins() {
    // The sink fails after the source has, at an earlier frame.
    let trial = Trial {
        source: Some((5, Mishap::Error)),
        sink: Some((2, Mishap::Error)),
        sink_fails_last: true,
        ..Trial::default()
    };
    let (ended, log) = trial.run(&mut ());
    assert!(log.source_failed.load(SeqCst));
    assert!(ended.expect_err("both failed").to_string().starts_with("frame 2, encode"));
}

#[test]
fn a_reader_who_leaves_is_no_error() {
    let trial = Trial { frames: u64::MAX, sink: Some((3, Mishap::Closed)), ..Trial::default() };
    let (ended, log) = trial.run(&mut ());
    let summary = ended.expect("a closed output is a quiet end");
    assert!(matches!(summary.ending, Ending::Closed));
    assert_eq!(summary.frames, 3);
    assert_written(&log, 3);
}

#[test]
fn panics_of_source_sink_and_observer_are_resumed_at_the_caller() {
    struct Panicker;
    impl Observer for Panicker {
        fn frame_done(&mut self, _: &FrameReport) -> ControlFlow<()> {
            panic!("an invented panic")
        }
    }
    let endless = Trial { frames: u64::MAX, ..Trial::default() };
    let mut live = endless.clone();
    live.settings.live = true;
    let trials = [
        Trial { source: Some((4, Mishap::Panic)), ..endless.clone() },
        Trial { sink: Some((4, Mishap::Panic)), ..endless.clone() },
        Trial { sink: Some((4, Mishap::Panic)), ..live.clone() },
    ];
    for trial in trials {
        let (message, log) = trial.panic(&mut ());
        assert_eq!(message, "an invented panic");
        assert_written_unless_live(&trial, &log, 4);
        assert!(!finished(&log));
    }
    for trial in [endless, live] {
        let (message, log) = trial.panic(&mut Panicker);
        assert_eq!(message, "an invented panic");
        assert!(!finished(&log));
    }
}

fn assert_written_unless_live(trial: &Trial, log: &Log, frames: u64) {
    if trial.settings.live {
        assert_eq!(log.written(), frames);
    } else {
        assert_written(log, frames);
    }
}

#[test]
fn a_stop_is_a_shorter_input() {
    let trial = Trial { frames: u64::MAX, ..Trial::default() };
    let mut watcher = Watcher { stop_after: Some(5), ..Watcher::default() };
    let (ended, log) = trial.run(&mut watcher);
    let summary = ended.expect("a stop is no error");
    assert!(matches!(summary.ending, Ending::Stopped));
    assert!(finished(&log));
    // What was in flight is delivered, and nothing is lost.
    assert!(summary.frames >= 5 && summary.frames <= 5 + IN_FLIGHT as u64 + 2);
    assert_eq!(log.decoded.load(SeqCst), summary.frames);
    assert_written(&log, summary.frames);
}

#[test]
fn a_stop_before_the_first_frame_leaves_no_output() {
    let trial = Trial::default();
    trial.stop.request();
    let (ended, log) = trial.run(&mut ());
    let summary = ended.expect("a stop is no error");
    assert!(matches!(summary.ending, Ending::Stopped));
    assert_eq!(summary.frames, 0);
    assert!(!finished(&log));
}

#[test]
fn an_input_without_frames_is_an_error() {
    let trial = Trial { frames: 0, ..Trial::default() };
    let (ended, log) = trial.run(&mut ());
    assert!(matches!(ended, Err(Error::NoFrames)));
    assert!(!finished(&log));
}

#[test]
fn a_source_that_cannot_start_says_why() {
    let log = Arc::new(Log::default());
    let sink = StubSink { log: log.clone(), mishap: None, pace: Duration::ZERO, fails_last: false };
    let ended = run(
        || Err(Error::usage("an invented reason")),
        Box::new(sink),
        &Settings::default(),
        &mut (),
        &Stop::default(),
    );
    assert_eq!(ended.expect_err("it did not start").to_string(), "an invented reason");
    assert!(!finished(&log));
}

#[test]
fn options_out_of_range_are_refused_before_anything_starts() {
    let mut trial = Trial::default();
    trial.settings.options.points = Points::Count(0);
    let (ended, log) = trial.run(&mut ());
    assert!(ended.is_err_and(|error| error.is_usage()));
    assert_eq!(log.decoded.load(SeqCst), 0);
}

#[test]
fn frames_in_flight_are_bounded_whoever_is_slow() {
    for (source_pace, sink_pace) in [(0, 0), (0, 5), (5, 0)]
        .map(|(source, sink)| (Duration::from_millis(source), Duration::from_millis(sink)))
    {
        let trial = Trial { frames: 60, source_pace, sink_pace, ..Trial::default() };
        let (ended, log) = trial.run(&mut ());
        ended.expect("a slow neighbour is no mishap");
        let most = log.most_in_flight.load(SeqCst);
        assert!(most <= IN_FLIGHT as u64, "{most} frames at a time");
        assert_written(&log, 60);
    }
}

#[test]
fn live_frames_are_dropped_at_admission_and_counted() {
    let mut trial = Trial {
        frames: 200,
        source_pace: Duration::from_millis(1),
        sink_pace: Duration::from_millis(15),
        ..Trial::default()
    };
    trial.settings.live = true;
    let mut watcher = Watcher::default();
    let (ended, log) = trial.run(&mut watcher);
    let summary = ended.expect("drops are no error");
    assert!(summary.dropped > 0);
    assert_eq!(summary.frames + summary.dropped, 200, "every frame is written or counted");
    let indices: Vec<_> = watcher.reports.iter().map(|report| report.index).collect();
    assert!(indices.is_sorted_by(|a, b| a < b), "{indices:?}");
    assert_eq!(indices.last(), Some(&199), "the newest frame is kept");
    assert!(finished(&log));
}
