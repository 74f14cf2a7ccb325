//! The window of a preview: shows pictures, and hands keys and the mouse on, until it is closed.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use polyreel::error::Result;
use polyreel::options::{Colour, Options};
use polyreel::pipeline::{Controls, Stop};
use polyreel::sample::Sampler;
use polyreel::stage::Stage;
use polyreel::stream::StreamInfo;

use crate::program::cli::InputArgs;
use crate::program::interrupt::Interrupt;

use super::canvas::Canvas;
use super::export::Export;
use super::history::History;
use super::lens::Lens;
use super::mailbox::{Mailbox, Shown};
use super::panel::Panel;
use super::playback::Deck;
use super::readout::{clock, look, reduced, state};
use super::recorder::Recorder;
use super::scene::{Places, Scene, draw};
use super::status::{Status, figures};
use super::window::Window;

/// The longest wait for a picture before keys are read again.
const TICK: Duration = Duration::from_millis(8);

/// Interval of redraws when nothing happens: the window may have been covered.
const REDRAW: Duration = Duration::from_millis(500);

/// Time for which a note is shown.
const NOTE: Duration = Duration::from_secs(4);

/// Time over which the rate is averaged.
const RATE: Duration = Duration::from_secs(2);

/// The playback controls of a run that is only a preview.
pub(super) struct Playing {
    pub(super) deck: Arc<Deck>,
    pub(super) recorder: Arc<Recorder>,
    /// Whether it is a file that can be seeked.
    pub(super) seekable: bool,
    /// The input as on the command line, for exports.
    pub(super) input: InputArgs,
    pub(super) interrupt: Interrupt,
    pub(super) export: Option<Export>,
}

/// A window and its content.
pub(super) struct Session {
    pub(super) window: Window,
    pub(super) mailbox: Arc<Mailbox>,
    /// `None` in the window of a render, which cannot be controlled.
    pub(super) playing: Option<Playing>,
    /// The looks that the user chose. A preset is written from the current one.
    pub(super) history: History,
    /// The options of the run: the [effective] ones.
    pub(super) controls: Controls,
    pub(super) info: StreamInfo,
    /// The base name of files.
    pub(super) stem: String,
    pub(super) budget: Option<Duration>,
    pub(super) view: View,
}

/// What the mouse holds while its button is down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Grip {
    /// Nothing that moves.
    Nothing,
    Slider,
    Timeline,
    /// The picture, and where the mouse was last.
    Picture((f64, f64)),
}

/// How the window looks.
#[derive(Debug)]
pub(super) struct View {
    pub(super) shown: Option<Arc<Shown>>,
    canvas: Canvas,
    pub(super) places: Places,
    pub(super) lens: Lens,
    pub(super) grip: Option<Grip>,
    pub(super) help: bool,
    pub(super) figures: bool,
    pub(super) is_bar_hidden: bool,
    pub(super) overlay: bool,
    pub(super) split: bool,
    pub(super) slider: f64,
    pub(super) outline: Colour,
    /// The time in seconds that the timeline was last dragged to.
    pub(super) sought: Option<f64>,
    note: Option<(String, Instant)>,
    drawn: VecDeque<Instant>,
    last: Instant,
    /// The frame whose figures are shown.
    reported: Option<u64>,
    pub(super) stale: bool,
}

impl View {
    /// An empty view; `outline` is the colour of a new outline.
    pub(super) fn new(outline: Option<Colour>) -> Self {
        Self {
            shown: None,
            canvas: Canvas::new(1, 1),
            places: Places::default(),
            lens: Lens::default(),
            grip: None,
            help: false,
            figures: false,
            is_bar_hidden: false,
            overlay: false,
            split: false,
            slider: 0.5,
            outline: outline.unwrap_or(Colour([0, 0, 0, 255])),
            sought: None,
            note: None,
            drawn: VecDeque::new(),
            last: Instant::now(),
            reported: None,
            stale: true,
        }
    }

    pub(super) fn note(&mut self, text: String) {
        self.note = Some((text, Instant::now()));
        self.stale = true;
    }

    /// The current rate of drawn pictures.
    fn rate(&self) -> f64 {
        let (Some(first), Some(last)) = (self.drawn.front(), self.drawn.back()) else { return 0.0 };
        let seconds = last.duration_since(*first).as_secs_f64();
        if seconds > 0.0 { (self.drawn.len() - 1) as f64 / seconds } else { 0.0 }
    }
}

/// The options that are rendered when the user has chosen `asked`. For a `still` coherence has no effect, and
/// --refine STEPS means that number of steps.
pub(super) fn effective(asked: &Options, still: bool) -> Options {
    let coherence = if still { 0.0 } else { asked.coherence };
    Options { coherence, ..asked.clone() }
}

impl Session {
    /// Shows pictures until the window is closed, `stop` is requested, or no more come.
    pub(super) fn run(&mut self, stop: &Stop) -> Result<()> {
        while !stop.is_requested() && !self.mailbox.is_closed() {
            let picture = self.mailbox.fetch(TICK);
            for press in self.window.poll() {
                if self.press(press).is_break() {
                    return Ok(());
                }
            }
            if !self.window.is_open() {
                return Ok(());
            }
            self.follow_mouse();
            self.tidy();
            let now = Instant::now();
            if let Some(shown) = picture {
                self.view.shown = Some(shown);
                self.view.drawn.push_back(now);
                self.view.stale = true;
            }
            // The figures of a picture come after it: without another picture, wait for them.
            let is_shown = self.mailbox.noted().map(|report| report.index) == self.view.reported;
            self.view.stale |= !is_shown && now.duration_since(self.view.last) > 5 * TICK;
            let resized = self.window.size() != (self.view.canvas.width, self.view.canvas.height);
            if self.view.stale || resized || now.duration_since(self.view.last) >= REDRAW {
                self.draw(now)?;
            }
        }
        Ok(())
    }

    fn draw(&mut self, now: Instant) -> Result<()> {
        let (width, height) = self.window.size();
        if (width, height) != (self.view.canvas.width, self.view.canvas.height) {
            self.view.canvas = Canvas::new(width, height);
        }
        let status = self.status();
        let panel = self.panel(&status);
        self.view.reported = status.report.map(|report| report.index);
        let view = &mut self.view;
        let options = self.controls.options();
        let size = view.shown.as_ref().map(|shown| shown.frame.size());
        let scene = Scene {
            shown: view.shown.as_deref(),
            lens: view.lens,
            split: view.split.then_some(view.slider),
            grid: size.filter(|_| view.overlay).map(|size| Sampler::new(&options).grid(size)),
            panel,
        };
        view.places = draw(&mut view.canvas, &scene);
        view.last = now;
        view.stale = false;
        self.window.show(&view.canvas)
    }

    fn panel(&self, status: &Status) -> Panel {
        let (view, chosen) = (&self.view, self.history.now());
        let mut words = look(chosen.name(), &chosen.options, status);
        let zoom = view.lens.zoom();
        words.extend(view.lens.is_zoomed().then(|| format!("zoom {zoom:.1}")));
        let reduced = |report| reduced(report, &chosen.options, self.info.size);
        let hint = "h: help".to_owned();
        Panel {
            look: words,
            alert: status.report.as_ref().filter(|_| self.budget.is_some()).and_then(reduced),
            state: if self.info.still && status.exporting.is_none() { hint } else { state(status) },
            played: status
                .length
                .filter(|_| !self.info.still)
                .map(|length| status.position / length),
            clock: if self.info.still { String::new() } else { clock(status) },
            note: view.note.as_ref().map(|(text, _)| text.clone()),
            figures: if view.figures { figures(status) } else { Vec::new() },
            help: view.help,
            is_hidden: view.is_bar_hidden,
        }
    }

    fn status(&self) -> Status {
        let report = self.mailbox.noted();
        let playing = self.playing.as_ref();
        let going = playing.map(|playing| playing.deck.going()).unwrap_or_default();
        let decode = if playing.is_some() {
            going.decode
        } else {
            report.as_ref().map_or(Duration::ZERO, |r| r.timing.get(Stage::Decode))
        };
        Status {
            rate: self.view.rate(),
            budget: self.budget,
            report,
            decode,
            dropped: going.dropped,
            missed: playing.map_or(0, |_| self.mailbox.missed()),
            position: self.position(),
            length: self.info.duration.map(|length| length.to_f64()),
            paused: going.paused,
            recording: playing.is_some_and(|playing| playing.recorder.is_on()),
            still: self.info.still,
            exporting: playing.and_then(|playing| playing.export.as_ref()).map(Export::share),
        }
    }

    /// The time of the picture in the stream, in seconds.
    pub(super) fn position(&self) -> f64 {
        self.view.shown.as_ref().map_or(0.0, |shown| shown.span.start.to_f64())
    }

    /// Removes old notes, and reports completed recordings and exports.
    fn tidy(&mut self) {
        let now = Instant::now();
        let recent = |then: &Instant| now.duration_since(*then) <= RATE;
        while self.view.drawn.front().is_some_and(|then| !recent(then)) {
            self.view.drawn.pop_front();
        }
        if self.view.note.as_ref().is_some_and(|(_, then)| now.duration_since(*then) > NOTE) {
            self.view.note = None;
            self.view.stale = true;
        }
        let Some(playing) = &mut self.playing else { return };
        if let Some(note) = playing.recorder.finished() {
            self.view.note(note);
        }
        if let Some(export) = playing.export.take_if(|export| export.is_finished()) {
            self.view.note(export.finish());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_made_on_a_still_keeps_the_coherence_of_clips() {
        let asked = Options { saturation: 1.5, ..Options::default() };
        assert_eq!(effective(&asked, true).coherence, 0.0);
        assert_eq!(effective(&asked, false), asked);
        let preset = polyreel::preset::to_toml(&asked).expect("plain data");
        assert!(preset.contains("saturation") && !preset.contains("coherence"), "{preset}");
    }
}
