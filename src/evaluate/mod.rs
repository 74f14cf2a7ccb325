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

use crate::frame::Frame;
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

/// `frame` over white: what is compared, so that colours which nobody sees do not count.
pub fn over_white(frame: &Frame) -> Frame {
    if frame.is_opaque() {
        return frame.clone();
    }
    let pixels = frame.pixels().iter().map(|&[r, g, b, a]| {
        let over =
            |v: u8| ((u32::from(v) * u32::from(a) + 255 * (255 - u32::from(a)) + 127) / 255) as u8;
        [over(r), over(g), over(b), 255]
    });
    Frame::new(frame.size(), pixels.collect()).expect("as many pixels as before")
}
