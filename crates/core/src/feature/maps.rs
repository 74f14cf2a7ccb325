//! The maps of a frame with the parameters of [`Options`]: the scores of methods, as `inspect` shows them.

use super::canny::Canny;
use super::diffusion::Diffusion;
use super::entropy::entropy;
use super::lab::Lab;
use super::mask::Mask;
use crate::frame::{Frame, Rgba, luma, over};
use crate::options::Options;
use crate::plane::Plane;

const VALID: &str = "the options were validated before the chain was built";

/// The visible luma of `frame`, 0..255: transparent pixels are composed over white, so that invisible colours make no
/// features.
pub fn visible_luma(frame: &Frame) -> Plane<u8> {
    if frame.is_opaque() {
        return Plane::luma(frame);
    }
    let over_white = |&pixel: &Rgba| {
        let grey = luma(pixel);
        over([grey, grey, grey, pixel[3]], [255; 4])[0]
    };
    Plane::new(frame.size(), frame.pixels().iter().map(over_white).collect())
        .expect("a frame holds exactly width x height pixels")
}

/// The visible lightness of `frame`, L* of CIE L*a*b* stretched to 0..255; transparent pixels over white.
pub fn visible_lightness(frame: &Frame) -> Plane<u8> {
    let over_white = |&pixel: &Rgba| over(pixel, [255; 4]);
    let opaque = (!frame.is_opaque()).then(|| {
        let pixels = frame.pixels().iter().map(over_white).collect();
        Frame::known(frame.size(), pixels, true).expect("as many pixels as before")
    });
    let lightness = Lab::lightness(opaque.as_ref().unwrap_or(frame));
    Plane::new(frame.size(), lightness).expect("a value for each pixel")
}

/// `luma` after anisotropic diffusion, 0..255.
pub fn diffused(luma: &Plane<u8>, options: &Options) -> Plane<f32> {
    let diffusion = Diffusion {
        iterations: options.diffusion_iterations,
        kappa: options.diffusion_kappa as f32,
        gamma: options.diffusion_gamma as f32,
    };
    diffusion.diffuse(luma).expect(VALID)
}

/// The local entropy of a plane after diffusion, in bits (paper, HELP level one).
pub fn entropy_of(diffused: &Plane<f32>, options: &Options) -> Plane<f32> {
    entropy(&diffused.to_bytes(), options.entropy_radius).expect(VALID)
}

/// Canny's edges with their thresholds chosen for the picture.
pub fn edges(luma: &Plane<u8>) -> Mask {
    Canny::default().edges(luma).expect("Canny's defaults are in range")
}
