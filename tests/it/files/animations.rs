//! Animated PNG and WebP in.

use std::fs;

use image::ImageEncoder;
use polyreel::frame::Rational;
use polyreel::geom::Size;
use polyreel::source::SourceOptions;
use polyreel::stream::{Loops, Span};

use super::formats::chunk;
use super::given::*;

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
