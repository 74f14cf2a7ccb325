//! Converts the colours of a file to sRGB.
//!
//! Conversions are relative colorimetric, by the `moxcms` crate. If no colour of a space differs from its sRGB value
//! by more than [`SAME`], pixels are not changed.

use std::sync::Arc;

use moxcms::{
    Chromaticity, CicpColorPrimaries, CicpProfile, ColorPrimaries, ColorProfile, DataColorSpace,
    Layout, LutType, LutWarehouse, MatrixCoefficients, RenderingIntent, ToneReprCurve,
    TransferCharacteristics, Transform8BitExecutor, Transform16BitExecutor, TransformOptions,
};
use rayon::prelude::*;

use super::fence;
use super::limit::METADATA;
use crate::frame::Rgba;

/// Chromaticities, as `[x, y]` (CIE 1931).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Primaries {
    pub(super) white: [f32; 2],
    pub(super) red: [f32; 2],
    pub(super) green: [f32; 2],
    pub(super) blue: [f32; 2],
}

/// The colour space of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ColourSpace {
    /// An ICC profile.
    Icc(Vec<u8>),
    /// Code points of ITU-T H.273.
    Cicp { primaries: u8, transfer: u8 },
    /// The exponent of the encoding (for instance 1/2.2), and primaries; by default those of sRGB.
    Gamma { gamma: Option<f64>, primaries: Option<Primaries> },
    /// Curves of 16-bit values, one for all channels or three, and primaries, as in TIFF.
    Curves { curves: Vec<Vec<u16>>, primaries: Option<Primaries> },
}

/// The largest difference of a channel of colours that count as equal.
const SAME: u8 = 2;

/// Pixels that are converted at once.
const PIECE: usize = 1 << 14;

/// Converts pixels to sRGB.
pub(super) enum ToSrgb {
    Rgb(Arc<Transform8BitExecutor>),
    /// For gray pictures: the new value of each value.
    Gray(Box<[u8; 256]>),
}

impl ToSrgb {
    /// The conversion from `space`, for a picture that is `gray` or not. `None` if the space is sRGB, or if it cannot
    /// be converted: a broken profile, or one for other channels than the picture's, is ignored, as in browsers.
    pub(super) fn new(space: &ColourSpace, gray: bool) -> Option<Self> {
        fence::run("ICC profile", || conversion(space, gray)).ok().flatten()
    }

    /// Converts `pixels`. Alpha stays.
    pub(super) fn apply(&self, pixels: &mut [Rgba]) {
        pixels.par_chunks_mut(PIECE).for_each(|piece| self.convert(piece));
    }

    fn convert(&self, pixels: &mut [Rgba]) {
        match self {
            Self::Gray(table) => {
                for [r, g, b, _] in pixels {
                    [*r, *g, *b] = [table[*r as usize]; 3];
                }
            }
            Self::Rgb(transform) => {
                let before = pixels.to_vec();
                if transform.transform(before.as_flattened(), pixels.as_flattened_mut()).is_err() {
                    pixels.copy_from_slice(&before);
                }
            }
        }
    }

    /// Whether no colour changes by more than [`SAME`].
    fn is_identity(&self) -> bool {
        let level = |v: usize| (v * 255 / 16) as u8;
        let levels = (0..17usize.pow(3)).map(|i| [i / 289, i / 17 % 17, i % 17].map(level));
        let grays = (0..=255u8).map(|v| [v; 3]);
        let before: Vec<Rgba> = match self {
            Self::Gray(_) => grays.map(|[v, ..]| [v, v, v, 255]).collect(),
            Self::Rgb(_) => levels.chain(grays).map(|[r, g, b]| [r, g, b, 255]).collect(),
        };
        let mut after = before.clone();
        self.convert(&mut after);
        before.as_flattened().iter().zip(after.as_flattened()).all(|(a, b)| a.abs_diff(*b) <= SAME)
    }
}

/// Converts pixels of 16 bits a channel to sRGB.
pub(super) enum DeepToSrgb {
    Rgb(Arc<Transform16BitExecutor>),
    /// Of gray pictures: the new value for each.
    Gray(Box<[u16]>),
}

impl DeepToSrgb {
    /// As [`ToSrgb::new`].
    pub(super) fn new(space: &ColourSpace, gray: bool) -> Option<Self> {
        ToSrgb::new(space, gray)?;
        fence::run("ICC profile", || deep_conversion(space)).ok().flatten()
    }

    /// `pixels` in sRGB. Alpha stays.
    pub(super) fn converted(&self, mut pixels: Vec<[u16; 4]>) -> Vec<[u16; 4]> {
        match self {
            Self::Gray(table) => {
                for [r, g, b, _] in &mut pixels {
                    [*r, *g, *b] = [table[*r as usize]; 3];
                }
                pixels
            }
            Self::Rgb(transform) => {
                let mut after = pixels.clone();
                let done = transform.transform(pixels.as_flattened(), after.as_flattened_mut());
                if done.is_ok() { after } else { pixels }
            }
        }
    }
}

fn options() -> TransformOptions {
    TransformOptions {
        rendering_intent: RenderingIntent::RelativeColorimetric,
        ..TransformOptions::default()
    }
}

fn deep_conversion(space: &ColourSpace) -> Option<DeepToSrgb> {
    let profile = profile(space)?;
    let (srgb, options) =
        (ColorProfile::new_srgb(), TransformOptions { prefer_fixed_point: false, ..options() });
    let transform = |from| profile.create_transform_16bit(from, &srgb, Layout::Rgba, options).ok();
    if profile.color_space == DataColorSpace::Rgb {
        return Some(DeepToSrgb::Rgb(transform(Layout::Rgba)?));
    }
    let values: Vec<u16> = (0..=u16::MAX).collect();
    let mut pixels = vec![[0; 4]; values.len()];
    transform(Layout::Gray)?.transform(&values, pixels.as_flattened_mut()).ok()?;
    Some(DeepToSrgb::Gray(pixels.iter().map(|pixel| pixel[0]).collect()))
}

fn conversion(space: &ColourSpace, gray: bool) -> Option<ToSrgb> {
    let profile = profile(space)?;
    let srgb = ColorProfile::new_srgb();
    let transform = |from| profile.create_transform_8bit(from, &srgb, Layout::Rgba, options()).ok();
    let conversion = match profile.color_space {
        DataColorSpace::Rgb => ToSrgb::Rgb(transform(Layout::Rgba)?),
        DataColorSpace::Gray if gray => ToSrgb::Gray(gray_table(&*transform(Layout::Gray)?)?),
        _ => return None,
    };
    (!conversion.is_identity()).then_some(conversion)
}

fn gray_table(transform: &Transform8BitExecutor) -> Option<Box<[u8; 256]>> {
    let values: Vec<u8> = (0..=255).collect();
    let mut pixels = [[0; 4]; 256];
    transform.transform(&values, pixels.as_flattened_mut()).ok()?;
    Some(Box::new(pixels.map(|[r, ..]| r)))
}

fn profile(space: &ColourSpace) -> Option<ColorProfile> {
    match space {
        ColourSpace::Icc(bytes) if bytes.len() as u64 > METADATA => None,
        ColourSpace::Icc(bytes) => icc(bytes),
        ColourSpace::Cicp { primaries, transfer } => from_code_points(*primaries, *transfer),
        ColourSpace::Gamma { gamma, primaries } => {
            let curve = gamma.map_or_else(srgb_curve, gamma_curve);
            Some(with(*primaries, [curve.clone(), curve.clone(), curve]))
        }
        ColourSpace::Curves { curves, primaries } => {
            let curve = |i: usize| ToneReprCurve::Lut(curves[i.min(curves.len() - 1)].clone());
            (!curves.is_empty()).then(|| with(*primaries, [0, 1, 2].map(curve)))
        }
    }
}

/// The profile in `bytes`, such that `moxcms` converts it as LittleCMS does.
fn icc(bytes: &[u8]) -> Option<ColorProfile> {
    let mut profile = ColorProfile::new_from_slice(bytes).ok()?;
    if let Some(version) = version_of_table(&profile).filter(|&version| version != bytes[VERSION]) {
        let mut bytes = bytes.to_vec();
        bytes[VERSION] = version;
        profile = ColorProfile::new_from_slice(&bytes).ok()?;
    }
    // The table of the perceptual intent is for every intent that has none, and the matrix is used if it is missing
    // (ICC.1:2022, 8.10.2).
    if profile.lut_a_to_b_colorimetric.is_none() {
        profile.lut_a_to_b_colorimetric = profile.lut_a_to_b_perceptual.clone();
        profile.lut_a_to_b_saturation = None;
    }
    if profile.color_space == DataColorSpace::Gray && profile.pcs == DataColorSpace::Lab {
        lightness_to_light(&mut profile)?;
    }
    Some(profile)
}

/// The byte of a profile's header that is its major version.
const VERSION: usize = 8;

/// The version whose encoding of CIELAB the profile's table has: tables of 16 bits have that of version 2, even in
/// profiles of version 4, and those of 8 bits the other one (ICC.1, lut16Type and lut8Type). `moxcms` goes by the
/// profile's version. `None` if there is no such table.
fn version_of_table(profile: &ColorProfile) -> Option<u8> {
    let table = profile.lut_a_to_b_colorimetric.as_ref().or(profile.lut_a_to_b_perceptual.as_ref());
    match table {
        Some(LutWarehouse::Lut(table)) if profile.pcs == DataColorSpace::Lab => {
            Some(if table.lut_type == LutType::Lut16 { 2 } else { 4 })
        }
        _ => None,
    }
}

/// Changes the curve of a gray profile that gives L* of CIELAB, for which `moxcms` has no conversion, to one that
/// gives Y. `None` if it has no sound curve.
fn lightness_to_light(profile: &mut ColorProfile) -> Option<()> {
    let lightness = profile.gray_trc.as_ref()?.make_linear_evaluator().ok()?;
    profile.gray_trc = Some(curve(|value| {
        let f = (f64::from(lightness.evaluate_value(value as f32)) * 100.0 + 16.0) / 116.0;
        if f > 6.0 / 29.0 { f.powi(3) } else { 3.0 * (6.0f64 / 29.0).powi(2) * (f - 4.0 / 29.0) }
    }));
    profile.pcs = DataColorSpace::Xyz;
    Some(())
}

/// A profile of `primaries` (by default those of sRGB) and curves.
fn with(primaries: Option<Primaries>, curves: [ToneReprCurve; 3]) -> ColorProfile {
    let mut profile = ColorProfile::new_srgb();
    profile.cicp = None;
    if let Some(Primaries { white, red, green, blue }) = primaries {
        let point = |[x, y]: [f32; 2]| Chromaticity::new(x, y);
        let primaries = ColorPrimaries { red: point(red), green: point(green), blue: point(blue) };
        profile.update_rgb_colorimetry(point(white).to_xyyb(), primaries);
    }
    [profile.red_trc, profile.green_trc, profile.blue_trc] = curves.map(Some);
    profile
}

fn srgb_curve() -> ToneReprCurve {
    ToneReprCurve::Parametric(vec![2.4, 1. / 1.055, 0.055 / 1.055, 1. / 12.92, 0.04045])
}

/// The curve of samples encoded with the exponent `gamma`. Values near 1/2.2 mean sRGB: many encoders write 1/2.2 for
/// sRGB, and libpng has the same tolerance.
fn gamma_curve(gamma: f64) -> ToneReprCurve {
    if (gamma * 2.2 - 1.0).abs() < 0.05 || gamma <= 0.0 {
        return srgb_curve();
    }
    ToneReprCurve::Parametric(vec![(1.0 / gamma) as f32])
}

/// Luminance of white in SDR, in cd/m2, and of PQ's and HLG's largest values (ITU-R BT.2408, BT.2100).
const WHITE: f64 = 203.0;
const PQ_PEAK: f64 = 10000.0;
const HLG_PEAK: f64 = 1000.0;

fn from_code_points(primaries: u8, transfer: u8) -> Option<ColorProfile> {
    let color_primaries = CicpColorPrimaries::try_from(primaries).ok()?;
    // The curves of PQ and HLG are not relative to white; values above white are clipped.
    let hdr = match transfer {
        16 => Some(curve(|v| pq(v) * PQ_PEAK / WHITE)),
        18 => Some(curve(|v| hlg(v).powf(1.2) * HLG_PEAK / WHITE)),
        _ => None,
    };
    let transfer_characteristics = match hdr {
        Some(_) => TransferCharacteristics::Srgb,
        None => TransferCharacteristics::try_from(transfer).ok()?,
    };
    let mut profile = ColorProfile::new_srgb();
    (profile.cicp, profile.red_trc) = (None, None);
    // The return value does not matter: the fields show whether the code points are known.
    profile.update_rgb_colorimetry_from_cicp(CicpProfile {
        color_primaries,
        transfer_characteristics,
        matrix_coefficients: MatrixCoefficients::Identity,
        full_range: true,
    });
    let known = profile.cicp.is_some() && profile.red_trc.is_some();
    if let Some(curve) = hdr {
        profile.cicp = None;
        [profile.red_trc, profile.green_trc, profile.blue_trc] =
            [0, 1, 2].map(|_| Some(curve.clone()));
    }
    known.then_some(profile)
}

fn curve(linear: impl Fn(f64) -> f64) -> ToneReprCurve {
    let value = |i: u32| (linear(f64::from(i) / 4095.0).min(1.0) * 65535.0).round() as u16;
    ToneReprCurve::Lut((0..4096).map(value).collect())
}

/// SMPTE ST 2084 (PQ), as a share of the peak.
fn pq(value: f64) -> f64 {
    let power = value.powf(32.0 / 2523.0);
    let base = (power - 0.8359375).max(0.0) / (18.8515625 - 18.6875 * power);
    base.powf(16384.0 / 2610.0)
}

/// The light of the scene by HLG of ITU-R BT.2100.
fn hlg(value: f64) -> f64 {
    if value <= 0.5 {
        return value * value / 3.0;
    }
    (((value - 0.559_910_73) / 0.178_832_77).exp() + 0.284_668_92) / 12.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const P3: Primaries = Primaries {
        white: [0.3127, 0.329],
        red: [0.68, 0.32],
        green: [0.265, 0.69],
        blue: [0.15, 0.06],
    };

    fn converted(space: &ColourSpace, colour: Rgba) -> Rgba {
        let mut pixels = [colour];
        ToSrgb::new(space, false).expect("a conversion").apply(&mut pixels);
        pixels[0]
    }

    fn near(a: Rgba, b: Rgba) -> bool {
        a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 2)
    }

    #[test]
    fn display_p3_becomes_srgb_however_it_is_named() {
        let encoded = with(Some(P3), [0; 3].map(|_| srgb_curve())).encode().expect("a profile");
        for space in [
            ColourSpace::Icc(encoded),
            ColourSpace::Cicp { primaries: 12, transfer: 13 },
            ColourSpace::Gamma { gamma: None, primaries: Some(P3) },
        ] {
            // The value is LittleCMS's.
            let red = converted(&space, [220, 60, 40, 77]);
            assert!(near(red, [239, 35, 17, 77]), "{red:?} of {space:?}");
        }
    }

    #[test]
    fn what_is_srgb_stays_as_it_is() {
        let srgb = Primaries {
            white: [0.3127, 0.329],
            red: [0.64, 0.33],
            green: [0.3, 0.6],
            blue: [0.15, 0.06],
        };
        for space in [
            ColourSpace::Icc(ColorProfile::new_srgb().encode().expect("a profile")),
            ColourSpace::Cicp { primaries: 1, transfer: 13 },
            ColourSpace::Gamma { gamma: Some(0.45455), primaries: Some(srgb) },
            ColourSpace::Gamma { gamma: Some(0.45455), primaries: None },
            ColourSpace::Icc(b"no profile at all".to_vec()),
        ] {
            assert!(ToSrgb::new(&space, false).is_none(), "{space:?}");
        }
    }

    #[test]
    fn linear_light_becomes_brighter() {
        let linear = ColourSpace::Gamma { gamma: Some(1.0), primaries: None };
        assert!(near(converted(&linear, [55, 55, 55, 255]), [128, 128, 128, 255]));
    }

    #[test]
    fn white_of_pq_is_white() {
        // 58 % of the signal is 203 cd/m2.
        let pq = ColourSpace::Cicp { primaries: 9, transfer: 16 };
        let white = converted(&pq, [148, 148, 148, 255]);
        assert!(near(white, [255; 4]), "{white:?}");
        let grey = converted(&pq, [100, 100, 100, 255]);
        assert!(grey[0] > 60 && grey[0] < 160, "{grey:?}");
    }

    #[test]
    fn gray_profiles_are_for_gray_pictures() {
        let gray = ColorProfile::new_gray_with_gamma(1.0).encode().expect("a profile");
        let mut pixels = [[55, 55, 55, 9]];
        ToSrgb::new(&ColourSpace::Icc(gray.clone()), true).expect("one").apply(&mut pixels);
        assert!(near(pixels[0], [128, 128, 128, 9]), "{pixels:?}");
        assert!(ToSrgb::new(&ColourSpace::Icc(gray), false).is_none());
    }
}
