//! Reads the tags of a TIFF that change its pixels, and refuses those that are not supported (TIFF 6.0).

use std::io::{BufRead, Seek};

use tiff::decoder::{ChunkType, Decoder, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::limit::{Limit, METADATA};
use super::profile::{ColourSpace, Primaries};
use super::tiff_samples::{Meaning, Samples, Stored};
use crate::geom::Size;

/// The meaning of a TIFF's tags.
#[derive(Default)]
pub(super) struct Tags {
    /// The meaning of the fourth sample of a colour, or the second of a gray.
    pub(super) extra: Extra,
    /// The colour space, if it is not sRGB by default.
    pub(super) space: Option<ColourSpace>,
    /// Whether the picture is gray.
    pub(super) gray: bool,
    /// The orientation of the picture (tag Orientation).
    pub(super) orientation: u8,
    /// The picture, if the `image` crate does not read it rightly.
    pub(super) samples: Option<Samples>,
}

/// The meaning of a sample beyond the colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Extra {
    /// Straight alpha.
    #[default]
    Alpha,
    /// Alpha with premultiplied colours.
    Premultiplied,
    /// Not alpha.
    Other,
}

/// Tags without a name in the crate.
const THRESHHOLDING: u16 = 263;
const FILL_ORDER: u16 = 266;
const TRANSFER_FUNCTION: u16 = 301;
const WHITE_POINT: u16 = 318;
const PRIMARY_CHROMATICITIES: u16 = 319;
const INK_SET: u16 = 332;
const YCBCR_COEFFICIENTS: u16 = 529;
const REFERENCE_BLACK_WHITE: u16 = 532;

/// Reads the tags of the first picture of the TIFF in `reader`. `again` reads the same file.
///
/// # Errors
/// The message for an unsupported tag. Broken files are left to the decoder.
pub(super) fn read<R: BufRead + Seek + 'static>(
    reader: R,
    again: R,
    limit: Limit,
) -> Result<Tags, String> {
    let mut limits = Limits::default();
    limits.ifd_value_size = METADATA as usize;
    limits.decoding_buffer_size = usize::try_from(limit.0).unwrap_or(usize::MAX);
    let Ok(decoder) = Decoder::new(reader) else { return Ok(Tags::default()) };
    let mut file = File(decoder.with_limits(limits.clone()));
    file.refuse()?;
    let stored = file.stored();
    let colour = file.0.colortype().ok();
    let gray = matches!(colour, Some(ColorType::Gray(_) | ColorType::GrayA(_)))
        || stored.as_ref().is_some_and(|s| matches!(s.meaning, Meaning::Gray { .. }));
    let cmyk = matches!(colour, Some(ColorType::CMYK(_) | ColorType::CMYKA(_)));
    let space = if cmyk { None } else { file.colour_space() };
    let (extra, orientation) =
        (file.extra(), file.number(Tag::Orientation).unwrap_or(1).min(255) as u8);
    let samples = stored.and_then(|stored| Samples::new(again, stored, limits));
    Ok(Tags { extra, space, gray, orientation, samples })
}

/// Whether the TIFF that `reader` reads has another page, which is no smaller copy of the first.
pub(super) fn has_pages<R: BufRead + Seek>(reader: R) -> bool {
    let page = || {
        let mut decoder = Decoder::new(reader)?;
        if !decoder.more_images() {
            return Ok(false);
        }
        decoder.next_image()?;
        let kind = decoder.find_tag_unsigned::<u32>(Tag::NewSubfileType)?;
        Ok::<_, TiffError>(kind.unwrap_or(0) & 1 == 0)
    };
    page().unwrap_or(false)
}

struct File<R: BufRead + Seek>(Decoder<R>);

impl<R: BufRead + Seek> File<R> {
    /// The values of a tag that are whole numbers.
    fn numbers(&mut self, tag: Tag) -> Vec<u64> {
        self.0.find_tag_unsigned_vec::<u64>(tag).ok().flatten().unwrap_or_default()
    }

    fn number(&mut self, tag: Tag) -> Option<u64> {
        self.numbers(tag).first().copied()
    }

    fn fractions(&mut self, tag: u16) -> Vec<f32> {
        self.0.get_tag_f32_vec(Tag::Unknown(tag)).unwrap_or_default()
    }

    /// Refuses pictures that would be decoded wrongly.
    fn refuse(&mut self) -> Result<(), String> {
        let refuse = |what: &str| {
            Err(format!("this kind of TIFF is not supported ({what}); save it as 8-bit PNG first"))
        };
        if self.number(Tag::Unknown(FILL_ORDER)).is_some_and(|order| order != 1) {
            return refuse("its bits are stored in reverse, FillOrder 2");
        }
        let photometric = self.number(Tag::PhotometricInterpretation);
        if photometric == Some(5)
            && self.number(Tag::Unknown(INK_SET)).is_some_and(|inks| inks != 1)
        {
            return refuse("its inks are not CMYK, InkSet 2");
        }
        if photometric == Some(4) {
            return refuse("it is a transparency mask");
        }
        if self.number(Tag::Unknown(THRESHHOLDING)).is_some_and(|kind| kind > 3) {
            return refuse("an unknown Threshholding");
        }
        let range = self.fractions(REFERENCE_BLACK_WHITE);
        let full = [0.0, 255.0];
        if photometric == Some(2) && !range.is_empty() && range.chunks(2).any(|pair| pair != full) {
            return refuse("its black and white are not 0 and 255, ReferenceBlackWhite");
        }
        let jpeg = [0.0, 255.0, 128.0, 255.0, 128.0, 255.0];
        if photometric == Some(6) && !range.is_empty() && range != jpeg {
            return refuse("its black and white are not JPEG's, ReferenceBlackWhite");
        }
        let luma = self.fractions(YCBCR_COEFFICIENTS);
        let usual = |luma: &[f32]| {
            luma.iter().zip([0.299, 0.587, 0.114]).all(|(a, b): (_, f32)| (a - b).abs() < 0.002)
        };
        if photometric == Some(6) && !usual(&luma) {
            return refuse("its luma is not that of BT.601, YCbCrCoefficients");
        }
        Ok(())
    }

    fn extra(&mut self) -> Extra {
        match self.numbers(Tag::ExtraSamples).as_slice() {
            [1, ..] => Extra::Premultiplied,
            [0, ..] => Extra::Other,
            // A sample more without the tag is taken as alpha, as most files mean it.
            _ => Extra::Alpha,
        }
    }

    /// The ICC profile, or the curves and primaries of the tags.
    fn colour_space(&mut self) -> Option<ColourSpace> {
        if let Ok(icc) = self.0.get_tag_u8_vec(Tag::IccProfile) {
            return Some(ColourSpace::Icc(icc));
        }
        let primaries = self.primaries();
        let values = self.numbers(Tag::Unknown(TRANSFER_FUNCTION));
        let values: Vec<u16> = values.iter().map(|&v| v.min(65535) as u16).collect();
        let bits = self.number(Tag::BitsPerSample).unwrap_or(1).min(16);
        let curves: Vec<_> = values.chunks_exact(1 << bits).map(<[u16]>::to_vec).collect();
        match (curves.len(), primaries) {
            (1 | 3, primaries) => Some(ColourSpace::Curves { curves, primaries }),
            (_, Some(_)) => Some(ColourSpace::Gamma { gamma: None, primaries }),
            _ => None,
        }
    }

    fn primaries(&mut self) -> Option<Primaries> {
        let points = self.fractions(PRIMARY_CHROMATICITIES);
        let &[rx, ry, gx, gy, bx, by] = points.as_slice() else { return None };
        let white = match self.fractions(WHITE_POINT).as_slice() {
            &[x, y] => [x, y],
            _ => [0.3127, 0.329],
        };
        let possible = |&[x, y]: &[f32; 2]| x > 0.0 && y > 0.0 && x + y <= 1.0;
        let primaries = Primaries { white, red: [rx, ry], green: [gx, gy], blue: [bx, by] };
        [white, primaries.red, primaries.green].iter().all(possible).then_some(primaries)
    }

    /// How the samples are stored, if the `image` crate refuses them or reads them wrongly.
    fn stored(&mut self) -> Option<Stored> {
        let (width, height) = self.0.dimensions().ok()?;
        let bits = self.numbers(Tag::BitsPerSample);
        let bits = if bits.is_empty() { vec![1] } else { bits };
        let &bits_of_one = bits.first()?;
        if bits.iter().any(|&b| b != bits_of_one) {
            return None;
        }
        let channels = self.number(Tag::SamplesPerPixel).unwrap_or(1);
        let planar = channels > 1 && self.number(Tag::PlanarConfiguration) == Some(2);
        let tile = (self.0.get_chunk_type() == ChunkType::Tile).then(|| {
            let (width, height) = self.0.chunk_dimensions();
            Size::new(width, height)
        });
        let lzw = self.number(Tag::Compression) == Some(5);
        let odd_tiles = tile.is_some() && (planar || lzw);
        let meaning = self.meaning(bits_of_one, channels, planar, odd_tiles)?;
        let formats = self.numbers(Tag::SampleFormat);
        let is_whole = formats.iter().all(|&format| format == 1);
        let is_float = bits_of_one == 32 && formats.iter().all(|&format| format == 3);
        if !(is_whole || is_float && odd_tiles && meaning == Meaning::Colour) {
            return None;
        }
        Some(Stored {
            size: Size::new(width, height),
            meaning,
            channels: usize::try_from(channels).ok()?,
            bits: bits_of_one as u8,
            planar,
            tile,
        })
    }

    /// What samples mean that the `image` crate refuses or reads wrongly: those in `odd_tiles`, for one.
    fn meaning(
        &mut self,
        bits: u64,
        channels: u64,
        planar: bool,
        odd_tiles: bool,
    ) -> Option<Meaning> {
        let odd_gray = channels > 1 || odd_tiles || matches!(bits, 2 | 4 | 32);
        let jpeg = self.number(Tag::Compression) == Some(7);
        match (self.number(Tag::PhotometricInterpretation)?, bits) {
            // The decoder of JPEG knows no two components.
            (0 | 1, _) if jpeg && channels > 1 && !planar => None,
            (kind @ (0 | 1), 1 | 2 | 4 | 8 | 16 | 32) if odd_gray => {
                Some(Meaning::Gray { is_inverted: kind == 0 })
            }
            (2, 8 | 16 | 32) if (3..=5).contains(&channels) && (odd_tiles || bits == 32) => {
                Some(Meaning::Colour)
            }
            (3, 1 | 2 | 4 | 8) => Some(Meaning::Palette(self.palette(1 << bits)?)),
            (5, 8 | 16) if channels == 4 && (planar || odd_tiles) => Some(Meaning::Cmyk),
            // Of other compressions chroma may be subsampled.
            (6, 8) if jpeg && channels == 3 && !planar => Some(Meaning::YCbCr),
            _ => None,
        }
    }

    /// The colours of the palette.
    fn palette(&mut self, count: usize) -> Option<Vec<[u8; 3]>> {
        let values = self.numbers(Tag::ColorMap);
        if values.len() < 3 * count {
            return None;
        }
        // Some old files have values of 8 bits, as libtiff knows.
        let most = if values.iter().all(|&v| v < 256) { 255 } else { 65535 };
        let value = |i: usize| ((values[i].min(most) * 255 + most / 2) / most) as u8;
        Some((0..count).map(|i| [i, count + i, 2 * count + i].map(value)).collect())
    }
}

/// Converts premultiplied colours to straight ones.
pub(super) fn unpremultiply(pixels: &mut [[u8; 4]]) {
    for pixel in pixels.iter_mut().filter(|pixel| pixel[3] != 255) {
        let alpha = u32::from(pixel[3]);
        let undone = |v: u8| match alpha {
            0 => 0,
            _ => ((u32::from(v) * 255 + alpha / 2) / alpha).min(255) as u8,
        };
        *pixel = [undone(pixel[0]), undone(pixel[1]), undone(pixel[2]), pixel[3]];
    }
}

/// As [`unpremultiply`], for pixels of `channels` samples of 16 bits, of which the last is alpha.
pub(super) fn unpremultiply_deep(samples: &mut [u16], channels: usize) {
    for pixel in samples.chunks_exact_mut(channels) {
        let Some((&mut alpha, colours)) = pixel.split_last_mut() else { continue };
        let alpha = u64::from(alpha);
        for v in colours {
            let undone = (u64::from(*v) * 65535 + alpha / 2).checked_div(alpha);
            *v = undone.unwrap_or(0).min(65535) as u16;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn premultiplied_colours_of_16_bits_come_back() {
        let mut samples = [26985, 6425, 5140, 32896, 7, 8, 9, 65535, 3, 2, 1, 0];
        unpremultiply_deep(&mut samples, 4);
        assert_eq!(samples, [53759, 12800, 10240, 32896, 7, 8, 9, 65535, 0, 0, 0, 0]);
        let mut gray = [2, 3, 9, 3];
        unpremultiply_deep(&mut gray, 2);
        assert_eq!(gray, [43690, 3, 65535, 3]);
    }

    #[test]
    fn premultiplied_colours_come_back() {
        let mut pixels = [[105, 25, 20, 128], [7, 8, 9, 255], [3, 2, 1, 0]];
        unpremultiply(&mut pixels);
        assert_eq!(pixels, [[209, 50, 40, 128], [7, 8, 9, 255], [0; 4]]);
    }
}
