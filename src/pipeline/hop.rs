//! What travels between the stages: one type a hop, holding only what the stages after it need.
//!
//! A channel carries `Result<hop>`: an error takes the place of the frame on which it happened, so
//! that the first error in frame order is the one that arrives.

use std::sync::Arc;

use crate::feature::Features;
use crate::frame::Frame;
use crate::mesh::Mesh;
use crate::options::{Detail, Options};
use crate::rasterise::PaintHints;
use crate::sink::{Origin, Picture};
use crate::stream::Span;

use super::report::FrameReport;

/// How a frame is rendered. Every stage works by the settings of its frame, not by those that hold when the
/// frame gets there: so all stages change at the same frame.
#[derive(Clone, Debug)]
pub(super) struct FrameSettings {
    /// The options when the frame was admitted.
    pub(super) options: Arc<Options>,
    /// What the frame may cost.
    pub(super) detail: Detail,
}

impl FrameSettings {
    /// The options, if they are not `last`, which they become.
    pub(super) fn changed_options(&self, last: &mut Arc<Options>) -> Option<&Options> {
        if Arc::ptr_eq(last, &self.options) {
            return None;
        }
        last.clone_from(&self.options);
        Some(&self.options)
    }
}

/// What accompanies a frame all the way to the sink.
#[derive(Debug)]
pub(super) struct FrameContext {
    /// How it is rendered.
    pub(super) settings: FrameSettings,
    /// Refinement steps that the options ask for; known once the mesh stage has seen the frame.
    pub(super) requested_steps: u32,
    /// When the frame is shown.
    pub(super) span: Span,
    /// Whether it is part of a [warm-up pass](crate::source::Decoded::is_warmup).
    pub(super) is_warmup: bool,
    /// What the stages so far have found and done.
    pub(super) report: FrameReport,
}

/// decode -> features.
#[derive(Debug)]
pub(super) struct Admitted {
    pub(super) context: FrameContext,
    pub(super) frame: Frame,
}

/// features -> mesh.
#[derive(Debug)]
pub(super) struct Featured {
    pub(super) context: FrameContext,
    pub(super) frame: Frame,
    pub(super) features: Features,
}

/// mesh -> rasterise.
#[derive(Debug)]
pub(super) struct Meshed {
    pub(super) context: FrameContext,
    pub(super) frame: Frame,
    pub(super) mesh: Mesh,
    /// What is known of the mesh, and wanted.
    pub(super) hints: PaintHints,
}

/// rasterise -> encode.
#[derive(Debug)]
pub(super) struct Painted {
    pub(super) is_warmup: bool,
    pub(super) report: FrameReport,
    pub(super) picture: Picture,
    /// What it was made from, where the sink [needs](crate::sink::Needs::origin) it.
    pub(super) origin: Option<Origin>,
}
