//! `polyreel preview`: a live window; and the window of a render.
//!
//! Four parts, none of which waits for the window: the [feed] reads ahead, [playback] admits frames at their time,
//! the pipeline renders, and the [mailbox] holds the newest picture for the window, which has the main thread.

mod act;
mod canvas;
mod change;
mod export;
mod feed;
mod full_screen;
mod history;
mod keys;
mod lens;
mod mailbox;
mod name;
mod pace;
mod panel;
mod picture;
mod playback;
mod readout;
mod recorder;
mod scene;
mod session;
mod status;
mod window;

use std::ffi::OsString;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use polyreel::error::Result;
use polyreel::ffmpeg::Processes;
use polyreel::geom::Size;
use polyreel::options::Colour;
use polyreel::pipeline::{
    self, Controls, DetailPolicy, FrameReport, Observer, Settings, Stop, Summary,
};
use polyreel::sink::{Sink, SinkOptions};
use polyreel::source;
use polyreel::stream::StreamInfo;

use crate::program::Outcome;
use crate::program::budget::Budget;
use crate::program::cli::PreviewArgs;
use crate::program::interrupt::Interrupt;
use history::History;
use mailbox::{Glance, Mailbox, Screen};
use playback::{Deck, Playback};
use recorder::Recorder;
use session::{Playing, Session, View};
use window::Window;

/// The first size of a window, in pixels of a display of usual density.
const ROOM: (u32, u32) = (1280, 760);

/// The largest factor by which small pictures are magnified at first.
const MAGNIFIED: u32 = 4;

/// Shows the input in a window until it is closed.
pub(crate) fn preview(args: &PreviewArgs) -> Result<Outcome> {
    let asked = args.look.options()?;
    let stop = Stop::default();
    let interrupt = Interrupt::listen(&stop);
    let processes = interrupt.processes();
    let input = source::open(&args.input.inputs, &args.input.options(processes.clone()))?;
    let info = input.info().clone();
    let stem = name::stem(&args.input.inputs);
    let window = open(&stem, info.size, args.scale)?;
    let outline = asked.outline;
    let controls = Controls::new(session::effective(&asked, info.still))?;
    let recording = SinkOptions {
        inputs: input.paths().to_vec(),
        video: args.input.video_options(processes.clone()),
        unfinished: interrupt.unfinished(),
        ..SinkOptions::default()
    };
    let playing = Playing {
        deck: Arc::new(Deck::new(info.live)),
        recorder: Arc::new(Recorder::new(&info, recording, &stem)),
        seekable: input.repeats() && !info.still,
        input: args.input.clone(),
        interrupt: interrupt.clone(),
        export: None,
    };
    let (deck, recorder) = (playing.deck.clone(), playing.recorder.clone());
    let mailbox = Arc::<Mailbox>::default();
    feed::spawn(input, args.input.allow_truncated, &deck)?;
    let budget = budget(args, &info)?;
    let settings = Settings {
        controls: Some(controls.clone()),
        detail_policy: budget.map_or(DetailPolicy::Options, DetailPolicy::Budget),
        threads: args.threads,
        allow_truncated: args.input.allow_truncated,
        ..Settings::default()
    };
    let playback = Playback::new(deck.clone(), mailbox.clone());
    let screen = Box::new(Screen {
        mailbox: mailbox.clone(),
        deck: deck.clone(),
        recorder: recorder.clone(),
    });
    let playing = Some(playing);
    let view = View::new(outline);
    let history = History::new(asked);
    let session = Session { window, mailbox, playing, history, controls, info, stem, budget, view };
    interrupt.begin();
    let ended = with_window(
        session,
        &stop,
        || {
            deck.end();
            processes.end_readers();
        },
        |stop, observer| {
            pipeline::run(move || Ok(Box::new(playback)), screen, &settings, observer, stop)
        },
    );
    recorder.close().iter().for_each(crate::program::terminal::say);
    ended?;
    Ok(if interrupt.happened() { Outcome::Interrupted } else { Outcome::Done })
}

/// The time budget for a frame: by default its duration, if known.
fn budget(args: &PreviewArgs, info: &StreamInfo) -> Result<Option<Duration>> {
    match args.budget {
        Some(budget) => budget.time(info).map(Some),
        None => Ok(Budget::Auto.time(info).ok()),
    }
}

/// The window of a render, which shows the pictures of its output.
pub(crate) struct RenderWindow(Session);

impl RenderWindow {
    /// Opens the window for a render of `inputs`, a stream of `info`.
    ///
    /// # Errors
    /// When there is no display.
    pub(crate) fn open(inputs: &[OsString], info: &StreamInfo, controls: Controls) -> Result<Self> {
        let stem = name::stem(inputs);
        Ok(Self(Session {
            window: open(&stem, info.size, None)?,
            mailbox: Arc::default(),
            playing: None,
            history: History::new((*controls.options()).clone()),
            controls,
            info: info.clone(),
            stem,
            budget: None,
            view: View::new(None::<Colour>),
        }))
    }

    /// `sink`, watched by the window.
    pub(crate) fn watch(&self, inner: Box<dyn Sink>) -> Box<dyn Sink> {
        Box::new(Glance { inner, mailbox: self.0.mailbox.clone() })
    }

    /// Does `run` on another thread. Closing the window requests `stop`.
    pub(crate) fn run(
        self,
        stop: &Stop,
        processes: &Processes,
        observer: &mut (dyn Observer + Send),
        run: impl FnOnce(&mut dyn Observer) -> Result<Summary> + Send,
    ) -> Result<Summary> {
        with_window(
            self.0,
            stop,
            || processes.end_readers(),
            |_, noting| run(&mut Both(noting, observer)),
        )
    }
}

/// Does `run` on a thread of its own while `session` has the main thread. When the window is closed
/// `stop` is requested and `end` called.
fn with_window(
    mut session: Session,
    stop: &Stop,
    end: impl FnOnce(),
    run: impl FnOnce(&Stop, &mut dyn Observer) -> Result<Summary> + Send,
) -> Result<Summary> {
    let mailbox = session.mailbox.clone();
    thread::scope(|scope| {
        let running = scope.spawn(|| {
            // Even after a panic the window must know that no more pictures come.
            let _closing = Closing(&mailbox);
            run(stop, &mut Noting(&mailbox))
        });
        let shown = session.run(stop);
        stop.request();
        end();
        // The window closes at once, however long the output takes.
        drop(session);
        let summary = running.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        shown.map(|()| summary)
    })
}

struct Closing<'a>(&'a Mailbox);

impl Drop for Closing<'_> {
    fn drop(&mut self) {
        self.0.close();
    }
}

/// Keeps the newest report for the status line.
struct Noting<'a>(&'a Mailbox);

impl Observer for Noting<'_> {
    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()> {
        self.0.note(report);
        ControlFlow::Continue(())
    }
}

/// Two observers, the second of which may stop the run.
struct Both<'a, 'b>(&'a mut dyn Observer, &'b mut (dyn Observer + Send));

impl Observer for Both<'_, '_> {
    fn frame_done(&mut self, report: &FrameReport) -> ControlFlow<()> {
        let _ = self.0.frame_done(report);
        self.1.frame_done(report)
    }
}

fn open(stem: &str, size: Size, scale: Option<f64>) -> Result<Window> {
    Window::open(&format!("{stem} - polyreel"), first_size(size, scale, density()))
}

/// The size of a window for pictures of `size`: `scale` times as large, or so that it suits a display of
/// `density`.
fn first_size(size: Size, scale: Option<f64>, density: u32) -> (usize, usize) {
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    let room = (f64::from(ROOM.0 * density), f64::from(ROOM.1 * density));
    let fit = (room.0 / width).min(room.1 / height);
    let usual = if fit >= 1.0 { fit.floor().min(f64::from(MAGNIFIED * density)) } else { fit };
    let scale = scale.unwrap_or(usual);
    let side = |side: f64| ((side * scale).round() as usize).clamp(1, 16384);
    let (width, picture) = (side(width).max(320), side(height));
    // The picture has the intended size, and the bar is below it.
    (width, picture + panel::bar_below(picture.max(200)))
}

/// Pixels of the display for one of usual size, if the desktop sets it.
fn density() -> u32 {
    let scale = ["GDK_SCALE", "QT_SCALE_FACTOR"].into_iter().find_map(|name| {
        std::env::var(name).ok()?.parse::<f64>().ok().filter(|scale| *scale >= 1.0)
    });
    scale.map_or(1, |scale| scale.min(4.0) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_suits_picture_and_display() {
        let picture = |size, scale, density| {
            let (width, height) = first_size(size, scale, density);
            (width, height, width as f64 / height as f64)
        };
        let (width, height, _) = picture(Size::new(1920, 1080), None, 1);
        assert!(width == 1280 && (720..800).contains(&height), "{width}x{height}");
        let (width, height, _) = picture(Size::new(320, 240), None, 1);
        assert!(width == 960 && (720..800).contains(&height), "{width}x{height}");
        assert_eq!(picture(Size::new(1920, 1080), None, 2).0, 1920);
        assert_eq!(picture(Size::new(640, 360), None, 2).0, 2560);
        assert_eq!(picture(Size::new(1920, 1080), Some(0.5), 1).0, 960);
        let (width, height, _) = picture(Size::new(1, 16384), None, 1);
        assert!(width == 320 && height < 900, "{width}x{height}");
    }
}
