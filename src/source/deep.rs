//! Pictures of 16 bits a channel, as 8-bit RGBA: their colours are converted to sRGB before they are rounded, for
//! an 8-bit value of linear light, for instance, is up to 13 levels of sRGB.

use super::profile::DeepToSrgb;
use crate::frame::Rgba;

/// The nearest of 255 levels.
fn narrow(value: u16) -> u8 {
    ((u32::from(value) + 128) / 257) as u8
}

/// Appends pixels of `channels` values each: gray, or red, green and blue; one more is alpha.
pub(super) fn push(
    pixels: &mut Vec<Rgba>,
    values: &[u16],
    channels: usize,
    to_srgb: Option<&DeepToSrgb>,
) {
    let wide = values.chunks_exact(channels).map(|pixel| match *pixel {
        [v] => [v, v, v, u16::MAX],
        [v, a] => [v, v, v, a],
        [r, g, b] => [r, g, b, u16::MAX],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [0; 4],
    });
    match to_srgb {
        None => pixels.extend(wide.map(|pixel| pixel.map(narrow))),
        Some(to_srgb) => {
            let wide = to_srgb.converted(wide.collect());
            pixels.extend(wide.into_iter().map(|pixel| pixel.map(narrow)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::profile::ColourSpace;

    #[test]
    fn sixteen_bits_become_the_nearest_of_eight() {
        let mut pixels = Vec::new();
        push(&mut pixels, &[0, 128, 129, 65535], 1, None);
        push(&mut pixels, &[65535, 257, 514, 32896], 4, None);
        let grays = [[0, 0, 0, 255], [0, 0, 0, 255], [1, 1, 1, 255], [255; 4]];
        assert_eq!(pixels[..4], grays);
        assert_eq!(pixels[4], [255, 1, 2, 128]);
    }

    #[test]
    fn linear_light_keeps_its_dark_levels() {
        let linear = ColourSpace::Gamma { gamma: Some(1.0), primaries: None };
        for gray in [false, true] {
            let to_srgb = DeepToSrgb::new(&linear, gray).expect("a conversion");
            for level in 0..=255u32 {
                let encoded = f64::from(level) / 255.0;
                let light = if encoded <= 0.04045 {
                    encoded / 12.92
                } else {
                    ((encoded + 0.055) / 1.055).powf(2.4)
                };
                let value = (light * 65535.0).round() as u16;
                let mut pixels = Vec::new();
                push(&mut pixels, &[value, value, value, 700], 4, Some(&to_srgb));
                let off = (0..3).map(|c| u32::from(pixels[0][c]).abs_diff(level)).max();
                assert!(off <= Some(1), "{level}: {:?}", pixels[0]);
                assert_eq!(pixels[0][3], 3);
            }
        }
    }
}
