//! The paper's tables on any pictures: methods, studies or presets side by side.
//!
//! Without refinement, as in the paper, and with it. Sizes, rates, errors and times of stills ([`still`]) and of
//! clips ([`clip`]); Tables 2, 3 and 4, the robustness figure and the clips' table as plain [`Table`]s ([`tables`]).

pub(crate) mod clip;
pub(crate) mod disturb;
pub(crate) mod plan;
pub(crate) mod still;
pub(crate) mod summary;
pub(crate) mod table;
pub(crate) mod tables;
pub(crate) mod thumbnail;

use std::path::PathBuf;

use clip::ClipScores;
pub(crate) use plan::{Kind, Plan, Variant};
pub(crate) use polyreel::metric::over_white;
use still::StillScores;
pub(crate) use table::Table;

/// An input that could not be evaluated.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct Failure {
    /// The input as it was named.
    pub(crate) path: PathBuf,
    /// What was wrong with it.
    pub(crate) error: String,
}

/// All that was found.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct Evaluation {
    /// What was asked for.
    pub(crate) plan: Plan,
    /// The stills, in the order of the inputs.
    pub(crate) stills: Vec<StillScores>,
    /// The clips, in the order of the inputs.
    pub(crate) clips: Vec<ClipScores>,
    /// The inputs that could not be evaluated.
    pub(crate) failures: Vec<Failure>,
}
