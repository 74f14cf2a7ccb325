//! GIFs: of each frame only the rectangle that changed.

use std::borrow::Cow;
use std::collections::HashMap;

use ::gif::{DisposalMethod, Encoder, Frame, Repeat};
use color_quant::NeuQuant;
use wasm_bindgen::prelude::*;

use crate::area::Area;
use crate::error::{Error, Result};

/// Colours of a frame; the last index means "transparent".
const MOST: usize = 255;
const CLEAR: u8 = MOST as u8;
/// Pixels with a smaller alpha become transparent.
const THRESHOLD: u8 = 128;

/// A GIF being written. Pictures should have hard edges: colours are few then.
#[wasm_bindgen]
pub struct Gif {
    encoder: Encoder<Vec<u8>>,
    width: u16,
    height: u16,
    alpha: bool,
    /// What is seen: colours of the palette, and nothing where it is transparent.
    shown: Vec<Option<[u8; 3]>>,
}

#[wasm_bindgen]
impl Gif {
    /// A GIF of this size; `plays` is how often it is shown, 0 for ever; with `alpha`, frames may be transparent.
    ///
    /// # Errors
    /// When a side is larger than a GIF can have.
    #[wasm_bindgen(constructor)]
    pub fn new(
        width: u32,
        height: u32,
        plays: u32,
        alpha: bool,
    ) -> std::result::Result<Self, JsError> {
        Ok(Self::of(width, height, plays, alpha)?)
    }

    /// Adds a frame that is shown for `hundredths` of a second.
    ///
    /// # Errors
    /// When its size is wrong.
    pub fn push(&mut self, rgba: &[u8], hundredths: u16) -> std::result::Result<(), JsError> {
        Ok(self.add(rgba, hundredths)?)
    }

    /// The whole file.
    ///
    /// # Errors
    /// When there is no frame.
    pub fn finish(self) -> std::result::Result<Vec<u8>, JsError> {
        Ok(self.end()?)
    }
}

impl Gif {
    fn of(width: u32, height: u32, plays: u32, alpha: bool) -> Result<Self> {
        let side = |side: u32| {
            let large = || Error::file("a GIF's sides have at most 65535 pixels");
            u16::try_from(side).map_err(|_| large())
        };
        let (width, height) = (side(width)?, side(height)?);
        let mut encoder = Encoder::new(Vec::new(), width, height, &[]).map_err(Error::file)?;
        let repeat = match plays {
            0 => Repeat::Infinite,
            n => Repeat::Finite(u16::try_from(n - 1).unwrap_or(u16::MAX)),
        };
        if plays != 1 {
            encoder.set_repeat(repeat).map_err(Error::file)?;
        }
        Ok(Self { encoder, width, height, alpha, shown: Vec::new() })
    }

    fn add(&mut self, rgba: &[u8], hundredths: u16) -> Result<()> {
        let (pixels, _) = rgba.as_chunks::<4>();
        let (width, height) = (usize::from(self.width), usize::from(self.height));
        if pixels.len() != width * height {
            return Err(Error::file("a frame has another size than the first one"));
        }
        let (mut table, numbers) = palette(pixels);
        table.resize(MOST + 1, [0; 3]);
        let mut drawn = Vec::with_capacity(pixels.len());
        // Triangles are runs of one colour.
        for run in pixels.chunk_by(|a, b| a == b) {
            let number = key(run[0]).map_or(CLEAR, |key| numbers[&key]);
            drawn.resize(drawn.len() + run.len(), number);
        }
        let colour = |&number: &u8| (number != CLEAR).then(|| table[usize::from(number)]);
        let next: Vec<Option<[u8; 3]>> = drawn.iter().map(colour).collect();
        // A transparent pixel can only come of a frame that is cleared: those are drawn whole.
        let area = if self.alpha || self.shown.is_empty() {
            Area { x: 0, y: 0, width, height }
        } else {
            let pairs = drawn.iter_mut().zip(&next).zip(&self.shown);
            pairs
                .filter(|((_, next), shown)| next == shown)
                .for_each(|((drawn, _), _)| *drawn = CLEAR);
            Area::changed(width, height, |i| drawn[i] == CLEAR)
        };
        let frame = Frame {
            delay: hundredths,
            dispose: if self.alpha { DisposalMethod::Background } else { DisposalMethod::Keep },
            transparent: Some(CLEAR),
            left: area.x as u16,
            top: area.y as u16,
            width: area.width as u16,
            height: area.height as u16,
            palette: Some(table.into_flattened()),
            buffer: Cow::Owned(area.of(&drawn, width)),
            ..Frame::default()
        };
        self.encoder.write_frame(&frame).map_err(Error::file)?;
        self.shown = next;
        Ok(())
    }

    fn end(self) -> Result<Vec<u8>> {
        if self.shown.is_empty() {
            return Err(Error::file("an animation needs a frame"));
        }
        self.encoder.into_inner().map_err(Error::file)
    }
}

/// The colour of a pixel that is seen.
fn key([r, g, b, a]: [u8; 4]) -> Option<[u8; 3]> {
    (a >= THRESHOLD).then_some([r, g, b])
}

/// At most [`MOST`] colours, and which of them stands for each colour of `pixels`.
fn palette(pixels: &[[u8; 4]]) -> (Vec<[u8; 3]>, HashMap<[u8; 3], u8>) {
    let mut counts: HashMap<[u8; 3], usize> = HashMap::new();
    for run in pixels.chunk_by(|a, b| a == b) {
        if let Some(key) = key(run[0]) {
            *counts.entry(key).or_default() += run.len();
        }
    }
    let mut colours: Vec<[u8; 3]> = counts.keys().copied().collect();
    colours.sort_unstable();
    if colours.len() <= MOST {
        let numbers = colours.iter().zip(0..).map(|(&colour, number)| (colour, number)).collect();
        return (if colours.is_empty() { vec![[0; 3]] } else { colours }, numbers);
    }
    let palette = learned(pixels);
    let number = |colour: &[u8; 3]| (*colour, nearest(&palette, *colour));
    let numbers = colours.iter().map(number).collect();
    (palette, numbers)
}

/// A palette of the colours of some 60,000 pixels.
fn learned(pixels: &[[u8; 4]]) -> Vec<[u8; 3]> {
    let step = (pixels.len() / 60_000).max(1);
    let some: Vec<[u8; 4]> = pixels
        .iter()
        .step_by(step)
        .filter_map(|&pixel| key(pixel))
        .map(|[r, g, b]| [r, g, b, 255])
        .collect();
    let map = NeuQuant::new(3, MOST, some.as_flattened()).color_map_rgb();
    map.as_chunks::<3>().0.to_vec()
}

fn nearest(palette: &[[u8; 3]], colour: [u8; 3]) -> u8 {
    let distance = |other: &[u8; 3]| -> i32 {
        let apart = |i: usize| i32::from(other[i]) - i32::from(colour[i]);
        (0..3).map(|i| apart(i) * apart(i)).sum()
    };
    (0u8..).zip(palette).min_by_key(|(_, other)| distance(other)).map_or(0, |(number, _)| number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(file: &[u8]) -> Vec<Vec<[u8; 4]>> {
        let mut options = ::gif::DecodeOptions::new();
        options.set_color_output(::gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(file).expect("a GIF");
        let width = usize::from(decoder.width());
        let mut canvas = vec![[0; 4]; width * usize::from(decoder.height())];
        let mut frames = Vec::new();
        while let Some(frame) = decoder.read_next_frame().expect("a frame") {
            let (left, top) = (usize::from(frame.left), usize::from(frame.top));
            let before = canvas.clone();
            for (i, pixel) in frame.buffer.as_chunks::<4>().0.iter().enumerate() {
                if pixel[3] > 0 {
                    let (x, y) = (i % usize::from(frame.width), i / usize::from(frame.width));
                    canvas[(top + y) * width + left + x] = *pixel;
                }
            }
            frames.push(canvas.clone());
            if frame.dispose == DisposalMethod::Background {
                canvas = before;
                canvas.fill([0; 4]);
            }
        }
        frames
    }

    #[test]
    fn few_colours_come_back_exactly() {
        for alpha in [false, true] {
            let mut pixels: Vec<[u8; 4]> = (0..48).map(|i| [i, 5 * i, 100, 255]).collect();
            let mut gif = Gif::of(8, 6, 0, alpha).expect("a size");
            let mut wanted = Vec::new();
            for i in 0..4u8 {
                pixels[usize::from(i) * 7] = [200, i, 1, 255];
                if alpha {
                    pixels[usize::from(i)] = [0; 4];
                }
                gif.add(pixels.as_flattened(), 7).expect("a frame");
                wanted.push(pixels.clone());
            }
            assert_eq!(decoded(&gif.end().expect("frames")), wanted, "{alpha}");
        }
    }

    #[test]
    fn many_colours_come_back_nearly() {
        let pixels: Vec<[u8; 4]> = (0..128u32 * 128)
            .map(|i| [(i % 128 * 2) as u8, (i / 128 * 2) as u8, 90, 255])
            .collect();
        let mut gif = Gif::of(128, 128, 0, false).expect("a size");
        gif.add(pixels.as_flattened(), 7).expect("a frame");
        let back = decoded(&gif.end().expect("a frame"));
        let off = |a: &[u8; 4], b: &[u8; 4]| (0..3).map(|i| a[i].abs_diff(b[i])).max();
        let worst = pixels.iter().zip(&back[0]).filter_map(|(a, b)| off(a, b)).max();
        assert!(worst < Some(40), "{worst:?}");
    }
}
