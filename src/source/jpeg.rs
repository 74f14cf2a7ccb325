//! JPEG files: what is needed of them is read, up to their end marker, in memory that grows with the file.
//!
//! Markers are those of ITU-T T.81, table B.1.

use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::ops::Range;
use std::path::Path;

use super::detect;
use super::limit::{Limit, METADATA};
use crate::error::{Error, Result};

const END_OF_IMAGE: u8 = 0xd9;
const RESTARTS: std::ops::RangeInclusive<u8> = 0xd0..=0xd7;
const START_OF_IMAGE: u8 = 0xd8;
const START_OF_SCAN: u8 = 0xda;
const TEMPORARY: u8 = 0x01;
const COMMENT: u8 = 0xfe;
const APPLICATIONS: std::ops::RangeInclusive<u8> = 0xe0..=0xef;
/// Baseline, and extended sequential with Huffman coding.
const SEQUENTIAL: std::ops::RangeInclusive<u8> = 0xc0..=0xc1;
/// Headers of frames, among which are three other markers.
const FRAMES: std::ops::RangeInclusive<u8> = 0xc0..=0xcf;
const NO_FRAMES: [u8; 3] = [0xc4, 0xc8, 0xcc];
const JFIF: u8 = 0xe0;
const ADOBE: u8 = 0xee;

/// The bytes of a JPEG that its decoder needs.
#[derive(Debug, Default)]
pub(super) struct Jpeg {
    /// The file without comments, previews and what comes after its end.
    pub(super) bytes: Vec<u8>,
    /// Whether its end marker is there. The decoder does not say.
    pub(super) complete: bool,
    /// Whether it is sequential, with scans of fewer components than the picture has: zune-jpeg decodes many
    /// of these wrongly.
    pub(super) split_scans: bool,
    /// Whether the first component has fewer samples than another one: zune-jpeg decodes these wrongly, too.
    pub(super) is_luma_coarser: bool,
    /// Components of a sequential picture.
    components: u8,
    metadata: u64,
    has_exif: bool,
    is_jfif: bool,
    /// Where Adobe's segment is in `bytes`.
    adobe: Option<Range<usize>>,
}

impl Jpeg {
    /// Reads the JPEG in `path`, or with `header` what comes before its first scan's data.
    ///
    /// # Errors
    /// When it cannot be read, or has more bytes than a quarter of the limit (decoding takes as many again).
    pub(super) fn read(path: &Path, header: bool, limit: Limit) -> Result<Self> {
        let file = BufReader::with_capacity(1 << 16, detect::open(path)?);
        let mut reader = Reader { file, jpeg: Self::default(), most: limit.0 / 4, header };
        match reader.segments() {
            Ok(()) => {}
            Err(e) if e.kind() == ErrorKind::UnexpectedEof => {}
            Err(e) if e.kind() == ErrorKind::FileTooLarge => {
                limit.check_bytes(path, limit.0 + (1 << 20), || "this JPEG".into())?;
            }
            Err(e) => {
                return Err(Error::input(path, format!("cannot be read: {e}")).caused_by(e));
            }
        }
        Ok(reader.jpeg)
    }
}

impl Jpeg {
    /// Takes from the header of a frame (T.81, B.2.2) what a decoder has to know.
    fn frame(&mut self, header: &[u8]) {
        let samples = |component: &[u8]| (component[1] >> 4, component[1] & 15);
        let components = header.get(6..).unwrap_or_default().chunks_exact(3);
        let sampling: Vec<(u8, u8)> = components.map(samples).collect();
        if let [luma, chroma @ ..] = sampling.as_slice() {
            self.is_luma_coarser |= chroma.iter().any(|c| c.0 > luma.0 || c.1 > luma.1);
        }
        // JFIF means Y'CbCr, whatever Adobe's segment says (libjpeg and its users, too); of inks it says nothing.
        if let (true, 3, Some(adobe)) = (self.is_jfif, sampling.len(), self.adobe.take()) {
            self.bytes.drain(adobe);
        }
    }

    /// Appends bytes, as long as they are at most `most` in all.
    fn push(&mut self, bytes: &[u8], most: u64) -> io::Result<()> {
        if (self.bytes.len() + bytes.len()) as u64 > most {
            return Err(ErrorKind::FileTooLarge.into());
        }
        self.bytes.extend_from_slice(bytes);
        Ok(())
    }
}

struct Reader {
    file: BufReader<File>,
    jpeg: Jpeg,
    most: u64,
    header: bool,
}

impl Reader {
    /// Reads segment after segment. An error of the kind `UnexpectedEof` is an end that comes too early.
    fn segments(&mut self) -> io::Result<()> {
        // The data of a scan comes before the next marker, as other bytes between segments do.
        while let Some(marker) = self.next_marker()? {
            match marker {
                END_OF_IMAGE => {
                    self.push(&[0xff, marker])?;
                    self.jpeg.complete = true;
                    return Ok(());
                }
                START_OF_IMAGE | TEMPORARY => self.push(&[0xff, marker])?,
                marker if RESTARTS.contains(&marker) => self.push(&[0xff, marker])?,
                marker => {
                    self.segment(marker)?;
                    if marker == START_OF_SCAN && self.header {
                        return Ok(());
                    }
                }
            }
        }
        Ok(())
    }

    /// Copies bytes up to the next marker, which is read. `ff 00` is a byte of data, and any number of `ff`
    /// may stand before a marker.
    fn next_marker(&mut self) -> io::Result<Option<u8>> {
        loop {
            let bytes = self.file.fill_buf()?;
            if bytes.is_empty() {
                return Ok(None);
            }
            let before = bytes.iter().position(|&b| b == 0xff).unwrap_or(bytes.len());
            let found = before < bytes.len();
            self.jpeg.push(&bytes[..before], self.most)?;
            self.file.consume(before);
            if !found {
                continue;
            }
            let mut marker = 0xff;
            while marker == 0xff {
                marker = self.byte()?;
            }
            if marker != 0 {
                return Ok(Some(marker));
            }
            self.push(&[0xff, 0])?;
        }
    }

    /// Reads a segment that has a length, and keeps it if the decoder needs it.
    fn segment(&mut self, marker: u8) -> io::Result<()> {
        let length = [self.byte()?, self.byte()?];
        // A length counts its own two bytes; less is damage that the decoder reports.
        let bytes = u64::from(u16::from_be_bytes(length)).saturating_sub(2);
        let mut data = Vec::with_capacity(bytes as usize);
        (&mut self.file).take(bytes).read_to_end(&mut data)?;
        if SEQUENTIAL.contains(&marker) {
            // The header of a frame (T.81, B.2.2).
            self.jpeg.components = data.get(5).copied().unwrap_or(0);
        }
        if FRAMES.contains(&marker) && !NO_FRAMES.contains(&marker) {
            self.jpeg.frame(&data);
        }
        if marker == START_OF_SCAN {
            let few = data.first().is_some_and(|&n| n < self.jpeg.components);
            self.jpeg.split_scans |= few;
        }
        if self.is_needed(marker, &data) {
            let begin = self.jpeg.bytes.len();
            self.push(&[0xff, marker, length[0], length[1]])?;
            self.push(&data)?;
            self.jpeg.is_jfif |= marker == JFIF && data.starts_with(b"JFIF\0");
            if marker == ADOBE && data.starts_with(b"Adobe") {
                self.jpeg.adobe = Some(begin..self.jpeg.bytes.len());
            }
        }
        if (data.len() as u64) < bytes {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        Ok(())
    }

    /// Whether a decoder needs the segment: of applications', JFIF's, EXIF, ICC profiles and Adobe's.
    fn is_needed(&mut self, marker: u8, data: &[u8]) -> bool {
        let metadata = match marker {
            // Of several, the first holds.
            0xe1 => {
                data.starts_with(b"Exif\0") && !std::mem::replace(&mut self.jpeg.has_exif, true)
            }
            0xe2 => data.starts_with(b"ICC_PROFILE\0"),
            JFIF | ADOBE => true,
            _ => return marker != COMMENT && !APPLICATIONS.contains(&marker),
        };
        self.jpeg.metadata += data.len() as u64;
        metadata && self.jpeg.metadata <= METADATA
    }

    fn byte(&mut self) -> io::Result<u8> {
        let mut byte = [0];
        self.file.read_exact(&mut byte)?;
        Ok(byte[0])
    }

    fn push(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.jpeg.push(bytes, self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Vec<u8> {
        let image = image::RgbImage::from_fn(64, 48, |x, y| image::Rgb([x as u8 * 3, y as u8, 99]));
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Jpeg).expect("a JPEG");
        bytes.into_inner()
    }

    fn read(bytes: &[u8]) -> Jpeg {
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), bytes).expect("written");
        Jpeg::read(file.path(), false, Limit(1 << 20)).expect("few bytes")
    }

    #[test]
    fn a_jpeg_is_complete_with_its_end_marker_and_at_no_earlier_byte() {
        let whole = picture();
        let jpeg = read(&whole);
        assert!(jpeg.complete && !jpeg.split_scans && jpeg.bytes == whole);
        for length in 0..whole.len() {
            assert!(!read(&whole[..length]).complete, "{length} of {} bytes", whole.len());
        }
        let trailing = [whole.as_slice(), b"a phone appends a video here"].concat();
        assert_eq!(read(&trailing).bytes, whole);
    }

    #[test]
    fn an_end_marker_inside_a_preview_is_not_the_end() {
        let whole = picture();
        // An application segment that holds a small JPEG of its own, as cameras write it.
        let preview = [&[0xff, 0xe1, 0, 8], b"ab\xff\xd8\xff\xd9".as_slice()].concat();
        let with = [&whole[..2], &preview, &whole[2..]].concat();
        let jpeg = read(&with);
        assert!(jpeg.complete && jpeg.bytes == whole, "without the preview");
        assert!(!read(&with[..with.len() - 2]).complete);
    }

    #[test]
    fn of_colours_jfif_says_more_than_adobe() {
        let whole = picture();
        // JFIF's segment is the first.
        let (begin, rest) = whole.split_at(2);
        let (jfif, rest) = rest.split_at(18);
        assert!(jfif.starts_with(b"\xff\xe0\0\x10JFIF\0"));
        let adobe = [&[0xff, 0xee, 0, 14], b"Adobe\0d\0\0\0\0\0".as_slice()].concat();
        let begins = |segments: &[&[u8]]| [begin, &segments.concat(), rest].concat();
        let both = read(&begins(&[jfif, &adobe])).bytes;
        assert_eq!(both, begins(&[jfif]));
        assert_eq!(read(&begins(&[&adobe])).bytes, begins(&[&adobe]));
    }

    #[test]
    fn the_first_of_several_exif_segments_holds() {
        let whole = picture();
        let exif = |n: u8| [&[0xff, 0xe1, 0, 9], b"Exif\0\0".as_slice(), &[n]].concat();
        let with = [&whole[..2], &exif(1), &exif(2), &whole[2..]].concat();
        assert_eq!(read(&with).bytes, [&whole[..2], &exif(1), &whole[2..]].concat());
    }

    #[test]
    fn what_grows_without_end_is_refused() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let whole = picture();
        let (head, end) = whole.split_at(whole.len() - 2);
        std::fs::write(file.path(), [head, &vec![7; 300_000], end].concat()).expect("written");
        let error = Jpeg::read(file.path(), false, Limit(1 << 20)).expect_err("too much");
        assert!(error.to_string().contains("--max-memory"), "{error}");
        // Comments are not kept.
        let comment = [&[0xff, 0xfe, 0xff, 0xff], vec![7; 0xfffd].as_slice()].concat().repeat(20);
        std::fs::write(file.path(), [&whole[..2], &comment, &whole[2..]].concat())
            .expect("written");
        let jpeg = Jpeg::read(file.path(), false, Limit(1 << 20)).expect("it is short");
        assert_eq!(jpeg.bytes, whole);
    }
}
