//! What keys and the mouse do.

use std::ops::ControlFlow;
use std::path::Path;

use polyreel::error::{Error, Result};
use polyreel::options::Options;
use polyreel::sink::{self, Picture, SinkOptions};
use polyreel::stream::{Loops, StreamInfo};

use crate::program::record;

use super::change::changed;
use super::export::Export;
use super::keys::{Action, ESCAPE, Look, Recall, Stroke, Way, action};
use super::name::{free, moment};
use super::scene::slid;
use super::session::{Grip, Session, effective};
use super::window::Press;

/// A jump in seconds, and as a share of a stream that is shorter than ten of them.
const JUMP: f64 = 5.0;
const SHARE: f64 = 0.1;

impl Session {
    /// Performs the action of a key; breaks to quit.
    pub(super) fn press(&mut self, press: Press) -> ControlFlow<()> {
        let Some(action) = action(press.stroke) else { return ControlFlow::Continue(()) };
        if press.again && !action.repeats() {
            return ControlFlow::Continue(());
        }
        self.view.stale = true;
        // As in other windows, Esc ends the full screen first.
        let ends_full_screen = press.stroke == Stroke::Char(ESCAPE) && self.window.is_full_screen();
        let action = if ends_full_screen { Action::FullScreen } else { action };
        if action == Action::Quit {
            return ControlFlow::Break(());
        }
        if let Err(error) = self.act(action) {
            self.view.note(error.to_string());
        }
        ControlFlow::Continue(())
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
            Action::Figures => self.view.figures = !self.view.figures,
            Action::Bar => self.view.is_bar_hidden = !self.view.is_bar_hidden,
            Action::Fit => self.view.lens = Default::default(),
            Action::FullScreen => self.window.toggle_full_screen()?,
            Action::Quit => {}
            Action::Pause | Action::Step | Action::Seek(_) | Action::Record => self.play(action)?,
            Action::Export => self.export()?,
            Action::Look(look) => self.change(look)?,
            Action::Preset(way) => {
                let chosen = self.history.step_preset(way).clone();
                self.view.note(chosen.name().unwrap_or_default());
                self.apply(&chosen.options)?;
            }
            Action::Recall(recall) => self.recall(recall)?,
            Action::Save => {
                let note = self.save()?;
                self.view.note(note);
            }
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
            Action::Pause => {
                let paused = playing.deck.pause();
                self.controls.set_full_detail(paused);
                // What the budget has reduced is drawn anew.
                let reduced = self.mailbox.noted().is_some_and(|report| report.detail < 1.0);
                if paused && reduced {
                    playing.deck.again(true);
                }
            }
            Action::Step => {
                self.controls.set_full_detail(true);
                playing.deck.step();
            }
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
        let asked = &self.history.now().options;
        let (options, note) = changed(asked, look, self.info.size, self.view.outline);
        self.apply(&options)?;
        self.history.change(options);
        self.view.note(note);
        Ok(())
    }

    fn recall(&mut self, recall: Recall) -> Result<()> {
        let Some(chosen) = self.history.recall(recall).cloned() else {
            return Err(Error::usage(match recall {
                Recall::Undo | Recall::Reset => "this is the first look",
                Recall::Compare => "there is no other look yet",
            }));
        };
        let name = chosen.name().unwrap_or_else(|| "my look".to_owned());
        self.view.note(match recall {
            Recall::Undo => format!("undone: {name}"),
            Recall::Compare => format!("compare: {name}"),
            Recall::Reset => format!("the first look: {name}"),
        });
        self.apply(&chosen.options)
    }

    /// Renders with `options` from now on.
    fn apply(&mut self, options: &Options) -> Result<()> {
        let Some(playing) = &self.playing else { return Ok(()) };
        self.controls.set(effective(options, self.info.still))?;
        // If no frame will come by itself, the one on the screen is rendered again.
        playing.deck.again(!playing.seekable && !self.info.live);
        Ok(())
    }

    /// Begins an export, or ends the one under way.
    fn export(&mut self) -> Result<()> {
        let Some(playing) = &mut self.playing else { return Ok(()) };
        if let Some(export) = &playing.export {
            export.stop();
            let note = format!("{} ends here", export.name());
            self.view.note(note);
            return Ok(());
        }
        let options = &self.history.now().options;
        let export =
            Export::begin(&playing.input, &self.info, options, &self.stem, &playing.interrupt)?;
        let note = format!("exporting to {}; x ends it", export.name());
        playing.export = Some(export);
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
        let toml = polyreel::preset::to_toml(&self.history.now().options)?;
        record::put(Path::new(&name), toml.as_bytes(), false)?;
        Ok(format!("wrote {name}: use it with --preset {name}"))
    }

    /// The wheel zooms; the button holds the slider, the timeline or the magnified picture.
    pub(super) fn follow_mouse(&mut self) {
        let Some(mouse) = self.window.mouse() else { return };
        let size = self.view.shown.as_ref().map(|shown| shown.frame.size());
        if let Some(size) = size.filter(|_| mouse.notches != 0.0) {
            self.view.lens.turn(mouse.notches, mouse.at, size, self.view.places.room);
            self.view.stale = true;
        }
        if !mouse.is_down {
            (self.view.grip, self.view.sought) = (None, None);
            return;
        }
        let grip = self.view.grip.unwrap_or_else(|| self.gripped(mouse.at));
        self.view.grip = Some(grip);
        match grip {
            Grip::Nothing => {}
            Grip::Slider => {
                let slider = slid(mouse.at.0, self.view.places.picture);
                self.view.stale |= slider != self.view.slider;
                self.view.slider = slider;
            }
            Grip::Timeline => self.jump_to(mouse.at.0),
            Grip::Picture(last) => {
                let by = (mouse.at.0 - last.0, mouse.at.1 - last.1);
                if let Some(size) = size.filter(|_| by != (0.0, 0.0)) {
                    self.view.lens.drag(by, size, self.view.places.room);
                    self.view.stale = true;
                }
                self.view.grip = Some(Grip::Picture(mouse.at));
            }
        }
    }

    /// What a press of the mouse at `at` takes hold of.
    fn gripped(&self, at: (f64, f64)) -> Grip {
        let places = self.view.places;
        if places.timeline.is_some_and(|timeline| timeline.contains(at)) {
            return Grip::Timeline;
        }
        if !places.room.contains(at) {
            return Grip::Nothing;
        }
        if self.view.split && !self.view.lens.is_zoomed() {
            return Grip::Slider;
        }
        let slider = places.picture.x as f64 + self.view.slider * places.picture.width as f64;
        let is_near = (at.0 - slider).abs() < 12.0;
        if self.view.split && is_near { Grip::Slider } else { Grip::Picture(at) }
    }

    /// Jumps to the time at column `x` of the timeline.
    fn jump_to(&mut self, x: f64) {
        let (Some(playing), Some(timeline)) = (&self.playing, self.view.places.timeline) else {
            return;
        };
        let (Some(length), Some(shown)) = (self.info.duration, self.mailbox.newest()) else {
            return;
        };
        if !playing.seekable {
            return;
        }
        let seconds = slid(x, timeline) * length.to_f64();
        if self.view.sought != Some(seconds) {
            self.view.sought = Some(seconds);
            playing.deck.seek_to(shown.span, seconds, Some(length));
        }
    }
}
