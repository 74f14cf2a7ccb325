//! Front ends: from a frame to [`Features`], by the name in [`Options::features`] or the method's own.

use super::edges::{laplacian, sobel};
use super::maps;
use super::priority::PrioritySampler;
use super::saliency::saliency;
use super::slic::{Slic, corners};
use super::{Extractor, Features, region};
use crate::frame::Frame;
use crate::options::{FrontEnd, Method, Options};
use crate::plane::Plane;

/// Exponents of the scores as weights. Entropy and saliency vary little: without an exponent nearly all pixels would
/// have about the same probability. See `docs/calibration.md`.
const ENTROPY_POWER: i32 = 4;
const SALIENCY_POWER: i32 = 1;
const EDGE_POWER: i32 = 2;

/// The share of all feature points that saliency alone adds to Canny's edges in Pic2PolyArt.
const SALIENT_SHARE: f64 = 0.2;

pub(super) fn features(extractor: &Extractor, frame: &Frame) -> Features {
    let options = &extractor.options;
    let chosen = options.features.unwrap_or(options.method.own_features());
    let found = of(chosen, extractor, frame);
    if options.method == Method::Pic2polyart { with_saliency(found, frame, options) } else { found }
}

fn of(front: FrontEnd, extractor: &Extractor, frame: &Frame) -> Features {
    let options = &extractor.options;
    let luma = || maps::visible_luma(frame);
    match front {
        FrontEnd::Regions => {
            region::pick_points(&extractor.regions(frame), extractor.picks()).into()
        }
        FrontEnd::Canny => maps::edges(&luma()).into(),
        FrontEnd::Slic => superpixel_corners(frame, options),
        FrontEnd::Sobel => scored(sobel(&luma()), EDGE_POWER, options),
        FrontEnd::Laplacian => scored(laplacian(&luma()), EDGE_POWER, options),
        FrontEnd::Saliency => scored(saliency(&luma()), SALIENCY_POWER, options),
        FrontEnd::Entropy => {
            let diffused = maps::diffused(&luma(), options);
            scored(maps::entropy_of(&diffused, options), ENTROPY_POWER, options)
        }
    }
}

fn scored(score: Plane<f32>, power: i32, options: &Options) -> Features {
    let candidates = PrioritySampler::new(&score, power, options.seed).sample(options.candidates);
    Features { score: Some(score), ..candidates.into() }
}

fn superpixel_corners(frame: &Frame, options: &Options) -> Features {
    // If three regions meet in most corners, there are two corners for each region (Euler).
    let count = (frame.size().pixels() as f64 * options.candidates / 2.0).ceil() as u32;
    let labels = Slic::new(count.max(1)).segment(frame).expect("SLIC's defaults are in range");
    corners(&labels).into()
}

/// `found` with saliency as its score and, for the method's own front end, with salient points.
fn with_saliency(mut found: Features, frame: &Frame, options: &Options) -> Features {
    let score = saliency(&maps::visible_luma(frame));
    if options.features.is_none() {
        let share = SALIENT_SHARE * options.candidates;
        let salient = PrioritySampler::new(&score, SALIENCY_POWER, options.seed).sample(share);
        let words = found.candidates.words_mut().iter_mut();
        words.zip(salient.words()).for_each(|(word, salient)| *word |= salient);
    }
    Features { score: Some(score), ..found }
}
