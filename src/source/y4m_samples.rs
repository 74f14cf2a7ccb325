//! Samples of y4m, by its names of colour spaces: planes of 8 bits as they are, deeper ones and 4:1:1 converted to such.

use crate::colour::{Layout, Sampling, Siting};
use crate::geom::Size;

/// How samples are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Samples {
    /// Bits of a sample; more than 8 take two bytes, the lower first.
    bits: u32,
    /// Whether chroma has a quarter of the columns: it becomes 4:2:2.
    is_quarter: bool,
}

/// What the colour space `name` means.
pub(super) fn parse(name: &str) -> Option<(Samples, Sampling, Siting, bool)> {
    use Sampling::{Gray, Yuv420, Yuv422, Yuv444};
    // Deeper ones end in p10 and the like, but grey in the number alone.
    let deep = name.rsplit_once('p').or_else(|| Some(("mono", name.strip_prefix("mono")?)));
    let deep = deep.and_then(|(base, bits)| Some((base, bits.parse::<u32>().ok()?)));
    let (base, bits) = deep.filter(|(_, bits)| (9..=16).contains(bits)).unwrap_or((name, 8));
    let (sampling, siting, alpha) = match base {
        "420" if bits > 8 => (Yuv420, Siting::Left, false),
        "420" | "420jpeg" => (Yuv420, Siting::Centre, false),
        "420mpeg2" | "420paldv" => (Yuv420, Siting::Left, false),
        "422" | "411" => (Yuv422, Siting::Left, false),
        "444" => (Yuv444, Siting::Left, false),
        "444alpha" => (Yuv444, Siting::Left, true),
        "mono" => (Gray, Siting::Left, false),
        _ => return None,
    };
    let is_quarter = base == "411";
    (!is_quarter || bits == 8).then_some((Samples { bits, is_quarter }, sampling, siting, alpha))
}

impl Samples {
    /// Whether they are planes of 8 bits already.
    pub(super) fn is_plain(&self) -> bool {
        self.bits == 8 && !self.is_quarter
    }

    /// Bytes of a frame whose planes become `layout`.
    pub(super) fn bytes(&self, layout: &Layout) -> usize {
        let bytes = if self.bits > 8 { 2 } else { 1 };
        if !self.is_quarter {
            return bytes * layout.bytes();
        }
        let Size { width, height } = layout.size;
        (width + 2 * width.div_ceil(4)) as usize * height as usize
    }

    /// Makes the planes of `layout`, of the `full` range or not, from the bytes of a frame, in `out`.
    pub(super) fn convert(&self, layout: &Layout, full: bool, raw: &[u8], out: &mut Vec<u8>) {
        out.clear();
        if self.bits > 8 {
            let most = (1u32 << self.bits) - 1;
            let shift = self.bits - 8;
            let narrow = |&[low, high]: &[u8; 2]| {
                let value = u32::from(u16::from_le_bytes([low, high])).min(most);
                let narrow = if full {
                    (value * 255 + most / 2) / most
                } else {
                    (value + (1 << (shift - 1))) >> shift
                };
                narrow.min(255) as u8
            };
            out.extend(raw.as_chunks::<2>().0.iter().map(narrow));
            return;
        }
        let luma = layout.size.pixels();
        out.extend_from_slice(&raw[..luma]);
        let (wide, narrow) = (layout.chroma().0, layout.size.width.div_ceil(4) as usize);
        for row in raw[luma..].chunks(narrow) {
            // Samples stand at every fourth column of luma; those between are the mean of their neighbours.
            out.extend((0..wide).map(|x| {
                let (left, right) = (row[x / 2], row[x.div_ceil(2).min(narrow - 1)]);
                u16::midpoint(left.into(), right.into()) as u8
            }));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converted(name: &str, size: Size, full: bool, raw: &[u8]) -> Vec<u8> {
        let (samples, sampling, siting, alpha) = parse(name).expect(name);
        let layout = Layout { size, sampling, siting, alpha };
        assert_eq!(samples.bytes(&layout), raw.len(), "{name}");
        let mut out = Vec::new();
        samples.convert(&layout, full, raw, &mut out);
        assert_eq!(out.len(), layout.bytes(), "{name}");
        out
    }

    #[test]
    fn deep_samples_are_rounded() {
        let raw: Vec<u8> =
            [64u16, 940, 1023, 65535].iter().flat_map(|value| value.to_le_bytes()).collect();
        assert_eq!(converted("mono10", Size::new(4, 1), false, &raw), [16, 235, 255, 255]);
        assert_eq!(converted("mono10", Size::new(4, 1), true, &raw), [16, 234, 255, 255]);
        assert!(parse("420p10").is_some_and(|(samples, ..)| !samples.is_plain()));
        assert!(parse("420paldv").is_some_and(|(samples, ..)| samples.is_plain()));
        assert!(parse("410").is_none() && parse("411p10").is_none() && parse("420p8").is_none());
    }

    #[test]
    fn chroma_of_quarter_columns_is_interpolated() {
        let raw = [1, 2, 3, 4, 5, 6, 100, 200, 50, 60];
        let got = converted("411", Size::new(6, 1), false, &raw);
        assert_eq!(got, [1, 2, 3, 4, 5, 6, 100, 150, 200, 50, 55, 60]);
    }
}
