//! Exports the whole input with the current look: a render as by `polyreel render`, in the background.

use std::ffi::OsString;
use std::io::Write as _;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{self, JoinHandle};

use clap::Parser as _;
use polyreel::error::{Error, Result};
use polyreel::options::Options;
use polyreel::pipeline::{FrameReport, OutputReport, Stop, Summary};
use polyreel::stream::StreamInfo;

use super::name::free;
use crate::program::cli::{Cli, Command, InputArgs, RenderArgs};
use crate::program::embed::Watcher;
use crate::program::interrupt::Interrupt;
use crate::program::render::render_for;
use crate::program::terminal;

/// An export under way.
#[derive(Debug)]
pub(super) struct Export {
    name: String,
    frames: Option<u64>,
    done: Arc<AtomicU64>,
    stop: Stop,
    interrupt: Interrupt,
    /// `None` once its end was waited for.
    thread: Option<JoinHandle<Result<String>>>,
}

impl Export {
    /// Begins to render `input`, a stream of `info`, to a file called after `stem`.
    ///
    /// # Errors
    /// When the input cannot be read again, or the look cannot be written down.
    pub(super) fn begin(
        input: &InputArgs,
        info: &StreamInfo,
        options: &Options,
        stem: &str,
        interrupt: &Interrupt,
    ) -> Result<Self> {
        if info.live || input.inputs.iter().any(|name| name == "-") {
            return Err(Error::usage("this input cannot be read again: record it with r"));
        }
        let name = free(&format!("{stem}-lowpoly"), extension(info));
        // The look, as a preset: it is read when the render begins.
        let mut preset = tempfile::Builder::new()
            .prefix(".polyreel-")
            .suffix(".toml")
            .tempfile()
            .map_err(|error| Error::output(&name, error.to_string()))?;
        preset
            .write_all(polyreel::preset::to_toml(options)?.as_bytes())
            .map_err(|error| Error::output(&name, error.to_string()))?;
        let line = ["polyreel", "render", "-o", &name, "--preset"].map(OsString::from);
        let line = line.into_iter().chain([preset.path().into(), "input".into()]);
        let args = RenderArgs { input: input.clone(), ..parsed(line)? };
        let (done, stop) = (Arc::new(AtomicU64::new(0)), Stop::default());
        let mut watcher = Counting { done: done.clone(), summary: None };
        let (asked, called) = (stop.clone(), name.clone());
        let interrupt = interrupt.clone();
        let listened = interrupt.clone();
        let render = move || {
            let ended = render_for(&args, &asked, &interrupt, &mut watcher);
            drop(preset);
            let frames = watcher.summary.unwrap_or(0);
            let pictures =
                if frames == 1 { "1 picture".to_owned() } else { format!("{frames} pictures") };
            ended.map(|()| format!("{called}: {pictures}"))
        };
        let thread = thread::Builder::new()
            .name("export".to_owned())
            .spawn(render)
            .map_err(|error| Error::output(&name, error.to_string()))?;
        Ok(Self {
            name,
            frames: info.frames,
            done,
            stop,
            interrupt: listened,
            thread: Some(thread),
        })
    }

    /// The share that is done, 0 to 1; 0 where the number of frames is unknown.
    pub(super) fn share(&self) -> f64 {
        let done = self.done.load(Ordering::Relaxed) as f64;
        self.frames.map_or(0.0, |frames| (done / frames.max(1) as f64).min(1.0))
    }

    /// The name of the output.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Asks it to end with what it has.
    pub(super) fn stop(&self) {
        self.stop.request();
    }

    /// Whether it has ended.
    pub(super) fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits for its end. Returns a note for the user.
    pub(super) fn finish(mut self) -> String {
        self.join().unwrap_or_default()
    }

    fn join(&mut self) -> Option<String> {
        Some(match self.thread.take()?.join() {
            Ok(Ok(note)) => note,
            Ok(Err(error)) => error.to_string(),
            Err(_) => format!("{} could not be rendered", self.name),
        })
    }
}

impl Drop for Export {
    /// The window is closed: the export goes on to its end, unless Ctrl-C was pressed.
    fn drop(&mut self) {
        if self.interrupt.happened() {
            self.stop.request();
        } else if !self.is_finished() {
            terminal::say(format_args!(
                "{}: rendering to its end; Ctrl-C twice breaks it off",
                self.name
            ));
        }
        self.join().iter().for_each(terminal::say);
    }
}

/// The extension of an output for a stream of `info`: a picture for a picture, a GIF for an animation, and a video
/// for a video.
fn extension(info: &StreamInfo) -> &'static str {
    match info.format.as_str() {
        _ if info.still => "png",
        "gif" | "apng" | "webp" => "gif",
        _ => "mp4",
    }
}

/// The arguments of `render` on a command line.
fn parsed(line: impl IntoIterator<Item = OsString>) -> Result<RenderArgs> {
    match Cli::try_parse_from(line).map(|cli| cli.command) {
        Ok(Command::Render(args)) => Ok(*args),
        Ok(_) => Err(Error::usage("no render")),
        Err(error) => Err(Error::usage(error.to_string())),
    }
}

/// Counts the frames that are done.
struct Counting {
    done: Arc<AtomicU64>,
    summary: Option<u64>,
}

impl Watcher for Counting {
    fn begins(&mut self, _: &StreamInfo) {}

    fn frame_done(&mut self, _: &FrameReport) -> ControlFlow<()> {
        self.done.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Continue(())
    }

    fn warns(&mut self, _: &str) {}

    fn ended(&mut self, _: &StreamInfo, _: &OutputReport, summary: &Summary) {
        self.summary = Some(summary.frames);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel::geom::Size;

    #[test]
    fn outputs_are_of_the_kind_of_their_inputs() {
        let info = |format: &str, still| StreamInfo {
            format: format.to_owned(),
            still,
            ..StreamInfo::of(Size::new(4, 4))
        };
        assert_eq!(extension(&info("gif", true)), "png");
        assert_eq!(extension(&info("gif", false)), "gif");
        assert_eq!(extension(&info("h264 in mov", false)), "mp4");
    }

    #[test]
    fn the_command_line_of_an_export_is_one_of_render() {
        let line = ["polyreel", "render", "-o", "a.png", "--preset", "bold", "input"];
        parsed(line.map(OsString::from)).expect("a render");
    }
}
