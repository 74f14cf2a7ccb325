//! The window of a preview: handles keys and shows pictures, until it is closed.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use polyreel::error::{Error, Result};
use polyreel::options::{Colour, Options};
use polyreel::pipeline::{Controls, Stop};
use polyreel::sample::Sampler;
use polyreel::sink::{self, Picture, SinkOptions};
use polyreel::stream::{Loops, StreamInfo};

use crate::program::record;

use super::canvas::{Area, Canvas};
use super::change::changed;
use super::keys::{Action, Look, Way, action};
use super::mailbox::{Mailbox, Shown};
use super::name::{free, moment};
use super::playback::Deck;
use super::recorder::Recorder;
use super::scene::{Scene, draw, slid};
use super::status::{Status, words};
use super::window::{Press, Window};

/// The longest wait for a picture before keys are read again.
const TICK: Duration = Duration::from_millis(8);

/// Interval of redraws when nothing happens: the window may have been covered.
const REDRAW: Duration = Duration::from_millis(500);

/// Time for which a note is in the status line.
const NOTE: Duration = Duration::from_secs(4);

/// Time over which the rate is averaged.
const RATE: Duration = Duration::from_secs(2);

/// A jump in seconds, and as a share of a stream that is shorter than ten of them.
const JUMP: f64 = 5.0;
const SHARE: f64 = 0.1;

/// The playback controls of a run that is only a preview.
pub(super) struct Playing {
    pub(super) deck: Arc<Deck>,
    pub(super) recorder: Arc<Recorder>,
    /// Whether it is a file that can be seeked.
    pub(super) seekable: bool,
}

/// A window and its content.
pub(super) struct Session {
    pub(super) window: Window,
    pub(super) mailbox: Arc<Mailbox>,
    /// `None` in the window of a render, which cannot be controlled.
    pub(super) playing: Option<Playing>,
    /// The options that the user chose, by keys too. A preset is written from them.
    pub(super) asked: Options,
    /// The options of the run: the [effective] ones.
    pub(super) controls: Controls,
    pub(super) info: StreamInfo,
    /// The base name of files.
    pub(super) stem: String,
    pub(super) budget: Option<Duration>,
    pub(super) view: View,
}

/// How the window looks.
#[derive(Debug)]
pub(super) struct View {
    shown: Option<Arc<Shown>>,
    canvas: Canvas,
    picture: Area,
    help: bool,
    overlay: bool,
    split: bool,
    slider: f64,
    outline: Colour,
    note: Option<(String, Instant)>,
    drawn: VecDeque<Instant>,
    last: Instant,
    /// The frame with the figures in the status line.
    reported: Option<u64>,
    stale: bool,
}

impl View {
    /// An empty view; `outline` is the colour of a new outline.
    pub(super) fn new(outline: Option<Colour>) -> Self {
        Self {
            shown: None,
            canvas: Canvas::new(1, 1),
            picture: Area::default(),
            help: false,
            overlay: false,
            split: false,
            slider: 0.5,
            outline: outline.unwrap_or(Colour([0, 0, 0, 255])),
            note: None,
            drawn: VecDeque::new(),
            last: Instant::now(),
            reported: None,
            stale: true,
        }
    }

    fn note(&mut self, text: String) {
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
            self.drag();
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
        let words = words(&status);
        self.view.reported = status.report.map(|report| report.index);
        let view = &mut self.view;
        let options = self.controls.options();
        let size = view.shown.as_ref().map(|shown| shown.frame.size());
        let scene = Scene {
            shown: view.shown.as_deref(),
            words: &words,
            split: view.split.then_some(view.slider),
            grid: size.filter(|_| view.overlay).map(|size| Sampler::new(&options).grid(size)),
            help: view.help,
        };
        view.picture = draw(&mut view.canvas, &scene);
        view.last = now;
        view.stale = false;
        self.window.show(&view.canvas)
    }

    fn status(&self) -> Status {
        let report = self.mailbox.noted();
        let going = self.playing.as_ref().map(|playing| playing.deck.going()).unwrap_or_default();
        let decode = if self.playing.is_some() {
            going.decode
        } else {
            report.as_ref().map_or(Duration::ZERO, |r| r.timing.get(polyreel::stage::Stage::Decode))
        };
        Status {
            method: self.controls.options().method,
            rate: self.view.rate(),
            budget: self.budget,
            report,
            decode,
            dropped: going.dropped,
            missed: self.playing.as_ref().map_or(0, |_| self.mailbox.missed()),
            position: self.position(),
            length: self.info.duration.map(|length| length.to_f64()),
            paused: going.paused,
            recording: self.playing.as_ref().is_some_and(|playing| playing.recorder.is_on()),
            note: self.view.note.as_ref().map(|(text, _)| text.clone()),
        }
    }

    fn position(&self) -> f64 {
        self.view.shown.as_ref().map_or(0.0, |shown| shown.span.start.to_f64())
    }

    /// The slider follows the mouse while its button is down.
    fn drag(&mut self) {
        let Some(x) = self.window.held().filter(|_| self.view.split) else { return };
        let slider = slid(x, self.view.picture);
        self.view.stale |= slider != self.view.slider;
        self.view.slider = slider;
    }

    /// Removes old notes, and reports completed recordings.
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
        if let Some(note) = self.playing.as_ref().and_then(|playing| playing.recorder.finished()) {
            self.view.note(note);
        }
    }

    /// Performs an action; breaks to quit.
    fn press(&mut self, press: Press) -> std::ops::ControlFlow<()> {
        let Some(action) = action(press.stroke) else { return std::ops::ControlFlow::Continue(()) };
        if press.again && !action.repeats() {
            return std::ops::ControlFlow::Continue(());
        }
        self.view.stale = true;
        if action == Action::Quit {
            return std::ops::ControlFlow::Break(());
        }
        if let Err(error) = self.act(action) {
            self.view.note(error.to_string());
        }
        std::ops::ControlFlow::Continue(())
    }

    fn act(&mut self, action: Action) -> Result<()> {
        if self.playing.is_none() && !action.only_looks() {
            return Err(Error::usage(
                "this render is as it was asked for; 'polyreel preview' plays",
            ));
        }
        match action {
            Action::Help => self.view.help = !self.view.help,
            Action::Split => self.view.split = !self.view.split,
            Action::Overlay => self.view.overlay = !self.view.overlay,
            Action::Save => {
                let note = self.save()?;
                self.view.note(note);
            }
            Action::Quit => {}
            Action::Pause | Action::Step | Action::Seek(_) | Action::Record => self.play(action)?,
            Action::Look(look) => self.change(look)?,
            Action::WritePreset => {
                let note = self.write_preset()?;
                self.view.note(note);
            }
        }
        Ok(())
    }

    fn play(&mut self, action: Action) -> Result<()> {
        let Some(playing) = &self.playing else { return Ok(()) };
        match action {
            Action::Pause => playing.deck.pause(),
            Action::Step => playing.deck.step(),
            Action::Seek(way) => {
                if !playing.seekable {
                    return Err(Error::usage("one cannot jump in this input"));
                }
                let Some(shown) = self.mailbox.newest() else { return Ok(()) };
                let length = self.info.duration;
                let jump = length.map_or(JUMP, |length| JUMP.min(length.to_f64() * SHARE));
                let jump = if way == Way::Up { jump } else { -jump };
                playing.deck.seek(shown.span, jump, length);
            }
            _ => {
                let note = playing.recorder.toggle();
                self.view.note(note);
            }
        }
        Ok(())
    }

    fn change(&mut self, look: Look) -> Result<()> {
        let Some(playing) = &self.playing else { return Ok(()) };
        let (asked, note) = changed(&self.asked, look, self.info.size, self.view.outline);
        self.controls.set(effective(&asked, self.info.still))?;
        self.asked = asked;
        // If no frame will come by itself, the one on the screen is rendered again.
        playing.deck.again(!playing.seekable && !self.info.live);
        self.view.note(note);
        Ok(())
    }

    /// Writes the picture to a file of its own.
    fn save(&self) -> Result<String> {
        let Some(shown) = &self.view.shown else {
            return Err(Error::usage("there is no picture yet"));
        };
        let time =
            if self.info.still { String::new() } else { format!("-{}", moment(self.position())) };
        let name = free(&format!("{}-lowpoly{time}", self.stem), "png");
        let info =
            StreamInfo { still: true, frames: Some(1), loops: Loops::Once, ..self.info.clone() };
        let mut sink = sink::create(&name, &info, &SinkOptions::default())?;
        let (frame, span) = (shown.frame.clone(), shown.span);
        sink.write(Picture { frame, fills: Vec::new(), span }, None)?;
        sink.finish()?;
        Ok(format!("saved {name}"))
    }

    /// Writes the current options to a preset file.
    fn write_preset(&self) -> Result<String> {
        let name = free(&format!("{}-preset", self.stem), "toml");
        let toml = polyreel::preset::to_toml(&self.asked)?;
        record::put(Path::new(&name), toml.as_bytes(), false)?;
        Ok(format!("wrote {name}: use it with --preset {name}"))
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
