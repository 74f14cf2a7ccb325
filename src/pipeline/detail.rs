//! Chooses the detail of each frame.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::chain::MeshStage;
use crate::error::Result;
use crate::feature::Features;
use crate::governor::{Governor, MOST_STEPS};
use crate::options::{Detail, Steps};
use crate::stage::{Stage, Timing};

use super::hop::FrameContext;
use super::replay::Script;
use super::report::FrameReport;

/// How the detail of frames is chosen.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum DetailPolicy {
    /// All frames have full detail.
    #[default]
    Options,
    /// A time budget for a frame on each of the threads between decode and encode. Detail is chosen to fit, and spare
    /// time is spent on refinement.
    Budget(Duration),
    /// As in an earlier run.
    Replay(Arc<Script>),
}

impl DetailPolicy {
    /// The time for a frame, where there is a budget.
    pub fn budget(&self) -> Option<Duration> {
        match self {
            DetailPolicy::Budget(time) => Some(*time),
            _ => None,
        }
    }
}

/// The state of a [`DetailPolicy`]. Stages ask it for the detail before they begin a frame, and report their times
/// afterwards.
#[derive(Debug)]
pub(super) enum DetailController {
    Options,
    Budget(Box<Mutex<Governor>>),
    Replay(Arc<Script>),
}

impl DetailController {
    pub(super) fn new(policy: &DetailPolicy) -> Self {
        match policy {
            DetailPolicy::Options => Self::Options,
            DetailPolicy::Budget(time) => Self::Budget(Box::new(Mutex::new(Governor::new(*time)))),
            DetailPolicy::Replay(script) => Self::Replay(script.clone()),
        }
    }

    /// The controller of a frame, which may have full detail whatever the budget: a frame of a warm-up pass has, as
    /// its detail is in no report, and a replay must use the same.
    pub(super) fn for_frame(&self, is_full: bool) -> &Self {
        if is_full { &Self::Options } else { self }
    }

    /// The detail of frame `index` when it is admitted. Under a budget each stage changes its own part later.
    ///
    /// # Errors
    /// When a replay has no such frame.
    pub(super) fn initial_detail(&self, index: u64) -> Result<Detail> {
        match self {
            Self::Replay(script) => script.detail(index),
            _ => Ok(Detail::FULL),
        }
    }

    /// Checks that the input may end before frame `index`.
    ///
    /// # Errors
    /// When a replay has more frames.
    pub(super) fn check_end(&self, index: u64) -> Result<()> {
        match self {
            Self::Replay(script) => script.check_end(index),
            _ => Ok(()),
        }
    }

    fn governor(&self) -> Option<MutexGuard<'_, Governor>> {
        match self {
            // The governor is plain numbers: a panic while it was locked left it usable.
            Self::Budget(governor) => Some(governor.lock().unwrap_or_else(PoisonError::into_inner)),
            _ => None,
        }
    }

    /// Chooses how closely level one looks at the frame.
    pub(super) fn before_features(&self, context: &mut FrameContext) {
        if let Some(mut governor) = self.governor() {
            context.settings.detail.look = governor.look();
            context.report.changes.extend(governor.take_changes());
        }
    }

    /// Reports the time of level one.
    pub(super) fn after_features(&self, context: &FrameContext, features: &Features) {
        if let Some(mut governor) = self.governor() {
            let time = context.report.timing.get(Stage::Features);
            governor.looked(context.settings.detail.look, features.change.is_fresh(), time);
        }
    }

    /// Chooses the number of seeds and of steps.
    pub(super) fn before_mesh(
        &self,
        context: &mut FrameContext,
        features: &Features,
        stage: &MeshStage,
    ) {
        let is_fresh = features.change.is_fresh();
        context.requested_steps = stage.requested_steps(is_fresh, features.candidates.size());
        if let Some(mut governor) = self.governor() {
            // A number of steps that the user gave is not exceeded.
            let counted = context.settings.options.refine.is_some();
            let most = if counted {
                context.requested_steps
            } else {
                MOST_STEPS.max(context.requested_steps)
            };
            let (seeds, steps) = governor.mesh(context.requested_steps, most, is_fresh);
            let detail = &mut context.settings.detail;
            (detail.seeds, detail.steps) = (seeds, Some(steps));
            context.report.changes.extend(governor.take_changes());
        }
    }

    /// Reports the time of the mesh stage; `is_fresh` says that the mesh was not carried.
    pub(super) fn after_mesh(&self, context: &FrameContext, is_fresh: bool) {
        if let Some(mut governor) = self.governor() {
            let chosen = context.settings.detail.steps.unwrap_or_default();
            // Fewer steps are done if nothing is left to gain.
            let done = chosen.min(Steps::new(context.report.refine_steps));
            governor.meshed(is_fresh, done, mesh_time(&context.report.timing));
        }
    }

    /// Chooses the rows that colours are taken from, and writes the detail, now complete, to the report.
    pub(super) fn before_painting(&self, context: &mut FrameContext) {
        if let Some(mut governor) = self.governor() {
            context.settings.detail.rows = governor.rows();
            context.report.changes.extend(governor.take_changes());
        }
        context.report.orders = context.settings.detail;
        context.report.detail = context.settings.detail.share(context.requested_steps);
    }

    /// Reports the time of the rasteriser.
    pub(super) fn after_painting(&self, report: &FrameReport) {
        if let Some(mut governor) = self.governor() {
            governor.painted(report.orders.rows, report.timing.get(Stage::Rasterise));
        }
    }
}

/// Time of the mesh thread.
fn mesh_time(timing: &Timing) -> Duration {
    [Stage::Sample, Stage::Triangulate, Stage::Refine].map(|stage| timing.get(stage)).iter().sum()
}

/// The longest time of a governed thread for a frame. Decode and encode are not governed: they wait for other
/// programs, and detail does not change their work.
pub(super) fn longest(timing: &Timing) -> Duration {
    let alone = timing.get(Stage::Features).max(timing.get(Stage::Rasterise));
    alone.max(mesh_time(timing))
}
