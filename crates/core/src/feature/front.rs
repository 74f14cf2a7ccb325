//! Front ends: from a frame to [`Features`], by the name in [`Options::features`] or the method's own.

use super::contour::contours;
use super::edge_drawing::EdgeDrawing;
use super::edges::{laplacian, sobel};
use super::maps;
use super::mask::Mask;
use super::prefilter::filtered;
use super::priority::PrioritySampler;
use super::saliency::saliency;
use super::simplify::Simplify;
use super::slic::{Slic, corners};
use super::{Extractor, Features, region};
use crate::frame::Frame;
use crate::geom::Size;
use crate::options::{FrontEnd, Method, Options};
use crate::plane::Plane;

/// Exponents of the scores as weights. Entropy and saliency vary little: without an exponent nearly all pixels would
/// have about the same probability. See `docs/calibration.md`.
const ENTROPY_POWER: i32 = 4;
const SALIENCY_POWER: i32 = 1;
const EDGE_POWER: i32 = 2;

/// The share of all feature points that saliency alone adds to Canny's edges in Pic2PolyArt.
const SALIENT_SHARE: f64 = 0.2;

/// Points of a chain that lie closer than that to the line without them are no feature points, in pixels.
const TOLERANCE: f32 = 1.0;

/// A straight piece of an edge is split as if its middle were this share of its length off it: an edge of a mesh holds
/// on to the picture's only where it has vertices.
const STRAIGHT_SHARE: f32 = 0.25;

pub(super) fn features(extractor: &Extractor, frame: &Frame) -> Features {
    let options = &extractor.options;
    let filtered = options.prefilter.map(|filter| filtered(frame, filter));
    let frame = filtered.as_ref().unwrap_or(frame);
    let chosen = options.features.unwrap_or(options.method.own_features());
    let found = of(chosen, extractor, frame);
    if options.method == Method::Pic2polyart && chosen != FrontEnd::SalientEdges {
        return with_saliency(found, frame, options, options.features.is_none());
    }
    found
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
        FrontEnd::EdgeDrawing => drawn_edges(frame),
        FrontEnd::Contours => outlines(extractor, frame),
        FrontEnd::SalientEdges => with_saliency(maps::edges(&luma()).into(), frame, options, true),
    }
}

/// The points that matter to the shapes of edges, by how much they do.
fn drawn_edges(frame: &Frame) -> Features {
    let lightness = maps::visible_lightness(frame);
    let drawn = EdgeDrawing::default().draw(&lightness).expect("the defaults are in range");
    let simplify = Simplify { straight_share: STRAIGHT_SHARE };
    significant(frame.size(), drawn.chains.iter().map(|chain| (&chain[..], 0)), simplify)
}

/// The same of the contours of regions.
fn outlines(extractor: &Extractor, frame: &Frame) -> Features {
    let regions = extractor.regions(frame);
    let labels = Plane::new(regions.size, regions.labels).expect("a label for each pixel");
    let contours = contours(&labels);
    significant(frame.size(), contours.iter().map(|c| (&c.points[..], 1)), Simplify::PLAIN)
}

/// The points of chains that are above the tolerance, scored by how much they matter. Each chain comes with what is to
/// be taken from its coordinates.
fn significant<'a>(
    size: Size,
    chains: impl Iterator<Item = (&'a [(u32, u32)], u32)>,
    simplify: Simplify,
) -> Features {
    let mut candidates = Mask::new(size);
    let mut score = Plane::filled(size, 0.0f32);
    for (points, shift) in chains {
        let significance = simplify.significance(points);
        let kept = points.iter().zip(significance).filter(|(_, s)| *s > TOLERANCE);
        for (&(x, y), significance) in kept {
            let x = x.saturating_sub(shift).min(size.width - 1);
            let y = y.saturating_sub(shift).min(size.height - 1);
            candidates.insert(x, y);
            score.set(x, y, score.at(x, y).max(significance));
        }
    }
    Features { score: Some(score), ..candidates.into() }
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

/// `found` with saliency as its score, and with salient points if `adds` says so.
fn with_saliency(mut found: Features, frame: &Frame, options: &Options, adds: bool) -> Features {
    let score = saliency(&maps::visible_luma(frame));
    if adds {
        let share = SALIENT_SHARE * options.candidates;
        let salient = PrioritySampler::new(&score, SALIENCY_POWER, options.seed).sample(share);
        let words = found.candidates.words_mut().iter_mut();
        words.zip(salient.words()).for_each(|(word, salient)| *word |= salient);
    }
    Features { score: Some(score), ..found }
}
