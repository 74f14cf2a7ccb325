//! Size, rotation, rate and colour of a video stream, from ffprobe's fields.

use serde_json::Value;

use super::fields::{fraction, text};
use super::heif::Heif;
use super::tracks::tag;
use crate::frame::{Colorimetry, Rational};
use crate::geom::Size;

/// ffmpeg filters that rotate and mirror a HEIF picture as it is to be shown.
pub(super) fn turning(heif: Heif) -> String {
    let turn = ["", "transpose=cclock,", "hflip,vflip,", "transpose=clock,"];
    let mirror = match heif.mirror {
        Some(0) => "vflip,",
        Some(_) => "hflip,",
        None => "",
    };
    format!("{}{mirror}", turn[usize::from(heif.turns & 3)])
}

/// Frames per second: the nominal rate, of which every frame time is a multiple, unless it is above 240; then the mean
/// rate.
pub(super) fn rate(stream: &Value) -> Option<Rational> {
    let nominal = text(stream, "r_frame_rate").and_then(fraction);
    let mean = text(stream, "avg_frame_rate").and_then(fraction);
    nominal.filter(|rate| mean.is_none() || *rate <= Rational::new(240, 1)).or(mean)
}

/// Width and height after the crop, the pixel aspect and the rotation are applied, as ffmpeg does it.
pub(super) fn shown_size(stream: &Value) -> Option<Size> {
    let Size { width, height } = flat_size(stream)?;
    let turned = rotation(stream).rem_euclid(180.0);
    // ffmpeg's tolerance: one degree around a quarter turn.
    let upright = (turned - 90.0).abs() >= 1.0;
    Some(if upright { Size::new(width, height) } else { Size::new(height, width) })
}

/// As [`shown_size`], before the rotation.
pub(super) fn flat_size(stream: &Value) -> Option<Size> {
    // Of the container's crop only those ffmpegs tell that apply it.
    let cropped =
        |key: &str| side_data(stream).iter().find_map(|data| data[key].as_u64()).unwrap_or(0);
    let side = |key, crops: [&str; 2]| {
        let side = stream[key].as_u64()?.checked_sub(crops.map(cropped).iter().sum())?;
        u32::try_from(side).ok()
    };
    let width = side("width", ["crop_left", "crop_right"])?;
    let height = side("height", ["crop_top", "crop_bottom"])?;
    let aspect = text(stream, "sample_aspect_ratio").and_then(fraction);
    let stretched = aspect.map_or(f64::from(width), |a| f64::from(width) * a.to_f64());
    Some(Size::new(stretched.round().clamp(1.0, f64::from(u32::MAX)) as u32, height))
}

fn side_data(stream: &Value) -> &[Value] {
    stream["side_data_list"].as_array().map_or(&[], Vec::as_slice)
}

/// What a stream says of Dolby Vision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct DolbyVision {
    pub(super) profile: u64,
    /// What its base layer is without the metadata: HDR10, SDR, HLG; 0 for nothing that others can show.
    pub(super) base: u64,
}

impl DolbyVision {
    pub(super) fn of(stream: &Value) -> Option<Self> {
        side_data(stream).iter().find_map(|data| {
            let base = data["dv_bl_signal_compatibility_id"].as_u64()?;
            Some(Self { profile: data["dv_profile"].as_u64()?, base })
        })
    }
}

/// Rotation of the picture in degrees.
pub(super) fn rotation(stream: &Value) -> f64 {
    let reported = side_data(stream).iter().find_map(|data| data["rotation"].as_f64());
    reported.or_else(|| tag(stream, "rotate")?.parse().ok()).unwrap_or(0.0)
}

/// The colour tags of a stream, in ffmpeg's names.
pub(super) fn colorimetry(stream: &Value) -> Colorimetry {
    let tag = |key| text(stream, key).map(str::to_string);
    Colorimetry {
        matrix: tag("color_space"),
        range: tag("color_range"),
        primaries: tag("color_primaries"),
        transfer: tag("color_transfer"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn sizes_are_those_that_are_shown() {
        let stream = json!({"width": 720, "height": 576, "sample_aspect_ratio": "16:15",
            "side_data_list": [{"rotation": -90}]});
        assert_eq!(shown_size(&stream), Some(Size::new(576, 768)));
        let cropped = json!({"width": 1920, "height": 1088, "side_data_list": [
            {"crop_top": 0, "crop_bottom": 8, "crop_left": 20, "crop_right": 20}]});
        assert_eq!(shown_size(&cropped), Some(Size::new(1880, 1080)));
        let plain = json!({"width": 3, "height": 5, "sample_aspect_ratio": "0:1"});
        assert_eq!(shown_size(&plain), Some(Size::new(3, 5)));
    }

    #[test]
    fn rates_are_nominal_when_kept() {
        let rate = |r, avg| rate(&json!({"r_frame_rate": r, "avg_frame_rate": avg}));
        assert_eq!(rate("30000/1001", "19001/634"), Some(Rational::new(30000, 1001)));
        assert_eq!(rate("50/1", "20/1"), Some(Rational::new(50, 1)));
        assert_eq!(rate("1000/1", "20/1"), Some(Rational::new(20, 1)));
        assert_eq!(rate("25/1", "0/0"), Some(Rational::new(25, 1)));
        assert_eq!(rate("0/0", "0/0"), None);
    }
}
