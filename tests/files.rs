//! Files of pictures, in and out, through real encoders and decoders.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{AnimationDecoder, DynamicImage, ImageEncoder, ImageFormat, RgbaImage};
use polyreel::chance::{Purpose, rank};
use polyreel::error::{Error, Result};
use polyreel::frame::{Fill, Frame, Loops, Rational, Rgba, Span, StreamInfo};
use polyreel::geom::Size;
use polyreel::sink::{self, Picture, SinkOptions};
use polyreel::source::{self, Decoded, SourceOptions};
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn name(folder: &TempDir, file: &str) -> String {
    folder.path().join(file).to_string_lossy().into_owned()
}

fn listed(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// All frames up to the end or an error.
fn read(input: &str, options: &SourceOptions) -> (Option<StreamInfo>, Vec<Decoded>, Option<Error>) {
    let opened = match source::open(&[input.to_owned()], options) {
        Ok(opened) => opened,
        Err(e) => return (None, Vec::new(), Some(e)),
    };
    let info = opened.info().clone();
    let mut frames = Vec::new();
    let all = || -> Result<()> {
        let mut source = opened.start()?;
        while let Some(decoded) = source.next()? {
            assert_eq!(decoded.frame.size(), info.size, "the size that the header told");
            frames.push(decoded);
        }
        Ok(())
    };
    let error = all().err();
    (Some(info), frames, error)
}

fn read_all(input: &str) -> (StreamInfo, Vec<Decoded>) {
    let (info, frames, error) = read(input, &SourceOptions::default());
    assert!(error.is_none(), "{input}: {}", error.expect("an error"));
    (info.expect("a header"), frames)
}

fn read_one(input: &str) -> Frame {
    let (info, mut frames) = read_all(input);
    assert!(info.still && frames.len() == 1, "{input} is a still");
    frames.remove(0).frame
}

/// The error and the number of frames before it.
fn read_broken(input: &str, options: &SourceOptions) -> (usize, String) {
    let (_, frames, error) = read(input, options);
    (frames.len(), error.unwrap_or_else(|| panic!("{input} is not broken")).to_string())
}

fn random(seed: u64, x: u32, y: u32) -> u64 {
    rank(seed, Purpose::Noise, x, y)
}

/// Squares of flat colours; some of them transparent if `alpha`.
fn patches(size: Size, seed: u64, alpha: bool) -> Frame {
    let pixels = (0..size.height)
        .flat_map(|y| (0..size.width).map(move |x| (x, y)))
        .map(|(x, y)| {
            let [r, g, b, a, ..] = random(seed, x / 5, y / 5).to_le_bytes();
            [r & 0xf0, g & 0xf0, b & 0x80, if alpha && a < 90 { 0 } else { 255 }]
        })
        .collect();
    Frame::new(size, pixels).expect("a frame")
}

fn picture(frame: Frame, span: Span) -> Picture {
    let mut colours: Vec<Rgba> = frame.pixels().to_vec();
    colours.sort_unstable();
    let fills = colours
        .chunk_by(|a, b| a == b)
        .map(|run| Fill { colour: run[0], area: run.len() as u32 })
        .collect();
    Picture { frame, fills, span }
}

fn still_span() -> Span {
    Span { start: Rational::ZERO, length: None }
}

fn info(size: Size, frames: u64) -> StreamInfo {
    StreamInfo {
        format: "test".into(),
        size,
        frames: Some(frames),
        rate: None,
        duration: None,
        alpha: true,
        still: frames == 1,
        loops: Loops::Forever,
        audio: None,
        live: false,
        colour: None,
    }
}

/// Writes frames of `hundredths` each.
fn write(output: &str, frames: &[Frame], hundredths: &[i64], options: &SinkOptions) -> Result<()> {
    let mut sink = sink::create(output, &info(frames[0].size(), frames.len() as u64), options)?;
    let mut start = Rational::ZERO;
    for (frame, &delay) in frames.iter().zip(hundredths.iter().cycle()) {
        let length = Rational::new(delay, 100);
        sink.write(picture(frame.clone(), Span { start, length: Some(length) }))?;
        start = start + length;
    }
    sink.finish()
}

fn write_still(output: &str, frame: &Frame) -> Result<()> {
    let mut sink = sink::create(output, &info(frame.size(), 1), &SinkOptions::default())?;
    sink.write(picture(frame.clone(), still_span()))?;
    sink.finish()
}

/// What a GIF makes of a frame that has few colours.
fn thresholded(frame: &Frame) -> Vec<Rgba> {
    let one = |&[r, g, b, a]: &Rgba| if a < 128 { [0; 4] } else { [r, g, b, 255] };
    frame.pixels().iter().map(one).collect()
}

fn psnr(a: &Frame, b: &Frame) -> f64 {
    let square = |(p, q): (&Rgba, &Rgba)| {
        (0..3).map(|i| f64::from(p[i]) - f64::from(q[i])).map(|d| d * d).sum::<f64>()
    };
    let sum: f64 = a.pixels().iter().zip(b.pixels()).map(square).sum();
    10.0 * (255.0 * 255.0 * 3.0 * a.pixels().len() as f64 / sum).log10()
}

// Stills.

#[test]
fn lossless_stills_come_back_as_they_went() {
    let folder = folder();
    for (extension, format) in
        [("png", "png"), ("webp", "webp"), ("bmp", "bmp"), ("tiff", "tiff"), ("PNG", "png")]
    {
        for alpha in [false, true] {
            let frame = patches(Size::new(37, 21), 1, alpha);
            let file = name(&folder, &format!("{alpha}.{extension}"));
            write_still(&file, &frame).expect("written");
            assert_eq!(read_one(&file), frame, "{file}");
            let info = read_all(&file).0;
            assert_eq!((info.format.as_str(), info.alpha), (format, alpha), "{file}");
        }
    }
}

#[test]
fn jpeg_flattens_alpha_on_the_background() {
    let folder = folder();
    let file = name(&folder, "a.jpg");
    let frame = Frame::filled(Size::new(32, 32), [0, 0, 0, 51]).expect("a frame");
    let background = [250, 100, 0, 255];
    let options = SinkOptions { background, quality: Some(100), ..SinkOptions::default() };
    write(&file, &[frame], &[0], &options).expect("written");
    let [r, g, b, a] = read_one(&file).at(16, 16);
    // 51 is a fifth: black over the background leaves four fifths of it.
    assert!(r.abs_diff(200) <= 2 && g.abs_diff(80) <= 2 && b <= 2 && a == 255, "{r} {g} {b} {a}");
}

#[test]
fn pictures_are_known_by_content_not_by_name() {
    let folder = folder();
    let frame = patches(Size::new(9, 7), 2, false);
    write_still(&name(&folder, "a.png"), &frame).expect("written");
    fs::rename(name(&folder, "a.png"), name(&folder, "b.jpg")).expect("renamed");
    assert_eq!(read_all(&name(&folder, "b.jpg")).0.format, "png");
    assert_eq!(read_one(&name(&folder, "b.jpg")), frame);
}

#[test]
fn gray_deep_and_palette_pictures_become_rgba() {
    let folder = folder();
    let gray = image::GrayImage::from_fn(5, 3, |x, y| image::Luma([(x * 40 + y) as u8]));
    let deep = image::ImageBuffer::<image::Rgba<u16>, Vec<u16>>::from_fn(5, 3, |x, y| {
        image::Rgba([x as u16 * 257 * 40, y as u16 * 257, 65535, 257 * 128])
    });
    for extension in ["png", "tiff"] {
        let file = name(&folder, &format!("gray.{extension}"));
        gray.save(&file).expect("written");
        assert_eq!(read_one(&file).at(3, 2), [122, 122, 122, 255], "{file}");
        let file = name(&folder, &format!("deep.{extension}"));
        deep.save(&file).expect("written");
        assert_eq!(read_one(&file).at(3, 2), [120, 2, 255, 128], "{file}");
    }
    let file = name(&folder, "gray.pgm");
    gray.save(&file).expect("written");
    assert_eq!(read_one(&file).at(3, 2), [122, 122, 122, 255]);

    // Two bits a pixel: 0 1 2 3, the last one half transparent.
    let file = name(&folder, "palette.png");
    let chunks: [(&[u8; 4], &[u8]); 4] = [
        (b"IHDR", &[0, 0, 0, 4, 0, 0, 0, 1, 2, 3, 0, 0, 0]),
        (b"PLTE", &[0, 0, 0, 9, 8, 7, 200, 0, 0, 1, 2, 3]),
        (b"tRNS", &[255, 255, 255, 127]),
        (b"IDAT", &stored(&[0, 0b00_01_10_11])),
    ];
    fs::write(&file, png(&chunks)).expect("written");
    let expected = [[0, 0, 0, 255], [9, 8, 7, 255], [200, 0, 0, 255], [1, 2, 3, 127]];
    assert_eq!(read_one(&file).pixels(), expected);
    assert!(read_all(&file).0.alpha);
}

/// A PNG of chunks.
fn png(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    for (kind, data) in chunks.iter().chain([&(b"IEND", [].as_slice())]) {
        bytes.extend((data.len() as u32).to_be_bytes());
        let checked = [kind.as_slice(), data].concat();
        bytes.extend(&checked);
        bytes.extend(crc(&checked).to_be_bytes());
    }
    bytes
}

/// CRC-32 as PNG has it (annex D of the specification).
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &b| {
        (0..8).fold(
            crc ^ u32::from(b),
            |c, _| {
                if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 }
            },
        )
    })
}

/// A zlib stream of few bytes, not compressed.
fn stored(bytes: &[u8]) -> Vec<u8> {
    let length = bytes.len() as u16;
    let (a, b) = bytes.iter().fold((1u32, 0u32), |(a, b), &v| {
        let a = (a + u32::from(v)) % 65521;
        (a, (b + a) % 65521)
    });
    let mut out = vec![0x78, 0x01, 0x01];
    out.extend(length.to_le_bytes());
    out.extend((!length).to_le_bytes());
    out.extend(bytes);
    out.extend(((b << 16) | a).to_be_bytes());
    out
}

/// EXIF data that holds an orientation and nothing else.
fn exif(orientation: u8) -> Vec<u8> {
    let mut exif = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
    exif.extend([orientation, 0, 0, 0, 0, 0, 0, 0]);
    exif
}

#[test]
fn pictures_are_turned_upright() {
    let folder = folder();
    // Red, green / blue, white, each of 16 x 8 pixels.
    let upright = RgbaImage::from_fn(32, 16, |x, y| {
        image::Rgba(match (x / 16, y / 8) {
            (0, 0) => [255, 0, 0, 255],
            (1, 0) => [0, 255, 0, 255],
            (0, _) => [0, 0, 255, 255],
            _ => [255, 255, 255, 255],
        })
    });
    for orientation in 1..=8u8 {
        // Stored so that the turn which the tag asks for makes it upright.
        let turn = DynamicImage::ImageRgba8(upright.clone());
        let stored = match orientation {
            1 => turn,
            2 => turn.fliph(),
            3 => turn.rotate180(),
            4 => turn.flipv(),
            5 => turn.rotate270().flipv(),
            6 => turn.rotate270(),
            7 => turn.rotate90().flipv(),
            _ => turn.rotate90(),
        };
        let file = name(&folder, &format!("{orientation}.png"));
        let mut bytes = Vec::new();
        let mut encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        encoder.set_exif_metadata(exif(orientation)).expect("EXIF");
        stored.write_with_encoder(encoder).expect("a PNG");
        fs::write(&file, bytes).expect("written");
        assert_eq!(read_one(&file).into_image(), upright, "orientation {orientation}");

        let file = name(&folder, &format!("{orientation}.jpg"));
        let mut bytes = Cursor::new(Vec::new());
        stored.to_rgb8().write_to(&mut bytes, ImageFormat::Jpeg).expect("a JPEG");
        let (bytes, tag) = (bytes.into_inner(), exif(orientation));
        let length = (2 + 6 + tag.len() as u16).to_be_bytes();
        let segment = [&[0xff, 0xe1], &length[..], b"Exif\0\0", &tag].concat();
        fs::write(&file, [&bytes[..2], &segment, &bytes[2..]].concat()).expect("written");
        let (info, frames) = read_all(&file);
        assert_eq!(info.size, Size::new(32, 16));
        let expected = Frame::from_image(upright.clone()).expect("a frame");
        assert!(psnr(&frames[0].frame, &expected) > 25.0, "JPEG orientation {orientation}");
    }
}

// Bad input.

#[test]
fn a_header_that_claims_too_much_is_refused_before_memory_is_taken() {
    let folder = folder();
    let side = 60000u32.to_be_bytes();
    let header = [&side[..], &side, &[8, 6, 0, 0, 0]].concat();
    let png = png(&[(b"IHDR", &header), (b"IDAT", &stored(&[0; 9]))]);
    let mut bmp = Cursor::new(Vec::new());
    RgbaImage::new(1, 1).write_to(&mut bmp, ImageFormat::Bmp).expect("a BMP");
    let mut bmp = bmp.into_inner();
    bmp[18..22].copy_from_slice(&60000u32.to_le_bytes());
    bmp[22..26].copy_from_slice(&60000u32.to_le_bytes());
    let gif = b"GIF89a\x60\xea\x60\xea\x80\0\0\0\0\0\xff\xff\xff,\0\0\0\0\x01\0\x01\0\0\x02\x02\x44\x01\0;";
    let pnm = b"P6\n60000 60000\n255\nabc";
    let files: [(&str, &[u8]); 4] =
        [("a.png", &png), ("a.bmp", &bmp), ("a.gif", gif), ("a.ppm", pnm)];
    for (file, bytes) in files {
        let file = name(&folder, file);
        fs::write(&file, bytes).expect("written");
        let (frames, error) = read_broken(&file, &SourceOptions::default());
        assert!(frames == 0 && error.contains("60000x60000") && error.contains("16384"), "{error}");
    }
}

#[test]
fn what_is_no_picture_is_named_and_told() {
    let folder = folder();
    fs::write(name(&folder, "empty.png"), b"").expect("written");
    fs::write(name(&folder, "text.png"), b"this is text").expect("written");
    fs::create_dir(name(&folder, "none")).expect("a folder");
    fs::write(name(&folder, "none/text.txt"), b"this is text").expect("written");
    for (file, words) in [
        ("empty.png", "empty"),
        ("text.png", "not a picture"),
        ("missing.png", "no such file"),
        ("none", "no picture"),
        ("missing_%03d.png", "no file matches"),
        ("missing*.png", "no file matches"),
    ] {
        let file = name(&folder, file);
        let (_, error) = read_broken(&file, &SourceOptions::default());
        assert!(error.contains(&file) && error.contains(words), "{error}");
    }
}

#[test]
fn truncated_stills_are_errors_and_keep_what_is_there_on_request() {
    let folder = folder();
    let frame = patches(Size::new(64, 64), 3, true);
    let allow = SourceOptions { allow_truncated: true, ..SourceOptions::default() };
    for extension in ["png", "jpg", "webp", "bmp", "tiff", "gif"] {
        let file = name(&folder, &format!("whole.{extension}"));
        write_still(&file, &frame).expect("written");
        let whole = fs::read(&file).expect("a file");
        let cut = name(&folder, &format!("cut.{extension}"));
        for length in (1..whole.len() - 1).step_by(whole.len() / 40 + 1) {
            fs::write(&cut, &whole[..length]).expect("written");
            let (frames, error) = read_broken(&cut, &SourceOptions::default());
            assert!(frames == 0 && error.contains(&cut), "{error}");
            read(&cut, &allow);
        }
        fs::write(&cut, &whole[..whole.len() * 3 / 4]).expect("written");
        let (_, error) = read_broken(&cut, &SourceOptions::default());
        // A TIFF keeps its directory at the end, and without it there is no picture at all.
        if extension != "tiff" {
            assert!(error.contains("--allow-truncated"), "{error}");
        }
        if ["png", "jpg", "gif"].contains(&extension) {
            let (_, frames, error) = read(&cut, &allow);
            assert!(error.is_none(), "{cut}: {}", error.expect("an error"));
            let expected = read_one(&file);
            assert_eq!(frames[0].frame.row(5), expected.row(5), "{cut}");
        }
    }
}

#[test]
fn pictures_of_two_sizes_make_no_sequence() {
    let folder = folder();
    write_still(&name(&folder, "1.png"), &patches(Size::new(8, 8), 1, false)).expect("written");
    write_still(&name(&folder, "2.png"), &patches(Size::new(8, 9), 1, false)).expect("written");
    let (_, error) = read_broken(&name(&folder, ""), &SourceOptions::default());
    for words in ["1.png", "2.png", "8x8", "8x9", "frame 1"] {
        assert!(error.contains(words), "{words}: {error}");
    }
}

// Sequences.

#[test]
fn sequences_go_out_numbered_and_come_back_in_order() {
    let folder = folder();
    let frames: Vec<Frame> = (0..11).map(|i| patches(Size::new(12, 10), i, false)).collect();
    fs::create_dir(name(&folder, "there")).expect("a folder");
    for output in ["new/", "there", "f_%d.png", "g_%03d.webp"] {
        write(&name(&folder, output), &frames, &[4], &SinkOptions::default()).expect("written");
    }
    assert_eq!(listed(&folder.path().join("new"))[9..], ["0010.png", "0011.png"]);
    let fps = Some(Rational::new(10, 1));
    for input in ["new", "there", "f_%d.png", "f_*.png", "g_%03d.webp"] {
        let options = SourceOptions { fps, ..SourceOptions::default() };
        let (info, read, error) = read(&name(&folder, input), &options);
        assert!(error.is_none(), "{input}: {}", error.expect("an error"));
        let info = info.expect("a header");
        assert_eq!((info.frames, info.rate, info.still), (Some(11), fps, false), "{input}");
        assert_eq!(info.duration, Some(Rational::new(11, 10)));
        for (i, (decoded, frame)) in read.iter().zip(&frames).enumerate() {
            assert_eq!(decoded.frame, *frame, "{input} {i}");
            assert_eq!(decoded.span.start, Rational::new(i as i64, 10));
        }
        assert_eq!(read.len(), 11);
    }
}

#[test]
fn a_part_of_a_sequence_is_cut_and_shrunk() {
    let folder = folder();
    let frames: Vec<Frame> = (0..10).map(|i| patches(Size::new(40, 20), i, false)).collect();
    write(&name(&folder, "s/"), &frames, &[10], &SinkOptions::default()).expect("written");
    let options = SourceOptions {
        fps: Some(Rational::new(10, 1)),
        start: Some(Rational::new(15, 100)),
        end: Some(Rational::new(7, 10)),
        frames: Some(4),
        max_size: Some(20),
        ..SourceOptions::default()
    };
    let (info, read_frames, error) = read(&name(&folder, "s"), &options);
    assert!(error.is_none());
    let info = info.expect("a header");
    // Frames 2 to 6 start in the part, and 4 of them are wanted.
    assert_eq!((info.frames, info.size), (Some(4), Size::new(20, 10)));
    assert_eq!(read_frames.len(), 4);
    assert_eq!(read_frames[0].span.start, Rational::new(5, 100));
    let late = SourceOptions { start: Some(Rational::new(9, 1)), ..SourceOptions::default() };
    let (frames, error) = read_broken(&name(&folder, "s"), &late);
    assert!(frames == 0 && error.contains("9 s"), "{error}");
}

#[test]
fn one_picture_in_a_folder_is_a_still() {
    let folder = folder();
    write_still(&name(&folder, "a.png"), &patches(Size::new(8, 8), 1, false)).expect("written");
    assert!(read_all(&name(&folder, "")).0.still);
}

// GIF in.

/// A GIF of random partial frames: offsets beyond the screen, all disposals, interlace, transparency,
/// palettes of their own.
fn random_gif(seed: u64, screen: (u16, u16), frames: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let global: Vec<u8> = (0..24).map(|i| random(seed, i, 99) as u8).collect();
    let mut encoder = gif::Encoder::new(&mut bytes, screen.0, screen.1, &global).expect("a header");
    for f in 0..frames {
        let dice = |i: u32, sides: u64| (random(seed, i, 1000 + f) % sides) as u16;
        let whole = f == 0 && dice(9, 2) == 0;
        let (width, height) = if whole {
            screen
        } else {
            (1 + dice(0, screen.0.into()), 1 + dice(1, screen.1.into()))
        };
        let (left, top) = if whole { (0, 0) } else { (dice(2, 9), dice(3, 9)) };
        let local = dice(4, 2) == 0;
        let area = u32::from(width) * u32::from(height);
        let frame = gif::Frame {
            delay: dice(5, 12),
            dispose: gif::DisposalMethod::from_u8(dice(6, 4) as u8).expect("one of four"),
            transparent: (dice(7, 3) > 0).then_some(0),
            interlaced: false,
            left,
            top,
            width,
            height,
            palette: local.then(|| (0..24).map(|i| random(seed, i, 500 + f) as u8).collect()),
            buffer: (0..area).map(|i| (random(seed, i / 3, 2000 + f) % 8) as u8).collect(),
            ..gif::Frame::default()
        };
        encoder.write_frame(&frame).expect("a frame");
    }
    encoder.into_inner().expect("a trailer");
    bytes
}

#[test]
fn gif_frames_are_composed_as_the_image_crate_does() {
    let folder = folder();
    let file = name(&folder, "a.gif");
    for seed in 0..60 {
        let bytes = random_gif(seed, (23, 17), 8);
        fs::write(&file, &bytes).expect("written");
        let decoder = image::codecs::gif::GifDecoder::new(Cursor::new(&bytes)).expect("a GIF");
        let (info, frames) = read_all(&file);
        assert_eq!((info.frames, frames.len()), (Some(8), 8));
        for (i, (theirs, ours)) in decoder.into_frames().zip(&frames).enumerate() {
            let theirs = theirs.expect("a frame");
            let delay = theirs.delay().numer_denom_ms();
            let length = Rational::new(delay.0.into(), i64::from(delay.1) * 1000);
            assert_eq!(ours.span.length, Some(length));
            for (x, y, pixel) in theirs.buffer().enumerate_pixels() {
                let (ours, theirs) = (ours.frame.at(x, y), pixel.0);
                let same = ours == theirs || (ours[3] == 0 && theirs[3] == 0);
                assert!(same, "seed {seed}, frame {i}, ({x}, {y}): {ours:?} for {theirs:?}");
            }
        }
    }
}

#[test]
fn a_truncated_gif_gives_its_good_frames_and_then_the_error() {
    let folder = folder();
    let file = name(&folder, "a.gif");
    let whole = random_gif(7, (40, 40), 6);
    fs::write(&file, &whole).expect("written");
    let (_, all) = read_all(&file);
    let mut most = 0;
    for length in (10..whole.len()).step_by(37) {
        fs::write(&file, &whole[..length]).expect("written");
        let (_, frames, error) = read(&file, &SourceOptions::default());
        let error = error.expect("it is truncated").to_string();
        assert!(error.contains("too early"), "{length}: {error}");
        assert!(frames == all[..frames.len()], "{length} of {} bytes", whole.len());
        most = most.max(frames.len());
        let allow = SourceOptions { allow_truncated: true, ..SourceOptions::default() };
        let (_, kept, error) = read(&file, &allow);
        assert!(kept.len() >= frames.len() && (error.is_none() || kept.is_empty()), "{length}");
    }
    assert!(most >= 4, "only {most} frames came of truncated files");
}

#[test]
fn gifs_without_screen_size_or_with_interlace_are_read() {
    let folder = folder();
    let file = name(&folder, "a.gif");
    let mut bytes = Vec::new();
    let palette: Vec<u8> = (0..48).collect();
    let mut encoder = gif::Encoder::new(&mut bytes, 0, 0, &palette).expect("a header");
    // Rows in the order in which they are stored: every eighth, then those between.
    let order = [0u8, 8, 4, 12, 2, 6, 10, 14, 1, 3, 5, 7, 9, 11, 13, 15];
    let frame = gif::Frame {
        width: 3,
        height: 16,
        interlaced: true,
        buffer: order.iter().flat_map(|&row| [row; 3]).collect(),
        ..gif::Frame::default()
    };
    encoder.write_frame(&frame).expect("a frame");
    encoder.into_inner().expect("a trailer");
    fs::write(&file, &bytes).expect("written");
    let frame = read_one(&file);
    assert_eq!(frame.size(), Size::new(3, 16));
    for y in 0..16u8 {
        assert_eq!(frame.at(1, y.into()), [3 * y, 3 * y + 1, 3 * y + 2, 255]);
    }
}

// GIF out.

fn composed(file: &str) -> Vec<Vec<Rgba>> {
    let bytes = fs::read(file).expect("a file");
    let decoder = image::codecs::gif::GifDecoder::new(Cursor::new(&bytes)).expect("a GIF");
    let frames = decoder.into_frames().map(|f| f.expect("a frame").into_buffer());
    frames.map(|f| f.pixels().map(|p| if p.0[3] == 0 { [0; 4] } else { p.0 }).collect()).collect()
}

#[test]
fn gifs_come_back_pixel_by_pixel_whatever_vanishes_or_appears() {
    let folder = folder();
    for seed in 0..40u64 {
        let file = name(&folder, &format!("{seed}.gif"));
        let size = Size::new(24, 19);
        let frames: Vec<Frame> = (0..9)
            .map(|f| {
                // Opaque, transparent in places, the same again, wholly transparent.
                let dice = random(seed, f, 1) % 6;
                match dice {
                    0 => Frame::filled(size, [0; 4]).expect("a frame"),
                    1 | 2 => patches(size, seed, true),
                    3 => patches(size, seed, false),
                    _ => patches(size, seed + 100 + u64::from(f), dice == 4),
                }
            })
            .collect();
        let delays = [3, 0, 1, 250, 7];
        write(&file, &frames, &delays, &SinkOptions::default()).expect("written");
        let (info, back) = read_all(&file);
        assert_eq!((info.frames, info.loops), (Some(9), Loops::Forever));
        let theirs = composed(&file);
        for (i, frame) in frames.iter().enumerate() {
            let expected = thresholded(frame);
            assert_eq!(back[i].frame.pixels(), expected, "seed {seed}, frame {i}");
            assert_eq!(theirs[i], expected, "seed {seed}, frame {i}, the image crate");
            let length = Rational::new(delays[i % delays.len()], 100);
            assert_eq!(back[i].span.length, Some(length));
        }
    }
}

#[test]
fn loops_go_in_and_out() {
    let folder = folder();
    let frames = [patches(Size::new(8, 8), 1, false), patches(Size::new(8, 8), 2, false)];
    for loops in [Loops::Once, Loops::Times(2), Loops::Times(7), Loops::Forever] {
        let file = name(&folder, &format!("{loops:?}.gif"));
        let options = SinkOptions { loops: Some(loops), ..SinkOptions::default() };
        write(&file, &frames, &[5], &options).expect("written");
        assert_eq!(read_all(&file).0.loops, loops);
    }
}

#[test]
fn gifs_of_many_colours_are_within_38_db() {
    let folder = folder();
    let size = Size::new(120, 90);
    // Flat squares on a moving, many-coloured ramp: 972 colours a frame.
    let frames: Vec<Frame> = (0..6u32)
        .map(|t| {
            let pixels = (0..size.height)
                .flat_map(|y| (0..size.width).map(move |x| (x / 3, y / 4)))
                .map(|(x, y)| [(x * 3 + t) as u8, (x + y * 4) as u8, (y * 5) as u8, 255])
                .collect();
            Frame::new(size, pixels).expect("a frame")
        })
        .collect();
    let file = name(&folder, "a.gif");
    write(&file, &frames, &[4], &SinkOptions::default()).expect("written");
    for (i, (back, frame)) in read_all(&file).1.iter().zip(&frames).enumerate() {
        let psnr = psnr(&back.frame, frame);
        assert!(psnr > 38.0, "frame {i}: {psnr} dB");
    }
}

#[test]
fn unchanged_frames_cost_next_to_nothing() {
    let folder = folder();
    let frame = patches(Size::new(200, 150), 5, false);
    let size_of = |count: usize| {
        let file = name(&folder, &format!("{count}.gif"));
        write(&file, &vec![frame.clone(); count], &[4], &SinkOptions::default()).expect("written");
        fs::metadata(file).expect("a file").len()
    };
    let (two, thirty) = (size_of(2), size_of(30));
    assert!(thirty - two < 28 * 40, "28 frames more take {} bytes", thirty - two);
}

#[test]
fn a_still_becomes_a_gif_of_one_frame() {
    let folder = folder();
    let frame = patches(Size::new(31, 9), 5, true);
    let file = name(&folder, "a.gif");
    write_still(&file, &frame).expect("written");
    let (info, back) = read_all(&file);
    assert!(info.still && info.loops == Loops::Once && info.frames == Some(1));
    assert_eq!(back[0].frame.pixels(), thresholded(&frame));
}

// Other animations in.

#[test]
fn animated_png_is_composed_and_timed() {
    let folder = folder();
    let file = name(&folder, "a.png");
    let header = [0, 0, 0, 2, 0, 0, 0, 1, 8, 6, 0, 0, 0];
    // Two pixels; then the right one alone, drawn over.
    let control = |n: u8, width: u8, x: u8, delay: [u8; 4]| {
        let head = [0, 0, 0, n, 0, 0, 0, width, 0, 0, 0, 1, 0, 0, 0, x, 0, 0, 0, 0];
        [&head[..], &delay, &[0, 1]].concat()
    };
    let second = [&[0, 0, 0, 2][..], &stored(&[0, 9, 9, 9, 255])].concat();
    let bytes = png(&[
        (b"IHDR", &header),
        (b"acTL", &[0, 0, 0, 2, 0, 0, 0, 3]),
        (b"fcTL", &control(0, 2, 0, [0, 1, 0, 30])),
        (b"IDAT", &stored(&[0, 1, 2, 3, 255, 4, 5, 6, 255])),
        (b"fcTL", &control(1, 1, 1, [0, 5, 0, 0])),
        (b"fdAT", &second),
    ]);
    fs::write(&file, &bytes).expect("written");
    let (info, frames) = read_all(&file);
    assert_eq!((info.format.as_str(), info.frames, info.still), ("apng", Some(2), false));
    assert_eq!(info.loops, Loops::Times(3));
    assert_eq!(info.duration, Some(Rational::new(1, 30) + Rational::new(5, 100)));
    assert_eq!(frames[0].frame.pixels(), [[1, 2, 3, 255], [4, 5, 6, 255]]);
    assert_eq!(frames[1].frame.pixels(), [[1, 2, 3, 255], [9, 9, 9, 255]]);
    let span = Span { start: Rational::new(1, 30), length: Some(Rational::new(5, 100)) };
    assert_eq!(frames[1].span, span);

    fs::write(&file, &bytes[..bytes.len() - 30]).expect("written");
    let (frames, error) = read_broken(&file, &SourceOptions::default());
    assert!(frames == 1 && error.contains("too early"), "{frames}: {error}");
}

#[test]
fn animated_webp_is_composed_and_timed() {
    let folder = folder();
    let file = name(&folder, "a.webp");
    let frame = |seed, delay: u8| {
        let mut still = Vec::new();
        let image = patches(Size::new(10, 6), seed, false).into_image();
        image::codecs::webp::WebPEncoder::new_lossless(&mut still)
            .write_image(&image, 10, 6, image::ExtendedColorType::Rgba8)
            .expect("a WebP");
        // Without its file header the still is the frame's data.
        let head = [0, 0, 0, 0, 0, 0, 9, 0, 0, 5, 0, 0, delay, 0, 0, 2];
        chunk(b"ANMF", &[&head, &still[12..]].concat())
    };
    let extended = chunk(b"VP8X", &[0x02, 0, 0, 0, 9, 0, 0, 5, 0, 0]);
    let control = chunk(b"ANIM", &[0, 0, 0, 0, 2, 0]);
    let body = [b"WEBP".as_slice(), &extended, &control, &frame(1, 40), &frame(2, 40)].concat();
    let whole = chunk(b"RIFF", &body);
    fs::write(&file, &whole).expect("written");
    let (info, frames) = read_all(&file);
    assert_eq!((info.format.as_str(), info.frames, info.still), ("webp", Some(2), false));
    assert_eq!((info.loops, info.rate), (Loops::Times(2), Some(Rational::new(25, 1))));
    assert_eq!(frames.len(), 2);
    assert_eq!(frames[1].frame, patches(Size::new(10, 6), 2, false));
    assert_eq!(frames[1].span.start, Rational::new(4, 100));

    fs::write(&file, &whole[..whole.len() - 20]).expect("written");
    let (frames, error) = read_broken(&file, &SourceOptions::default());
    assert!(frames <= 1 && error.contains("too early"), "{frames}: {error}");
}

/// A chunk of a RIFF file.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let padding = &[0][..data.len() % 2];
    [kind.as_slice(), &(data.len() as u32).to_le_bytes(), data, padding].concat()
}

// Bad output.

#[test]
fn outputs_that_cannot_be_meant_are_told_before_any_work() {
    let folder = folder();
    let size = Size::new(4, 4);
    fs::write(name(&folder, "there.png"), b"x").expect("written");
    fs::create_dir(name(&folder, "folder.gif")).expect("a folder");
    for (output, frames, words) in [
        ("a.png", 5, "a_%04d.png"),
        ("a.png", 5, "a.gif"),
        ("a.txt", 1, ".png, .jpg"),
        ("a", 1, ".gif"),
        ("a_%d.gif", 5, ".webp"),
        ("there.png", 1, "-y"),
        ("missing/a.png", 1, "make it first"),
        ("missing/%04d.png", 5, "make it first"),
        ("missing/a.gif", 5, "make it first"),
        ("%04d/a.png", 5, "in the file's name"),
    ] {
        let output = name(&folder, output);
        let error = sink::create(&output, &info(size, frames), &SinkOptions::default())
            .err()
            .unwrap_or_else(|| panic!("{output} is refused"))
            .to_string();
        assert!(error.contains(words), "{output}: {error}");
    }
    let inputs = vec![PathBuf::from(name(&folder, "there.png"))];
    let options = SinkOptions { inputs, overwrite: true, ..SinkOptions::default() };
    let error = sink::create(&name(&folder, "there.png"), &info(size, 1), &options).err();
    assert!(error.expect("the input").to_string().contains("is the input"));
    assert_eq!(listed(folder.path()), ["folder.gif", "there.png"], "nothing new");
}

#[test]
fn sinks_that_are_dropped_leave_nothing() {
    let folder = folder();
    let frame = patches(Size::new(16, 16), 1, false);
    for output in ["a.png", "a.gif", "new/", "a_%04d.png"] {
        let frames = if output == "a.png" { 1 } else { 2 };
        let mut sink = sink::create(
            &name(&folder, output),
            &info(frame.size(), frames),
            &SinkOptions::default(),
        )
        .expect("a sink");
        for _ in 0..frames {
            sink.write(picture(frame.clone(), still_span())).expect("written");
        }
        drop(sink);
        assert_eq!(listed(folder.path()), [""; 0], "{output}");
    }
}

#[test]
fn null_takes_everything() {
    let frame = patches(Size::new(16, 16), 1, false);
    write("null:", &[frame.clone(), frame], &[4], &SinkOptions::default()).expect("discarded");
}
