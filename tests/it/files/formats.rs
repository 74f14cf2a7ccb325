//! Kinds of files that decoders get wrong or leave to their caller.

use std::fs;

use polyreel::frame::{Frame, Rgba};
use polyreel::geom::Size;
use polyreel::source::SourceOptions;

use super::given::*;

/// A frame of an animation: size, place, disposal, blending.
pub(crate) type Part = (Size, (u8, u8), u8, u8);

/// An APNG on a canvas of the first part's size, every frame in one colour (that of [`colour`]); with a hidden
/// default image of black if `hidden`. Samples have 8 bits, or 16.
pub(crate) fn apng(parts: &[Part], depth: u8, hidden: bool) -> Vec<u8> {
    let canvas = parts[0].0;
    let rows = |size: Size, [r, g, b, _]: Rgba| {
        let pixel: Vec<u8> = if depth == 16 { vec![r, r, g, g, b, b] } else { vec![r, g, b] };
        let row = [&[0], pixel.repeat(size.width as usize).as_slice()].concat();
        stored(&row.repeat(size.height as usize))
    };
    let mut chunks: Vec<([u8; 4], Vec<u8>)> = Vec::new();
    let (width, height) = (canvas.width.to_be_bytes(), canvas.height.to_be_bytes());
    chunks.push((*b"IHDR", [&width[..], &height, &[depth, 2, 0, 0, 0]].concat()));
    chunks.push((*b"acTL", [0, 0, 0, parts.len() as u8, 0, 0, 0, 0].to_vec()));
    if hidden {
        chunks.push((*b"IDAT", rows(canvas, [0, 0, 0, 255])));
    }
    let mut number = 0u32;
    for (i, &(size, (x, y), dispose, blend)) in parts.iter().enumerate() {
        let mut control = number.to_be_bytes().to_vec();
        for value in [size.width, size.height, x.into(), y.into()] {
            control.extend(value.to_be_bytes());
        }
        control.extend([0, 1, 0, 10, dispose, blend]);
        chunks.push((*b"fcTL", control));
        number += 1;
        let data = rows(size, colour(i));
        if i == 0 && !hidden {
            chunks.push((*b"IDAT", data));
        } else {
            chunks.push((*b"fdAT", [&number.to_be_bytes()[..], &data].concat()));
            number += 1;
        }
    }
    let chunks: Vec<(&[u8; 4], &[u8])> = chunks.iter().map(|(k, d)| (k, d.as_slice())).collect();
    png(&chunks)
}

/// The colour of frame `i` of [`apng`].
fn colour(i: usize) -> Rgba {
    [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]][i % 3]
}

#[test]
fn a_frame_that_the_background_took_does_not_come_back_in_an_apng() {
    let folder = folder();
    let file = name(&folder, "a.png");
    let (whole, dot) = (Size::new(2, 1), Size::new(1, 1));
    // Cleared after it; then one that leaves what was there before it.
    let parts = [(whole, (0, 0), 1, 0), (dot, (0, 0), 2, 0), (dot, (1, 0), 0, 0)];
    fs::write(&file, apng(&parts, 8, false)).expect("written");
    let frames = read_all(&file).1;
    assert_eq!(frames[0].frame.pixels(), [colour(0), colour(0)]);
    assert_eq!(frames[1].frame.pixels(), [colour(1), [0; 4]]);
    assert_eq!(frames[2].frame.pixels(), [[0; 4], colour(2)]);
}

#[test]
fn apngs_of_16_bits_are_read() {
    let folder = folder();
    let file = name(&folder, "a.png");
    let (whole, dot) = (Size::new(2, 1), Size::new(1, 1));
    let parts = [(whole, (0, 0), 0, 0), (dot, (1, 0), 0, 1)];
    fs::write(&file, apng(&parts, 16, false)).expect("written");
    let frames = read_all(&file).1;
    assert_eq!(frames[1].frame.pixels(), [colour(0), colour(1)]);
}

#[test]
fn a_default_image_that_is_not_part_of_the_animation_is_not_shown() {
    let folder = folder();
    let file = name(&folder, "a.png");
    let whole = (Size::new(2, 1), (0, 0), 0, 0);
    fs::write(&file, apng(&[whole], 8, true)).expect("written");
    let (info, frames) = read_all(&file);
    assert!(info.still && info.frames == Some(1) && info.rate.is_none());
    assert_eq!(frames[0].frame.pixels(), [colour(0); 2]);
    fs::write(&file, apng(&[whole, whole], 8, true)).expect("written");
    let (info, frames) = read_all(&file);
    assert!(!info.still && frames.len() == 2);
    assert_eq!(frames[1].frame.pixels(), [colour(1); 2]);
}

/// A lossy picture of 4x4 pixels in one colour, 250, 220, 30 (by libwebp).
const LOSSY: &[u8] = b"VP8 4\0\0\0\x30\x02\0\x9d\x01\x2a\x04\0\x04\0\0\xc0\x12\x25\xa0\x02\x74\xba\x01\xf8\x01\xf8\
    \0\x04\xa1\0\0\xfe\xfd\x1d\x75\xff\xf1\x6e\x7f\x8b\x73\xfc\x5b\x9f\xfe\x36\xbf\xff\x50\x5a\x1a\xf9\x7d\xe5\0\0";

/// A chunk of a RIFF file.
pub(crate) fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let padding = &[0][..data.len() % 2];
    [kind.as_slice(), &(data.len() as u32).to_le_bytes(), data, padding].concat()
}

/// A WebP of lossy frames of 4x4 pixels at the places `(x, y)`, which are even, on a canvas of 8x4; all but the
/// first are opaque and drawn over, and every frame is cleared after it.
pub(crate) fn webp(places: &[(u8, u8)]) -> Vec<u8> {
    let frame = |&(x, y): &(u8, u8)| {
        let head = [x / 2, 0, 0, y / 2, 0, 0, 3, 0, 0, 3, 0, 0, 40, 0, 0, 1];
        chunk(b"ANMF", &[&head, LOSSY].concat())
    };
    let extended = chunk(b"VP8X", &[0x12, 0, 0, 0, 7, 0, 0, 3, 0, 0]);
    let control = chunk(b"ANIM", &[0, 0, 0, 0, 0, 0]);
    let frames = places.iter().flat_map(frame).collect::<Vec<u8>>();
    chunk(b"RIFF", &[b"WEBP".as_slice(), &extended, &control, &frames].concat())
}

#[test]
fn what_is_disposed_of_in_a_webp_goes_before_an_opaque_frame_too() {
    let folder = folder();
    let file = name(&folder, "a.webp");
    fs::write(&file, webp(&[(0, 0), (4, 0)])).expect("written");
    let frames = read_all(&file).1;
    let (left, right) = (frames[1].frame.at(1, 1), frames[1].frame.at(6, 1));
    assert_eq!((left, right[3]), ([0; 4], 255));
    assert!(right[0] > 240 && right[1] > 210 && right[2] < 40, "{right:?}");
}

#[test]
fn a_jpeg_of_one_scan_a_component_has_its_colours() {
    let folder = folder();
    let file = name(&folder, "a.jpg");
    // Chroma is halved both ways (by libjpeg-turbo).
    fs::write(&file, include_bytes!("data/split-scans.jpg")).expect("written");
    check_red_over_blue(&read_one(&file));
}

#[test]
fn a_jpeg_of_luma_that_is_coarser_than_chroma_has_its_colours() {
    let folder = folder();
    let file = name(&folder, "a.jpg");
    // Luma is halved both ways (by libjpeg-turbo).
    fs::write(&file, include_bytes!("data/coarse-luma.jpg")).expect("written");
    check_red_over_blue(&read_one(&file));
}

/// 16x16 pixels.
fn check_red_over_blue(frame: &Frame) {
    let near = |a: Rgba, b: Rgba| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 12);
    assert!(near(frame.at(8, 1), [210, 50, 40, 255]), "{:?}", frame.at(8, 1));
    assert!(near(frame.at(8, 14), [40, 70, 200, 255]), "{:?}", frame.at(8, 14));
}

#[test]
fn exif_data_after_the_picture_of_a_png_turns_it_and_broken_code_points_are_ignored() {
    let folder = folder();
    let file = name(&folder, "a.png");
    let header = [0, 0, 0, 2, 0, 0, 0, 1, 8, 2, 0, 0, 0];
    let pixels = stored(&[0, 1, 2, 3, 4, 5, 6]);
    let exif = b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
    fs::write(&file, png(&[(b"IHDR", &header), (b"IDAT", &pixels), (b"eXIf", exif)]))
        .expect("written");
    assert_eq!(read_one(&file).size(), Size::new(1, 2));
    // A matrix, which PNG has none of.
    let cicp = [12, 13, 1, 1];
    fs::write(&file, png(&[(b"IHDR", &header), (b"cICP", &cicp), (b"IDAT", &pixels)]))
        .expect("written");
    assert_eq!(read_one(&file).pixels(), [[1, 2, 3, 255], [4, 5, 6, 255]]);
}

#[test]
fn gamma_and_primaries_of_a_png_become_those_of_srgb() {
    let folder = folder();
    let file = name(&folder, "a.png");
    let with = |kind: &[u8; 4], data: &[u8]| {
        let header = [0, 0, 0, 1, 0, 0, 0, 1, 8, 2, 0, 0, 0];
        let pixel = stored(&[0, 220, 60, 40]);
        fs::write(&file, png(&[(b"IHDR", &header), (kind, data), (b"IDAT", &pixel)]))
            .expect("written");
        read_one(&file).at(0, 0)
    };
    assert_eq!(with(b"gAMA", &45455u32.to_be_bytes()), [220, 60, 40, 255]);
    assert_eq!(with(b"sRGB", &[0]), [220, 60, 40, 255]);
    let [r, g, b, _] = with(b"gAMA", &100_000u32.to_be_bytes());
    assert!(r.abs_diff(238) <= 1 && g.abs_diff(133) <= 1 && b.abs_diff(110) <= 1, "{r} {g} {b}");
    // Display P3, by LittleCMS.
    let [r, g, b, _] = with(b"cICP", &[12, 13, 0, 1]);
    assert!(r.abs_diff(239) <= 2 && g.abs_diff(35) <= 2 && b.abs_diff(17) <= 2, "{r} {g} {b}");
}

/// A little-endian TIFF of one strip (or one a plane), or of tiles, with short tags.
fn tiff(size: (u16, u16), tags: &[(u16, &[u16])], planes: &[&[u8]]) -> Vec<u8> {
    let mut tags: Vec<(u16, Vec<u16>)> = tags.iter().map(|&(t, v)| (t, v.to_vec())).collect();
    tags.extend([(256, vec![size.0]), (257, vec![size.1])]);
    let has = |tags: &[(u16, Vec<u16>)], tag| tags.iter().any(|&(t, _)| t == tag);
    if !has(&tags, 259) {
        tags.push((259, vec![1]));
    }
    let is_tiled = has(&tags, 322);
    if !is_tiled {
        tags.push((278, vec![size.1]));
    }
    let (places, lengths) = if is_tiled { (324, 325) } else { (273, 279) };
    let data: Vec<u8> = planes.concat();
    let begins = |i: usize| 8 + planes[..i].iter().map(|p| p.len()).sum::<usize>() as u16;
    tags.push((places, (0..planes.len()).map(begins).collect()));
    tags.push((lengths, planes.iter().map(|p| p.len() as u16).collect()));
    tags.sort();
    let directory = (8 + data.len()).next_multiple_of(2);
    let mut bytes = [b"II*\0".as_slice(), &(directory as u32).to_le_bytes(), &data].concat();
    bytes.resize(directory, 0);
    bytes.extend((tags.len() as u16).to_le_bytes());
    let mut behind = directory + 2 + 12 * tags.len() + 4;
    let mut values = Vec::new();
    for (tag, value) in &tags {
        bytes.extend([tag.to_le_bytes(), [3, 0]].concat());
        bytes.extend((value.len() as u32).to_le_bytes());
        let packed: Vec<u8> = value.iter().flat_map(|v| v.to_le_bytes()).collect();
        if packed.len() <= 4 {
            bytes.extend([&packed[..], &[0; 4][packed.len()..]].concat());
        } else {
            bytes.extend((behind as u32).to_le_bytes());
            behind += packed.len();
            values.extend(packed);
        }
    }
    bytes.extend([0; 4]);
    bytes.extend(values);
    bytes
}

fn read_tiff(size: (u16, u16), tags: &[(u16, &[u16])], planes: &[&[u8]]) -> Vec<Rgba> {
    let folder = folder();
    let file = name(&folder, "a.tif");
    fs::write(&file, tiff(size, tags, planes)).expect("written");
    read_one(&file).into_pixels()
}

#[test]
fn the_fourth_sample_of_a_tiff_is_what_its_tag_says() {
    for (extra, expected) in
        [(1, [209, 50, 40, 128]), (2, [105, 25, 20, 128]), (0, [105, 25, 20, 255])]
    {
        let tags: [(u16, &[u16]); 4] = [(258, &[8; 4]), (262, &[2]), (277, &[4]), (338, &[extra])];
        assert_eq!(read_tiff((1, 1), &tags, &[&[105, 25, 20, 128]]), [expected], "{extra}");
    }
}

#[test]
fn planes_and_few_bits_of_a_tiff_are_read() {
    let rgb: [(u16, &[u16]); 4] = [(258, &[8; 3]), (262, &[2]), (277, &[3]), (284, &[2])];
    let planes: [&[u8]; 3] = [&[1, 4], &[2, 5], &[3, 6]];
    assert_eq!(read_tiff((2, 1), &rgb, &planes), [[1, 2, 3, 255], [4, 5, 6, 255]]);
    let gray: [(u16, &[u16]); 3] = [(258, &[2]), (262, &[0]), (277, &[1])];
    assert_eq!(read_tiff((2, 1), &gray, &[&[0b0010_0000]]), [[255; 4], [85, 85, 85, 255]]);
}

#[test]
fn gray_with_alpha_and_palettes_of_a_tiff_are_read() {
    let gray: [(u16, &[u16]); 4] = [(258, &[8; 2]), (262, &[1]), (277, &[2]), (338, &[2])];
    let expected = [[9, 9, 9, 200], [7, 7, 7, 0]];
    assert_eq!(read_tiff((2, 1), &gray, &[&[9, 200, 7, 0]]), expected);
    let white_is_zero: [(u16, &[u16]); 4] = [(258, &[8; 2]), (262, &[0]), (277, &[2]), (338, &[2])];
    assert_eq!(read_tiff((1, 1), &white_is_zero, &[&[55, 128]]), [[200, 200, 200, 128]]);
    // Two bits: red, green, blue of four entries, of 16 bits each.
    let full = 65535;
    let map = [0, full, 0, 0, 0, 0, full, 0, 0x8080, 0, 0, full];
    let palette: [(u16, &[u16]); 4] = [(258, &[2]), (262, &[3]), (277, &[1]), (320, &map)];
    assert_eq!(
        read_tiff((3, 2), &palette, &[&[0b0001_1000, 0b1101_0000]]),
        [
            [0, 0, 128, 255],
            [255, 0, 0, 255],
            [0, 255, 0, 255],
            [0, 0, 255, 255],
            [255, 0, 0, 255],
            [0, 0, 128, 255],
        ]
    );
}

#[test]
fn whole_numbers_of_32_bits_of_a_tiff_are_no_fractions() {
    let rgb: [(u16, &[u16]); 3] = [(258, &[32; 3]), (262, &[2]), (277, &[3])];
    let samples = [0x1111_1111u32, 0x8000_0000, 0xffff_ffff].map(u32::to_le_bytes);
    assert_eq!(read_tiff((1, 1), &rgb, &[samples.as_flattened()]), [[17, 128, 255, 255]]);
}

/// A run of 256 equal bytes by LZW: codes of 9 bits, from the highest bit, each for one byte more than the last.
fn lzw_run(byte: u8) -> Vec<u8> {
    let mut codes = vec![256, u16::from(byte)];
    codes.extend(258..279);
    // Another three bytes.
    codes.extend([259, 257]);
    let bits = codes.iter().flat_map(|code| (0..9).rev().map(move |bit| (code >> bit & 1) as u8));
    let bits: Vec<u8> = bits.collect();
    bits.chunks(8).map(|bits| (0..8).fold(0, |b, i| b << 1 | bits.get(i).unwrap_or(&0))).collect()
}

#[test]
fn tiles_of_a_tiff_that_reach_over_its_border_are_read() {
    // Two tiles of 16x16, of which the second shows four columns.
    let tiles = [lzw_run(70), lzw_run(90)];
    let tags: [(u16, &[u16]); 6] =
        [(258, &[8]), (259, &[5]), (262, &[1]), (277, &[1]), (322, &[16]), (323, &[16])];
    let pixels = read_tiff((20, 3), &tags, &[&tiles[0], &tiles[1]]);
    for row in pixels.chunks(20) {
        assert!(row[..16].iter().all(|&p| p == [70, 70, 70, 255]), "{row:?}");
        assert!(row[16..].iter().all(|&p| p == [90, 90, 90, 255]), "{row:?}");
    }
    // Planes of one tile each.
    let planes = [[10; 256], [20; 256], [30; 256]];
    let tags: [(u16, &[u16]); 6] =
        [(258, &[8; 3]), (262, &[2]), (277, &[3]), (284, &[2]), (322, &[16]), (323, &[16])];
    let pixels = read_tiff((3, 2), &tags, &planes.each_ref().map(|p| p.as_slice()));
    assert_eq!(pixels, [[10, 20, 30, 255]; 6]);
}

#[test]
fn big_tiffs_are_read() {
    let entry = |tag: u16, value: u16| {
        [&tag.to_le_bytes()[..], &[3, 0], &1u64.to_le_bytes(), &u64::from(value).to_le_bytes()]
            .concat()
    };
    let tags = [(256, 1), (257, 1), (258, 8), (259, 1), (262, 1), (273, 16), (277, 1), (279, 1)];
    let entries: Vec<u8> = tags.iter().flat_map(|&(tag, value)| entry(tag, value)).collect();
    let count = (tags.len() as u64).to_le_bytes();
    let head = [b"II+\0\x08\0\0\0".as_slice(), &24u64.to_le_bytes()].concat();
    let folder = folder();
    let file = name(&folder, "a.tif");
    let bytes = [head.as_slice(), &[77, 0, 0, 0, 0, 0, 0, 0], &count, &entries, &[0; 8]].concat();
    fs::write(&file, bytes).expect("written");
    assert_eq!(read_one(&file).at(0, 0), [77, 77, 77, 255]);
}

#[test]
fn tiffs_are_turned_upright_and_what_cannot_be_honoured_is_refused() {
    let gray: [(u16, &[u16]); 4] = [(258, &[8]), (262, &[1]), (277, &[1]), (274, &[3])];
    assert_eq!(read_tiff((2, 1), &gray, &[&[9, 200]]), [[200, 200, 200, 255], [9, 9, 9, 255]]);
    let folder = folder();
    let file = name(&folder, "a.tif");
    let reversed: [(u16, &[u16]); 4] = [(258, &[8]), (262, &[1]), (277, &[1]), (266, &[2])];
    fs::write(&file, tiff((2, 1), &reversed, &[&[9, 200]])).expect("written");
    let (_, error) = read_broken(&file, &SourceOptions::default());
    assert!(error.contains("FillOrder") && error.contains("save it as"), "{error}");
}

#[test]
fn odd_gifs_are_read_whole() {
    let folder = folder();
    let file = name(&folder, "a.gif");
    let head = b"GIF89a\x02\0\x01\0\x80\0\0\0\0\0\xff\xff\xff".as_slice();
    let frame = b"!\xf9\x04\0\x0a\0\0\0,\0\0\0\0\x02\0\x01\0\0\x02\x02\x44\x0a\0".as_slice();
    let unknown = b"!\x42\x03abc\x01d\0".as_slice();
    let loops = b"!\xff\x0bANIMEXTS1.0\x03\x01\x05\0\0".as_slice();
    let (without_trailer, without_end) = (&frame[..frame.len()], &frame[..frame.len() - 1]);
    for (bytes, plays) in [
        ([head, unknown, frame, frame, b";"].concat(), 1),
        ([head, frame, b"\0\0", frame, b"\0;"].concat(), 1),
        ([head, frame, without_trailer].concat(), 1),
        ([head, frame, without_end].concat(), 1),
        ([head, loops, frame, frame, b";"].concat(), 6),
        ([head, frame, frame, loops, b";"].concat(), 6),
    ] {
        fs::write(&file, &bytes).expect("written");
        let (info, frames) = read_all(&file);
        assert_eq!((info.frames, frames.len()), (Some(2), 2), "{}", bytes.escape_ascii());
        let times = if plays == 1 {
            polyreel::stream::Loops::Once
        } else {
            polyreel::stream::Loops::Times(plays)
        };
        assert_eq!(info.loops, times, "{}", bytes.escape_ascii());
    }
}

#[test]
fn pictures_that_take_more_memory_than_allowed_are_refused_before_it_is_taken() {
    let folder = folder();
    let files = [("a.png", "png"), ("a.webp", "webp"), ("a.bmp", "bmp"), ("a.tiff", "tiff")];
    let small = SourceOptions { max_memory: Some(100_000), ..SourceOptions::default() };
    for (file, _) in files.into_iter().chain([("a.gif", "gif"), ("a.jpg", "jpeg")]) {
        let file = name(&folder, file);
        write_still(&file, &patches(Size::new(200, 200), 1, false)).expect("written");
        let (frames, error) = read_broken(&file, &small);
        assert!(frames == 0 && error.contains("--max-memory"), "{file}: {error}");
        assert_eq!(read_one(&file).size(), Size::new(200, 200));
    }
    let file = name(&folder, "b.png");
    let whole = (Size::new(100, 100), (0, 0), 0, 0);
    fs::write(&file, apng(&[whole, whole], 8, false)).expect("written");
    let (_, error) = read_broken(&file, &small);
    assert!(error.contains("--max-memory"), "{error}");
}

/// `tiff`, whose directory stands there twice: as a page, and as the next one.
fn doubled(mut tiff: Vec<u8>) -> Vec<u8> {
    let word = |bytes: &[u8], at: usize| {
        u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize
    };
    let from = word(&tiff, 4);
    let tags = usize::from(u16::from_le_bytes([tiff[from], tiff[from + 1]]));
    let directory = tiff[from..from + 2 + 12 * tags + 4].to_vec();
    tiff.resize(tiff.len().next_multiple_of(2), 0);
    let (next, end) = (tiff.len() as u32, from + directory.len());
    tiff[end - 4..end].copy_from_slice(&next.to_le_bytes());
    [tiff, directory].concat()
}

fn warnings(file: &str) -> Vec<String> {
    let input = polyreel::source::open(&[file], &SourceOptions::default()).expect(file);
    input.warnings().to_vec()
}

#[test]
fn of_a_tiff_with_several_pages_the_first_is_read_with_a_warning() {
    let folder = folder();
    let file = name(&folder, "a.tif");
    // A page, and one that is the same picture made smaller.
    for (kind, warned) in [(0, true), (1, false)] {
        let tags: [(u16, &[u16]); 4] = [(254, &[kind]), (258, &[8]), (262, &[1]), (277, &[1])];
        let one = tiff((2, 1), &tags, &[&[9, 200]]);
        fs::write(&file, &one).expect("written");
        assert_eq!(warnings(&file), [""; 0]);
        fs::write(&file, doubled(one)).expect("written");
        assert_eq!(read_one(&file).into_pixels(), [[9, 9, 9, 255], [200, 200, 200, 255]]);
        let found = warnings(&file);
        assert_eq!(found.len(), usize::from(warned), "{found:?}");
        assert!(found.iter().all(|text| text.contains("a.tif: it has several pages")), "{found:?}");
    }
}

#[test]
fn metadata_that_takes_too_much_memory_is_left_out_with_a_warning() {
    let folder = folder();
    let file = name(&folder, "a.png");
    let header = [0, 0, 0, 2, 0, 0, 0, 1, 8, 2, 0, 0, 0];
    let pixels = stored(&[0, 220, 60, 40, 1, 2, 3]);
    let large = vec![0; 9 << 20];
    let profile = [b"name\0\0".as_slice(), &stored(&large)].concat();
    for chunk in [(b"eXIf", large.as_slice()), (b"iCCP", profile.as_slice())] {
        for before in [true, false] {
            let mut chunks = vec![(b"IHDR", header.as_slice()), (b"IDAT", pixels.as_slice())];
            chunks.insert(if before { 1 } else { 2 }, chunk);
            fs::write(&file, png(&chunks)).expect("written");
            let read = read_one(&file).into_pixels();
            assert_eq!(read, [[220, 60, 40, 255], [1, 2, 3, 255]]);
            let found = warnings(&file);
            // What comes after the pixels is not looked at.
            assert_eq!(found.len(), usize::from(before), "{found:?}");
            assert!(found.iter().all(|text| text.contains("a.png: its metadata")), "{found:?}");
        }
    }
}

#[test]
fn sixteen_bits_of_linear_light_keep_their_dark_levels() {
    let folder = folder();
    let file = name(&folder, "a.png");
    let header = [0, 0, 0, 1, 0, 0, 0, 1, 16, 2, 0, 0, 0];
    // Level 5 of sRGB, which 8 bits of linear light have not.
    let [high, low] = ((5.0f64 / 255.0 / 12.92 * 65535.0).round() as u16).to_be_bytes();
    let pixel = stored(&[0, high, low, high, low, high, low]);
    let gamma = 100_000u32.to_be_bytes();
    fs::write(&file, png(&[(b"IHDR", &header), (b"gAMA", &gamma), (b"IDAT", &pixel)]))
        .expect("written");
    let [r, g, b, a] = read_one(&file).at(0, 0);
    assert!([r, g, b].iter().all(|v| v.abs_diff(5) <= 1) && a == 255, "{r} {g} {b} {a}");
}
