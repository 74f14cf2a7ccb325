//! Stills, out and in.

use std::fs;
use std::io::Cursor;

use image::{DynamicImage, ImageEncoder, ImageFormat, RgbaImage};
use polyreel::frame::Frame;
use polyreel::geom::Size;
use polyreel::sink::SinkOptions;

use super::given::*;

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
