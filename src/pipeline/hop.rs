//! The messages between the stages: one type for each hop, with only the data that later stages need.
//!
//! A channel carries `Result<hop>`: an error replaces its frame, so that the first error in frame order arrives
//! first.

use std::sync::Arc;

use crate::feature::Features;
use crate::frame::Frame;
use crate::mesh::Mesh;
use crate::options::{Detail, Options};
use crate::rasterise::PaintHints;
use crate::sink::{Origin, Picture};
use crate::stream::Span;

use super::report::FrameReport;

/// The settings of a frame. Every stage uses the settings of the frame, not the current ones, so that all stages
/// change at the same frame.
#[derive(Clone, Debug)]
pub(super) struct FrameSettings {
    /// The options when the frame was admitted.
    pub(super) options: Arc<Options>,
    /// The detail of the frame.
    pub(super) detail: Detail,
}

impl FrameSettings {
    /// The options, if they differ from `last`, which is updated.
    pub(super) fn changed_options(&self, last: &mut Arc<Options>) -> Option<&Options> {
        if Arc::ptr_eq(last, &self.options) {
            return None;
        }
        last.clone_from(&self.options);
        Some(&self.options)
    }
}

/// The data that stays with a frame on its way to the sink.
#[derive(Debug)]
pub(super) struct FrameContext {
    /// The settings of the frame.
    pub(super) settings: FrameSettings,
    /// Number of refinement steps by the options; set by the mesh stage.
    pub(super) requested_steps: u32,
    /// When the frame is shown.
    pub(super) span: Span,
    /// Whether it is part of a [warm-up pass](crate::source::Decoded::is_warmup).
    pub(super) is_warmup: bool,
    /// Whether it has full detail whatever the budget.
    pub(super) is_full: bool,
    /// The results of the stages so far.
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
    /// The hints of the mesh stage for painting.
    pub(super) hints: PaintHints,
}

/// rasterise -> encode.
#[derive(Debug)]
pub(super) struct Painted {
    pub(super) is_warmup: bool,
    pub(super) report: FrameReport,
    pub(super) picture: Picture,
    /// Its source frame and mesh, if the sink [needs](crate::sink::Needs::origin) them.
    pub(super) origin: Option<Origin>,
}
