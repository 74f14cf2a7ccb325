//! What decides the detail of each frame.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::error::Result;
use crate::feature::Features;
use crate::governor::{Governor, MOST_STEPS};
use crate::options::{Detail, Steps};
use crate::render::Mesher;
use crate::stage::{Stage, Timing};

use super::hop::Ticket;
use super::replay::Script;
use super::report::FrameReport;

/// What decides how much detail frames have.
#[derive(Clone, Debug, Default)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub enum Guide {
    /// The options alone.
    #[default]
    Options,
    /// Each of the threads between decode and encode has this time for a frame; the detail is chosen
    /// so that it suffices, and spare time is spent on refinement.
    Budget(Duration),
    /// The details of a former run.
    Replay(Arc<Script>),
}

impl Guide {
    /// The time for a frame, where there is a budget.
    pub fn budget(&self) -> Option<Duration> {
        match self {
            Guide::Budget(time) => Some(*time),
            _ => None,
        }
    }
}

/// A [`Guide`] at work. Stages ask it before they take up a frame, and tell it their times.
#[derive(Debug)]
pub(super) enum Pilot {
    Options,
    Budget(Box<Mutex<Governor>>),
    Replay(Arc<Script>),
}

impl Pilot {
    pub(super) fn new(guide: &Guide) -> Self {
        match guide {
            Guide::Options => Self::Options,
            Guide::Budget(time) => Self::Budget(Box::new(Mutex::new(Governor::new(*time)))),
            Guide::Replay(script) => Self::Replay(script.clone()),
        }
    }

    /// Who decides the detail of a frame: in a `rehearsal` the options do. Its details are in no report,
    /// and a replay must have the same.
    pub(super) fn in_charge(&self, rehearsal: bool) -> &Self {
        if rehearsal { &Self::Options } else { self }
    }

    /// The detail that frame `index` comes in with. Under a budget each stage settles its own part.
    pub(super) fn detail(&self, index: u64) -> Result<Detail> {
        match self {
            Self::Replay(script) => script.detail(index),
            _ => Ok(Detail::FULL),
        }
    }

    /// The input has ended before frame `index`.
    pub(super) fn end(&self, index: u64) -> Result<()> {
        match self {
            Self::Replay(script) => script.end(index),
            _ => Ok(()),
        }
    }

    fn governor(&self) -> Option<MutexGuard<'_, Governor>> {
        match self {
            // The governor is plain numbers: whoever panicked while it was locked left it usable.
            Self::Budget(governor) => Some(governor.lock().unwrap_or_else(PoisonError::into_inner)),
            _ => None,
        }
    }

    /// Before level one.
    pub(super) fn before_features(&self, ticket: &mut Ticket) {
        if let Some(mut governor) = self.governor() {
            ticket.orders.detail.look = governor.look();
            ticket.report.changes.extend(governor.take_news());
        }
    }

    /// After level one.
    pub(super) fn after_features(&self, ticket: &Ticket, features: &Features) {
        if let Some(mut governor) = self.governor() {
            let time = ticket.report.timing.get(Stage::Features);
            governor.looked(ticket.orders.detail.look, features.change.begins(), time);
        }
    }

    /// Before level two.
    pub(super) fn before_mesh(&self, ticket: &mut Ticket, features: &Features, mesher: &Mesher) {
        let fresh = features.change.begins();
        ticket.asked = mesher.asked(fresh, features.candidates.size());
        if let Some(mut governor) = self.governor() {
            // Steps that the user counts are as many as are meant.
            let counted = ticket.orders.options.refine.is_some();
            let most = if counted { ticket.asked } else { MOST_STEPS.max(ticket.asked) };
            let (seeds, steps) = governor.mesh(ticket.asked, most, fresh);
            let detail = &mut ticket.orders.detail;
            (detail.seeds, detail.steps) = (seeds, Some(steps));
            ticket.report.changes.extend(governor.take_news());
        }
    }

    /// After level three; `fresh` says that the mesh was made anew.
    pub(super) fn after_mesh(&self, ticket: &Ticket, fresh: bool) {
        if let Some(mut governor) = self.governor() {
            let ordered = ticket.orders.detail.steps.unwrap_or_default();
            // Fewer are done where nothing is left to gain.
            let done = ordered.min(Steps::new(ticket.report.refine_steps));
            governor.meshed(fresh, done, mesh_time(&ticket.report.timing));
        }
    }

    /// Before the rasteriser.
    pub(super) fn before_painting(&self, ticket: &mut Ticket) {
        if let Some(mut governor) = self.governor() {
            ticket.orders.detail.rows = governor.rows();
            ticket.report.changes.extend(governor.take_news());
        }
        ticket.report.orders = ticket.orders.detail;
        ticket.report.detail = ticket.orders.detail.share(ticket.asked);
    }

    /// After the rasteriser.
    pub(super) fn after_painting(&self, report: &FrameReport) {
        if let Some(mut governor) = self.governor() {
            governor.painted(report.orders.rows, report.timing.get(Stage::Rasterise));
        }
    }
}

/// Time of the thread of the mesh.
fn mesh_time(timing: &Timing) -> Duration {
    [Stage::Sample, Stage::Triangulate, Stage::Refine].map(|stage| timing.get(stage)).iter().sum()
}

/// The longest time that one of the governed threads was at work on a frame. Decode and encode are
/// none of them: they wait for other programs, and no detail changes what they have to do.
pub(super) fn longest(timing: &Timing) -> Duration {
    let alone = timing.get(Stage::Features).max(timing.get(Stage::Rasterise));
    alone.max(mesh_time(timing))
}
