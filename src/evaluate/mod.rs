//! The paper's tables on any pictures: every method at the same number of seeds.
//!
//! Sizes, rates, errors and times of stills ([`still`]) and of clips ([`clip`]); Tables 2, 3 and 4, the
//! robustness figure and the clips' as plain [`Table`]s ([`tables`]).

pub mod clip;
pub mod disturb;
pub mod packed;
mod range_coder;
pub mod still;
pub mod table;
pub mod tables;
pub mod thumbnail;

use std::path::PathBuf;

pub use crate::metric::over_white;
use crate::options::{Method, Options};
use clip::ClipScores;
use still::StillScores;
pub use table::Table;

/// What is evaluated.
#[derive(Clone, Debug, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Plan {
    /// How every method renders; its own `method` is not looked at.
    pub options: Options,
    /// The methods, in the order of the tables.
    pub methods: Vec<Method>,
    /// Whether stills are rendered disturbed as well, which takes three more renders a method.
    pub robustness: bool,
}

impl Plan {
    fn options_for(&self, method: Method) -> Options {
        // An outline is drawn over the picture and would be counted as error.
        Options { method, outline: None, ..self.options.clone() }
    }
}

/// An input that could not be evaluated.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Failure {
    /// The input as it was named.
    pub path: PathBuf,
    /// What was wrong with it.
    pub error: String,
}

/// All that was found.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Evaluation {
    /// What was asked for.
    pub plan: Plan,
    /// The stills, in the order of the inputs.
    pub stills: Vec<StillScores>,
    /// The clips, in the order of the inputs.
    pub clips: Vec<ClipScores>,
    /// The inputs that could not be evaluated.
    pub failures: Vec<Failure>,
}
