//! GIF in.

use std::fs;
use std::io::Cursor;

use image::AnimationDecoder;
use polyreel::frame::Rational;
use polyreel::geom::Size;
use polyreel::source::SourceOptions;

use super::given::*;

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
        let alpha = frames.iter().any(|f| !f.frame.is_opaque());
        assert!(info.alpha || !alpha, "seed {seed} has alpha and does not say so");
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
    let (mut most, mut unnoticed) = (0, 0);
    for length in (10..whole.len()).step_by(37) {
        fs::write(&file, &whole[..length]).expect("written");
        let (_, frames, error) = read(&file, &SourceOptions::default());
        match error {
            Some(error) => assert!(error.to_string().contains("too early"), "{length}: {error}"),
            // All pixels of the frames that are there may have come.
            None => unnoticed += 1,
        }
        assert!(frames == all[..frames.len()], "{length} of {} bytes", whole.len());
        most = most.max(frames.len());
        let allow = SourceOptions { allow_truncated: true, ..SourceOptions::default() };
        let (_, kept, error) = read(&file, &allow);
        assert!(kept.len() >= frames.len() && (error.is_some() || kept == frames), "{length}");
    }
    assert!(unnoticed <= 3, "{unnoticed} cuts");
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
