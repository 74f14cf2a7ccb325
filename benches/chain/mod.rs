//! The chain on one thread, as [`polyreel::render::Renderer`] has it, with a look between its stages.

use polyreel::chain;
use polyreel::chain::StageProbe;
use polyreel::colour::Form;
use polyreel::frame::{Frame, Rational};
use polyreel::options::{Detail, Options};
use polyreel::sink::Picture;
use polyreel::stage::Stage;
use polyreel::stream::Span;

/// The stages that compute.
#[allow(dead_code, reason = "not every bench looks between the stages")]
pub(crate) const STAGES: [Stage; 5] =
    [Stage::Features, Stage::Sample, Stage::Triangulate, Stage::Refine, Stage::Rasterise];

/// Calls a function after each of [`STAGES`].
struct After<F>(F);

impl<F: FnMut(Stage)> StageProbe for After<F> {
    fn stage<T: Send>(&mut self, stage: Stage, work: impl FnOnce() -> T + Send) -> T {
        let done = work();
        (self.0)(stage);
        done
    }
}

/// The chain for a film that is written as video.
pub(crate) struct Chain(chain::Chain);

impl Chain {
    /// A chain whose pictures are painted as planes of this `form`.
    pub(crate) fn new(options: &Options, form: Option<Form>) -> Self {
        Self(chain::Chain::new(options).expect("sound options").with_form(form))
    }

    /// Takes back the buffers of a picture that was looked at, as the pipeline does.
    pub(crate) fn recycle(&mut self, picture: Picture) {
        self.0.recycle(picture.frame.into_buffers());
    }

    /// Renders `frame`, and calls `done` after each of [`STAGES`].
    pub(crate) fn render(&mut self, frame: &Frame, done: impl FnMut(Stage)) -> Picture {
        let (_, meshed, painting) =
            self.0.run(frame, &Detail::FULL, &mut After(done)).expect("renders");
        self.0.recycle_mesh(meshed.mesh);
        let span = Span { start: Rational::ZERO, length: None };
        Picture { frame: painting.frame, fills: painting.fills, span }
    }
}
