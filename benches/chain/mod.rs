//! The chain on one thread, as [`polyreel::render::Renderer`] has it, to be looked at between its stages.

use polyreel::colour::Form;
use polyreel::echo::Echo;
use polyreel::feature::Extractor;
use polyreel::frame::Frame;
use polyreel::options::{Detail, Options};
use polyreel::rasterise::{Brief, Painter};
use polyreel::render::{Mesher, triangulate_start};
use polyreel::sink::Picture;
use polyreel::stage::Stage;

/// The stages that compute.
#[allow(dead_code, reason = "not every bench looks between the stages")]
pub(crate) const STAGES: [Stage; 5] =
    [Stage::Features, Stage::Sample, Stage::Triangulate, Stage::Refine, Stage::Rasterise];

/// The stages' state.
pub(crate) struct Chain {
    extractor: Extractor,
    mesher: Mesher,
    painter: Painter,
    echo: Option<Echo>,
}

impl Chain {
    /// A chain whose pictures are painted as planes of this `form`.
    pub(crate) fn new(options: &Options, form: Option<Form>) -> Self {
        Self {
            extractor: Extractor::new(options),
            mesher: Mesher::new(options),
            painter: Painter::new(options).with_form(form),
            echo: None,
        }
    }

    /// Takes back a picture that was looked at, as the sinks of a video give it back.
    pub(crate) fn recycle(&mut self, picture: Picture) {
        self.painter.recycle(picture.frame.into_buffers());
    }

    /// Renders `frame`, and calls `done` after each of [`STAGES`]. Taking up the mesh for the next frame
    /// counts as refinement, letting go of what nobody needs any more as rasterising.
    pub(crate) fn render(&mut self, frame: &Frame, mut done: impl FnMut(Stage)) -> Picture {
        let detail = Detail::FULL;
        let features = self.extractor.extract(frame, detail.look);
        done(Stage::Features);
        let start = self.mesher.sample(&features, frame, &detail).expect("seeds");
        done(Stage::Sample);
        let (mut mesh, fresh) = triangulate_start(frame, start).expect("a mesh");
        done(Stage::Triangulate);
        let echo = self.echo.take();
        let refined = self.mesher.refine(&mut mesh, frame, fresh, &detail, echo).expect("refines");
        self.mesher.remember(&mesh, fresh, &refined);
        let call = self.mesher.call(&refined);
        done(Stage::Refine);
        let brief = Brief { fresh, known: refined.fills, call };
        let answer = |echo| self.echo = echo;
        let painting = self.painter.paint(&mesh, frame, detail.rows, brief, answer);
        drop(features);
        self.mesher.recycle(mesh);
        done(Stage::Rasterise);
        let span = polyreel::stream::Span { start: polyreel::frame::Rational::ZERO, length: None };
        Picture { frame: painting.frame, fills: painting.fills, span }
    }
}
