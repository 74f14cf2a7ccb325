//! Reads the boxes of a HEIF picture (AVIF, HEIC) that ffmpegs, or older ones, ignore: ISO/IEC 23008-12.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Bytes at the start of a file that are searched for boxes.
const HEAD: u64 = 1 << 20;

/// How the primary picture is to be shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Heif {
    /// Quarter turns against the clock.
    pub(crate) turns: u8,
    /// Mirrored afterwards: top and bottom (`Some(0)`), or left and right (`Some(1)`).
    pub(crate) mirror: Option<u8>,
    /// Whether another picture in the file is its alpha.
    pub(crate) alpha: bool,
    /// Whether its colours are multiplied by its alpha.
    pub(crate) premultiplied: bool,
    /// Whether it is a grid of tiles.
    pub(crate) grid: bool,
}

/// Reads the file `path`; `None` if it is not such a picture.
pub(crate) fn read(path: &Path) -> Option<Heif> {
    let mut head = Vec::new();
    File::open(path).ok()?.take(HEAD).read_to_end(&mut head).ok()?;
    parse(&head)
}

/// A reader of bytes.
#[derive(Clone, Copy)]
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (front, back) = self.0.split_at_checked(count)?;
        self.0 = back;
        Some(front)
    }

    /// A big-endian number of `count` bytes.
    fn number(&mut self, count: usize) -> Option<usize> {
        Some(self.take(count)?.iter().fold(0, |value, &byte| value << 8 | usize::from(byte)))
    }

    /// The next box: its name and contents, which may be truncated.
    fn next(&mut self) -> Option<([u8; 4], Bytes<'a>)> {
        let (mut size, mut head) = (self.number(4)?, 8);
        let name = self.take(4)?.try_into().ok()?;
        if size == 1 {
            (size, head) = (self.number(8)?, 16);
        }
        let length = if size == 0 { self.0.len() } else { size.checked_sub(head)? };
        Some((name, Bytes(self.take(length.min(self.0.len()))?)))
    }

    /// The first box called `name`.
    fn find(mut self, name: &[u8; 4]) -> Option<Bytes<'a>> {
        std::iter::from_fn(|| self.next()).find_map(|(own, inner)| (own == *name).then_some(inner))
    }

    /// Version and flags of a full box.
    fn version(&mut self) -> Option<(usize, usize)> {
        Some((self.number(1)?, self.number(3)?))
    }
}

fn parse(head: &[u8]) -> Option<Heif> {
    let file = Bytes(head);
    file.find(b"ftyp")?;
    let mut meta = file.find(b"meta")?;
    meta.version()?;
    let mut primary = meta.find(b"pitm")?;
    let (version, _) = primary.version()?;
    let primary = primary.number(if version == 0 { 2 } else { 4 })?;
    let mut heif = Heif {
        grid: kind_of(meta, primary) == Some(*b"grid"),
        premultiplied: is_premultiplied(meta),
        ..Heif::default()
    };
    let properties = meta.find(b"iprp")?;
    let mut list = properties.find(b"ipco")?;
    let list: Vec<_> = std::iter::from_fn(|| list.next()).collect();
    for (item, index) in associations(properties.find(b"ipma")?)? {
        let Some((name, mut value)) = index.checked_sub(1).and_then(|i| list.get(i)).copied()
        else {
            continue;
        };
        match (&name, item == primary) {
            (b"irot", true) => heif.turns = value.number(1)? as u8 & 3,
            (b"imir", true) => heif.mirror = Some(value.number(1)? as u8 & 1),
            (b"auxC", _) => heif.alpha |= value.0.windows(5).any(|word| word == b"alpha"),
            _ => {}
        }
    }
    Some(heif)
}

/// Whether one picture refers to another by `prem`.
fn is_premultiplied(meta: Bytes) -> bool {
    let found = || {
        let mut references = meta.find(b"iref")?;
        references.version()?;
        references.find(b"prem")
    };
    found().is_some()
}

/// The type of picture number `wanted`.
fn kind_of(meta: Bytes, wanted: usize) -> Option<[u8; 4]> {
    let mut list = meta.find(b"iinf")?;
    let (version, _) = list.version()?;
    list.number(if version == 0 { 2 } else { 4 })?;
    while let Some((name, mut entry)) = list.next() {
        let (version, _) = entry.version()?;
        if name != *b"infe" || version < 2 {
            continue;
        }
        let number = entry.number(if version == 2 { 2 } else { 4 })?;
        entry.take(2)?;
        if number == wanted {
            return entry.take(4)?.try_into().ok();
        }
    }
    None
}

/// The properties of each picture, counted from 1.
fn associations(mut list: Bytes) -> Option<Vec<(usize, usize)>> {
    let (version, flags) = list.version()?;
    let mut found = Vec::new();
    for _ in 0..list.number(4)? {
        let item = list.number(if version == 0 { 2 } else { 4 })?;
        for _ in 0..list.number(1)? {
            // The highest bit marks properties that a reader must support.
            let (bytes, mask) = if flags & 1 == 1 { (2, 0x7FFF) } else { (1, 0x7F) };
            found.push((item, list.number(bytes)? & mask));
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxed(name: &[u8; 4], contents: &[u8]) -> Vec<u8> {
        let mut out = (contents.len() as u32 + 8).to_be_bytes().to_vec();
        out.extend(name);
        out.extend(contents);
        out
    }

    /// A picture of `kind` with a rotation, a mirror axis, and a second picture that is its transparency.
    fn picture(kind: &[u8; 4]) -> Vec<u8> {
        let entry = |id: u8, kind: &[u8; 4]| {
            boxed(b"infe", &[&[2, 0, 0, 0, 0, id, 0, 0][..], kind, &[0]].concat())
        };
        let items = [&[0, 0, 0, 0, 0, 2][..], &entry(1, kind), &entry(2, b"av01")].concat();
        let aux = [&[0; 4][..], b"urn:mpeg:mpegB:cicp:systems:auxiliary:alpha\0"].concat();
        let list = [boxed(b"irot", &[3]), boxed(b"imir", &[1]), boxed(b"auxC", &aux)].concat();
        let links = [0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 2, 0x81, 0x82, 0, 2, 1, 3];
        let properties = [boxed(b"ipco", &list), boxed(b"ipma", &links)].concat();
        let meta = [
            vec![0; 4],
            boxed(b"pitm", &[0, 0, 0, 0, 0, 1]),
            boxed(b"iinf", &items),
            boxed(b"iprp", &properties),
        ];
        [boxed(b"ftyp", b"avif\0\0\0\0"), boxed(b"meta", &meta.concat())].concat()
    }

    #[test]
    fn rotation_alpha_and_tiles_are_found() {
        let wanted = Heif { turns: 3, mirror: Some(1), alpha: true, ..Heif::default() };
        assert_eq!(parse(&picture(b"av01")), Some(wanted));
        assert_eq!(parse(&picture(b"grid")), Some(Heif { grid: true, ..wanted }));
        assert_eq!(parse(&boxed(b"ftyp", b"isom")), None);
    }

    #[test]
    fn what_is_cut_short_is_no_panic() {
        let whole = picture(b"av01");
        for length in 0..whole.len() {
            let _ = parse(&whole[..length]);
        }
    }
}
