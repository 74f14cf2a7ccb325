//! Reads the tags of a TIFF that change its pixels, and refuses those that are not supported (TIFF 6.0).

use std::io::{BufRead, Seek};

use image::error::{DecodingError, LimitError, LimitErrorKind};
use image::{ImageError, ImageFormat};
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError, TiffResult};

use super::limit::{Limit, METADATA};
use super::profile::{ColourSpace, Primaries};
use crate::frame::Rgba;
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
    /// A gray picture of few bits, which is decoded here.
    pub(super) few_bits: Option<FewBits>,
}

/// A gray picture of 2 or 4 bits, which the `image` crate does not read.
pub(super) struct FewBits {
    decode: Box<dyn FnOnce() -> TiffResult<DecodingResult>>,
    size: Size,
    bits: u8,
}

impl FewBits {
    /// Width and height as stored.
    pub(super) fn size(&self) -> Size {
        self.size
    }

    /// Decodes the picture.
    ///
    /// # Errors
    /// When it is broken or ends too early.
    pub(super) fn decode(self) -> Result<Vec<Rgba>, ImageError> {
        let DecodingResult::U8(bytes) = (self.decode)().map_err(fault)? else {
            return Err(fault(TiffError::LimitsExceeded));
        };
        let (width, bits) = (self.size.width as usize, usize::from(self.bits));
        let mask = (1usize << bits) - 1;
        let mut pixels = Vec::with_capacity(self.size.pixels());
        for row in bytes.chunks((width * bits).div_ceil(8)).take(self.size.height as usize) {
            pixels.extend((0..width).map(|x| {
                // Rows are packed from the highest bit.
                let byte = row.get(x * bits / 8).copied().unwrap_or(0);
                let value = usize::from(byte) >> (8 - bits - x * bits % 8) & mask;
                let gray = (value * 255 / mask) as u8;
                [gray, gray, gray, 255]
            }));
        }
        pixels.resize(self.size.pixels(), [0, 0, 0, 255]);
        Ok(pixels)
    }
}

/// A fault of the decoder as one of the `image` crate, for its words.
fn fault(error: TiffError) -> ImageError {
    match error {
        TiffError::IoError(e) => ImageError::IoError(e),
        TiffError::LimitsExceeded => {
            ImageError::Limits(LimitError::from_kind(LimitErrorKind::InsufficientMemory))
        }
        e => ImageError::Decoding(DecodingError::new(ImageFormat::Tiff.into(), e)),
    }
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
const REFERENCE_BLACK_WHITE: u16 = 532;

/// Reads the tags of the first picture of the TIFF in `reader`.
///
/// # Errors
/// The message for an unsupported tag. Broken files are left to the decoder.
pub(super) fn read<R: BufRead + Seek + 'static>(reader: R, limit: Limit) -> Result<Tags, String> {
    let mut limits = tiff::decoder::Limits::default();
    limits.ifd_value_size = METADATA as usize;
    limits.decoding_buffer_size = usize::try_from(limit.0).unwrap_or(usize::MAX);
    let Ok(decoder) = Decoder::new(reader) else { return Ok(Tags::default()) };
    let mut file = File(decoder.with_limits(limits));
    file.refuse()?;
    let colour = file.0.colortype().ok();
    let gray = matches!(colour, Some(ColorType::Gray(_) | ColorType::GrayA(_)));
    let cmyk = matches!(colour, Some(ColorType::CMYK(_) | ColorType::CMYKA(_)));
    let space = if cmyk { None } else { file.colour_space() };
    let (extra, orientation) =
        (file.extra(), file.number(Tag::Orientation).unwrap_or(1).min(255) as u8);
    Ok(Tags { extra, space, gray, orientation, few_bits: file.few_bits(colour) })
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
        Ok(())
    }

    fn extra(&mut self) -> Extra {
        match self.numbers(Tag::ExtraSamples).as_slice() {
            [1, ..] => Extra::Premultiplied,
            // Unspecified extra samples are taken as alpha, as most files mean it.
            [0, ..] => Extra::Other,
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

    /// The picture, if it is gray with few bits.
    fn few_bits(mut self, colour: Option<ColorType>) -> Option<FewBits>
    where
        R: 'static,
    {
        let Some(ColorType::Gray(bits @ (2 | 4))) = colour else { return None };
        let (width, height) = self.0.dimensions().ok()?;
        let mut decoder = self.0;
        let decode = Box::new(move || decoder.read_image());
        Some(FewBits { decode, size: Size::new(width, height), bits })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn premultiplied_colours_come_back() {
        let mut pixels = [[105, 25, 20, 128], [7, 8, 9, 255], [3, 2, 1, 0]];
        unpremultiply(&mut pixels);
        assert_eq!(pixels, [[209, 50, 40, 128], [7, 8, 9, 255], [0; 4]]);
    }
}
