//! Whether a JPEG is all there: its decoder does not say.
//!
//! Markers are those of ITU-T T.81, table B.1.

const END_OF_IMAGE: u8 = 0xd9;
const RESTARTS: std::ops::RangeInclusive<u8> = 0xd0..=0xd7;
const START_OF_IMAGE: u8 = 0xd8;
const TEMPORARY: u8 = 0x01;

/// Whether `jpeg` reaches its end marker. Bytes after it do not matter.
pub(crate) fn is_complete(jpeg: &[u8]) -> bool {
    let mut at = 0;
    // Each round steps from one marker to the next.
    while let Some((marker, after)) = next_marker(jpeg, at) {
        at = match marker {
            END_OF_IMAGE => return true,
            START_OF_IMAGE | TEMPORARY => after,
            marker if RESTARTS.contains(&marker) => after,
            // A scan's header has a length as other segments have; its data has no markers but
            // restarts inside, so that the search for the next marker passes over it.
            _ => match jpeg.get(after..after + 2) {
                Some(&[high, low]) => {
                    let length = usize::from(u16::from_be_bytes([high, low]));
                    // A length counts its own two bytes; less is damage that the decoder reports.
                    after + length.max(2)
                }
                _ => return false,
            },
        };
    }
    false
}

/// The first marker at or after `at`, and the place after it. `ff 00` is a byte of data, and any
/// number of `ff` may stand before a marker.
fn next_marker(jpeg: &[u8], at: usize) -> Option<(u8, usize)> {
    let mut at = at;
    loop {
        at += jpeg.get(at..)?.iter().position(|&b| b == 0xff)?;
        while *jpeg.get(at)? == 0xff {
            at += 1;
        }
        let marker = jpeg[at];
        at += 1;
        if marker != 0 {
            return Some((marker, at));
        }
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

    #[test]
    fn a_jpeg_is_complete_with_its_end_marker_and_at_no_earlier_byte() {
        let whole = picture();
        assert!(is_complete(&whole));
        for length in 0..whole.len() {
            assert!(!is_complete(&whole[..length]), "{length} of {} bytes", whole.len());
        }
        let trailing = [whole.as_slice(), b"a phone appends a video here"].concat();
        assert!(is_complete(&trailing));
    }

    #[test]
    fn an_end_marker_inside_a_preview_is_not_the_end() {
        let whole = picture();
        // An application segment that holds a small JPEG of its own, as cameras write it.
        let preview = [&[0xff, 0xe1, 0, 8], b"ab\xff\xd8\xff\xd9".as_slice()].concat();
        let with = [&whole[..2], &preview, &whole[2..]].concat();
        assert!(is_complete(&with));
        assert!(!is_complete(&with[..with.len() - 2]));
    }
}
