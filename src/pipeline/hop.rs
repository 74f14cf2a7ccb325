//! What travels between the stages: one type a hop, holding only what the stages after it need.
//!
//! A channel carries `Result<hop>`: an error takes the place of the frame on which it happened, so
//! that the first error in frame order is the one that arrives.

use std::sync::Arc;

use crate::feature::Features;
use crate::frame::Frame;
use crate::mesh::Mesh;
use crate::options::{Detail, Options};
use crate::rasterise::Brief;
use crate::sink::{Origin, Picture};
use crate::stream::Span;

use super::report::FrameReport;

/// How a frame is to be rendered. Every stage works by the orders of its frame, not by what holds when
/// the frame gets there: so all stages change at the same frame.
#[derive(Clone, Debug)]
pub(super) struct Orders {
    /// What was asked for when the frame was let in.
    pub(super) options: Arc<Options>,
    /// What it may cost.
    pub(super) detail: Detail,
}

impl Orders {
    /// The options, if they are others than `last`, which they become.
    pub(super) fn news(&self, last: &mut Arc<Options>) -> Option<&Options> {
        if Arc::ptr_eq(last, &self.options) {
            return None;
        }
        last.clone_from(&self.options);
        Some(&self.options)
    }
}

/// What accompanies a frame all the way to the sink.
#[derive(Debug)]
pub(super) struct Ticket {
    /// How it is to be rendered.
    pub(super) orders: Orders,
    /// Refinement steps that the options ask for, once the mesh's thread has seen it.
    pub(super) asked: u32,
    /// When the frame is shown.
    pub(super) span: Span,
    /// Whether it is only there for the frames after it to learn from.
    pub(super) rehearsal: bool,
    /// What the stages so far have to say of it.
    pub(super) report: FrameReport,
}

/// decode -> features.
#[derive(Debug)]
pub(super) struct Admitted {
    pub(super) ticket: Ticket,
    pub(super) frame: Frame,
}

/// features -> mesh.
#[derive(Debug)]
pub(super) struct Featured {
    pub(super) ticket: Ticket,
    pub(super) frame: Frame,
    pub(super) features: Features,
}

/// mesh -> rasterise.
#[derive(Debug)]
pub(super) struct Meshed {
    pub(super) ticket: Ticket,
    pub(super) frame: Frame,
    pub(super) mesh: Mesh,
    /// What is known of it, and wanted.
    pub(super) brief: Brief,
}

/// rasterise -> encode.
#[derive(Debug)]
pub(super) struct Painted {
    pub(super) rehearsal: bool,
    pub(super) report: FrameReport,
    pub(super) picture: Picture,
    /// Where the sink looks at it.
    pub(super) origin: Option<Origin>,
}
