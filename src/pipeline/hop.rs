//! What travels between the stages: one type a hop, holding only what the stages after it need.
//!
//! A channel carries `Result<hop>`: an error takes the place of the frame on which it happened, so
//! that the first error in frame order is the one that arrives.

use crate::feature::Features;
use crate::frame::{Frame, Span};
use crate::mesh::Mesh;
use crate::sink::Picture;

use super::report::FrameReport;

/// What accompanies a frame all the way to the sink.
#[derive(Debug)]
pub(super) struct Ticket {
    /// When the frame is shown.
    pub(super) span: Span,
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
    /// Whether the mesh has nothing to do with that of the frame before.
    pub(super) fresh: bool,
}

/// rasterise -> encode.
#[derive(Debug)]
pub(super) struct Painted {
    pub(super) report: FrameReport,
    pub(super) picture: Picture,
}
