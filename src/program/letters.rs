//! Letters on pictures: DejaVu Sans, of which the file here has the letters of Latin scripts.

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use image::{Rgb, RgbImage};

/// Made by `pyftsubset DejaVuSans.ttf --unicodes=U+0020-007E,U+00A0-017F,U+2013,U+2014,U+2026`.
const FONT: &[u8] = include_bytes!("letters/DejaVuSans.ttf");

/// What stands for the end of a text that is too long.
const ELLIPSIS: char = '\u{2026}';

/// The font at one size.
#[derive(Debug)]
pub(crate) struct Letters {
    font: FontRef<'static>,
    scale: PxScale,
}

impl Letters {
    /// Letters whose lines are `height` pixels high.
    pub(crate) fn new(height: u32) -> Self {
        let font = FontRef::try_from_slice(FONT).expect("the font is a fixed, sound one");
        Self { font, scale: PxScale::from(height as f32) }
    }

    /// The width of `text` in pixels.
    pub(crate) fn width(&self, text: &str) -> u32 {
        self.line(text).1.ceil() as u32
    }

    /// `text`, cut where it would be wider than `width`.
    pub(crate) fn fitted(&self, text: &str, width: u32) -> String {
        if self.width(text) <= width {
            return text.to_owned();
        }
        let mut kept: Vec<char> = text.chars().collect();
        while kept.pop().is_some() {
            let cut: String = kept.iter().copied().chain([ELLIPSIS]).collect();
            if self.width(&cut) <= width {
                return cut;
            }
        }
        String::new()
    }

    /// Writes `text` in `ink` on `picture`, with its top left corner at `(left, top)`.
    pub(crate) fn write(&self, picture: &mut RgbImage, text: &str, at: (u32, u32), ink: Rgb<u8>) {
        self.draw(text, at, |place, coverage| blend(picture, place, ink, coverage));
    }

    /// Calls `dot` with each pixel that `text` covers, and how much of it, 0 to 1. The text's top left corner is at
    /// `(left, top)`.
    pub(crate) fn draw(
        &self,
        text: &str,
        (left, top): (u32, u32),
        mut dot: impl FnMut((u32, u32), f32),
    ) {
        for mut glyph in self.line(text).0 {
            glyph.position += point(left as f32, top as f32);
            let Some(outlined) = self.font.outline_glyph(glyph) else { continue };
            let corner = outlined.px_bounds().min;
            outlined.draw(|x, y, coverage| {
                let at = (corner.x + x as f32, corner.y + y as f32);
                if at.0 >= 0.0 && at.1 >= 0.0 {
                    dot((at.0 as u32, at.1 as u32), coverage);
                }
            });
        }
    }

    /// The letters of `text` in their places, and the width of all.
    fn line(&self, text: &str) -> (Vec<Glyph>, f32) {
        let font = self.font.as_scaled(self.scale);
        let (mut glyphs, mut x) = (Vec::new(), 0.0);
        for letter in text.chars() {
            let id = font.glyph_id(letter);
            if let Some(last) = glyphs.last().map(|glyph: &Glyph| glyph.id) {
                x += font.kern(last, id);
            }
            glyphs.push(id.with_scale_and_position(self.scale, point(x, font.ascent())));
            x += font.h_advance(id);
        }
        (glyphs, x)
    }
}

/// Lays `ink` over a pixel, as far as `coverage` of 0 to 1 says.
fn blend(picture: &mut RgbImage, (x, y): (u32, u32), Rgb(ink): Rgb<u8>, coverage: f32) {
    let Some(Rgb(pixel)) = picture.get_pixel_mut_checked(x, y) else { return };
    for (channel, ink) in pixel.iter_mut().zip(ink) {
        let below = f32::from(*channel);
        *channel = (below + (f32::from(ink) - below) * coverage.clamp(0.0, 1.0)).round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_are_drawn_where_they_are_measured() {
        let letters = Letters::new(24);
        let width = letters.width("stained-glass");
        assert!((100..200).contains(&width), "{width}");
        let mut picture = RgbImage::from_pixel(width + 20, 40, Rgb([255; 3]));
        letters.write(&mut picture, "stained-glass", (10, 5), Rgb([0; 3]));
        let dark: Vec<_> =
            picture.enumerate_pixels().filter(|(_, _, p)| p.0[0] < 128).map(|(x, ..)| x).collect();
        let (least, most) = (dark.iter().min(), dark.iter().max());
        assert!(least.is_some_and(|&x| (9..14).contains(&x)), "{least:?}");
        assert!(most.is_some_and(|&x| x < width + 11 && x + 6 > width), "{most:?} of {width}");
    }

    #[test]
    fn long_names_are_cut() {
        let letters = Letters::new(20);
        let cut = letters.fitted("a-very-long-name-of-a-preset", 100);
        assert!(cut.starts_with("a-ver") && cut.ends_with(ELLIPSIS), "{cut}");
        assert!(letters.width(&cut) <= 100);
        assert_eq!(letters.fitted("bold", 100), "bold");
        assert_eq!(letters.fitted("bold", 3), "");
    }
}
