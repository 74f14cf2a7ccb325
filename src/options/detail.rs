//! What a frame may cost: the part of its quality that a time budget decides.

use serde::{Deserialize, Serialize};

/// What a frame may cost. It is chosen before the frame and decides, beside the options, its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Detail {
    /// Steps of refinement in place of those that the options ask for; `None` leaves it to them.
    pub steps: Option<u32>,
}

impl Detail {
    /// Just what the options ask for.
    pub const FULL: Self = Self { steps: None };
}

impl Default for Detail {
    fn default() -> Self {
        Self::FULL
    }
}
