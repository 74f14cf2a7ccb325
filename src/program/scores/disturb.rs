//! Disturbs pictures: with noise, with a part missing, compressed too hard (paper, section 4, robustness).

use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, ImageFormat, RgbImage};

use polyreel::chance::{Purpose, unit};
use polyreel::error::{Error, Result};
use polyreel::frame::Frame;

/// Standard deviation of the noise in steps of 0..255: variance 0.01 of the range, the default of
/// MATLAB's `imnoise` and scikit-image's `random_noise`.
const NOISE: f64 = 25.5;

/// The paper's: half a step of 0..255.
const FAINT_NOISE: f64 = 0.5;

/// Share of the frame that is covered.
const OCCLUDED: f64 = 0.02;

/// Quality of the JPEG, 1..100.
const JPEG_QUALITY: u8 = 10;

/// The kinds of disturbance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Disturbance {
    /// Gaussian noise of standard deviation 0.5 on every channel.
    FaintNoise,
    /// Gaussian noise of standard deviation 25.5 on every channel.
    Noise,
    /// A black rectangle of the frame's proportions over 2 % of it.
    Occlusion,
    /// JPEG at quality 10.
    Jpeg,
}

impl Disturbance {
    /// All of them, in the order in which they are listed.
    pub(crate) const ALL: [Self; 4] = [Self::FaintNoise, Self::Noise, Self::Occlusion, Self::Jpeg];

    /// `frame`, which must be opaque, after it. Chance is decided by `seed`.
    ///
    /// # Errors
    /// When the JPEG codec fails.
    pub(crate) fn apply(self, frame: &Frame, seed: u64) -> Result<Frame> {
        match self {
            Self::FaintNoise => noisy(frame, FAINT_NOISE, seed),
            Self::Noise => noisy(frame, NOISE, seed),
            Self::Occlusion => occluded(frame, seed),
            Self::Jpeg => compressed(frame),
        }
    }
}

fn noisy(frame: &Frame, sigma: f64, seed: u64) -> Result<Frame> {
    let size = frame.size();
    let mut pixels = frame.pixels().to_vec();
    for (pixel, i) in pixels.iter_mut().zip(0u32..) {
        let (x, y) = (i % size.width, i / size.width);
        for (c, value) in pixel[..3].iter_mut().enumerate() {
            let throw = |n: u64| unit(seed ^ ((2 * c as u64 + n + 1) << 32), Purpose::Noise, x, y);
            // Box and Muller, "A Note on the Generation of Random Normal Deviates", 1958.
            let normal =
                (-2.0 * (1.0 - throw(0)).ln()).sqrt() * (throw(1) * std::f64::consts::TAU).cos();
            // A float cast to an integer saturates.
            *value = (f64::from(*value) + sigma * normal + 0.5) as u8;
        }
    }
    Ok(Frame::new(size, pixels)?)
}

fn occluded(frame: &Frame, seed: u64) -> Result<Frame> {
    let size = frame.size();
    let mut pixels = frame.pixels().to_vec();
    let part = |side: u32| ((f64::from(side) * OCCLUDED.sqrt()).round() as u32).min(side);
    let (width, height) = (part(size.width), part(size.height));
    let place =
        |n: u32, room: u32| (unit(seed, Purpose::Noise, u32::MAX, n) * f64::from(room + 1)) as u32;
    let (left, top) = (place(0, size.width - width), place(1, size.height - height));
    for row in pixels.chunks_exact_mut(size.width as usize).skip(top as usize).take(height as usize)
    {
        row[left as usize..(left + width) as usize].fill([0, 0, 0, 255]);
    }
    Ok(Frame::new(size, pixels)?)
}

fn compressed(frame: &Frame) -> Result<Frame> {
    let failed = |error: image::ImageError| {
        Error::failed(format!("the JPEG codec failed: {error}")).caused_by(error)
    };
    let bytes = jpeg(frame, JPEG_QUALITY).map_err(failed)?;
    let decoded = image::load_from_memory_with_format(&bytes, ImageFormat::Jpeg).map_err(failed)?;
    Ok(Frame::from_image(decoded.to_rgba8())?)
}

/// The red, green and blue of `frame` as a JPEG.
pub(super) fn jpeg(frame: &Frame, quality: u8) -> image::ImageResult<Vec<u8>> {
    let size = frame.size();
    let raw = frame.pixels().iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    let image = RgbImage::from_raw(size.width, size.height, raw)
        .expect("a frame holds exactly width x height pixels");
    let mut bytes = Vec::new();
    DynamicImage::from(image)
        .write_with_encoder(JpegEncoder::new_with_quality(&mut bytes, quality))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use polyreel::geom::Size;
    use polyreel::metric::mse::mse;

    #[test]
    fn disturbances_are_as_strong_as_they_say() {
        let grey = Frame::filled(Size::new(200, 150), [128, 128, 128, 255]).expect("grey");
        let error =
            |d: Disturbance| mse(&grey, &d.apply(&grey, 3).expect("applies")).expect("one size");
        let noise = error(Disturbance::Noise);
        assert!((noise / (NOISE * NOISE) - 1.0).abs() < 0.03, "{noise}");
        // Rounded to whole steps, it has a variance of 1/12 more.
        let faint = error(Disturbance::FaintNoise);
        assert!((faint / (FAINT_NOISE * FAINT_NOISE + 1.0 / 12.0) - 1.0).abs() < 0.05, "{faint}");
        let covered = error(Disturbance::Occlusion) / (128.0 * 128.0);
        assert!((covered / OCCLUDED - 1.0).abs() < 0.05, "{covered}");
        assert!(error(Disturbance::Jpeg) < 4.0, "flat grey survives");
    }

    #[test]
    fn the_smallest_frames_can_be_disturbed() {
        let dot = Frame::filled(Size::new(1, 1), [9, 9, 9, 255]).expect("a pixel");
        for disturbance in Disturbance::ALL {
            let out = disturbance.apply(&dot, 0).expect("applies");
            assert_eq!(out.size(), dot.size());
            assert_eq!(out, disturbance.apply(&dot, 0).expect("applies"), "twice the same");
        }
    }
}
