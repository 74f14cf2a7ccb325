//! The paper's tables on any pictures: every method at the same number of seeds.
//!
//! Without refinement, as in the paper, and with it. Sizes, rates, errors and times of stills ([`still`]) and of
//! clips ([`clip`]); Tables 2, 3 and 4, the robustness figure and the clips' table as plain [`Table`]s ([`tables`]).

pub(crate) mod clip;
pub(crate) mod disturb;
pub(crate) mod still;
pub(crate) mod table;
pub(crate) mod tables;
pub(crate) mod thumbnail;

use std::path::PathBuf;

use clip::ClipScores;
pub(crate) use polyreel::metric::over_white;
use polyreel::options::{Method, Options, Quality};
use polyreel::refine::RefineOptions;
use still::StillScores;
pub(crate) use table::Table;

/// A method, without or with refinement after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Variant {
    /// Levels one and two.
    pub(crate) method: Method,
    /// Whether level three follows.
    pub(crate) refined: bool,
}

impl std::fmt::Display for Variant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.method.name())?;
        f.write_str(if self.refined { ", refined" } else { "" })
    }
}

/// What is evaluated.
#[derive(Clone, Debug, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) struct Plan {
    /// The options of every method, except its `method`. Every method renders without refinement, as in the paper,
    /// and with it if these options request any.
    pub(crate) options: Options,
    /// The methods, in the order of the tables.
    pub(crate) methods: Vec<Method>,
    /// Whether stills are rendered disturbed as well, which takes three more renders a method.
    pub(crate) robustness: bool,
}

impl Plan {
    /// Whether there is a refinement.
    pub(crate) fn refines(&self) -> bool {
        RefineOptions::fresh(&self.options).steps > 0
    }

    /// All variants: all methods without refinement, then, if any, with it.
    fn variants(&self) -> impl Iterator<Item = Variant> {
        let refined = if self.refines() { &[false, true][..] } else { &[false] };
        let all =
            move |&refined| self.methods.iter().map(move |&method| Variant { method, refined });
        refined.iter().flat_map(all)
    }

    fn options_for(&self, Variant { method, refined }: Variant) -> Options {
        // An outline is drawn over the picture and would be counted as error.
        let options = Options { method, outline: None, ..self.options.clone() };
        if refined {
            return options;
        }
        Options { quality: Quality::Draft, refine: None, error: None, ..options }
    }
}

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
