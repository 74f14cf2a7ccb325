//! Bad input: one clear message, and the frames before it.

use std::fs;
use std::io::Cursor;

use image::{ImageFormat, RgbaImage};
use polyreel::error::Error;
use polyreel::geom::Size;
use polyreel::source::{self, SourceOptions};

use super::given::*;

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
fn what_is_not_a_picture_is_named() {
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
        // A GIF without its last two bytes has all its pixels.
        let end = whole.len() - if extension == "gif" { 4 } else { 1 };
        for length in (1..end).step_by(whole.len() / 40 + 1) {
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
            assert!(error.is_some(), "{cut}: the error comes with what was kept");
            let expected = read_one(&file);
            assert_eq!(frames[0].frame.row(5), expected.row(5), "{cut}");
        }
    }
}

/// The error of reading `file` with default options.
fn error_of(file: &str) -> Error {
    let read = || {
        let mut source = source::open(&[file], &SourceOptions::default())?.start()?;
        while source.next()?.is_some() {}
        Ok(())
    };
    let read: Result<(), Error> = read();
    read.expect_err(file)
}

#[test]
fn the_cause_of_an_input_that_cannot_be_read_is_typed() {
    let folder = folder();
    let frame = patches(Size::new(64, 64), 3, true);
    for extension in ["png", "jpg", "webp", "bmp", "tiff", "gif"] {
        let file = name(&folder, &format!("whole.{extension}"));
        write_still(&file, &frame).expect("written");
        let whole = fs::read(&file).expect("a file");
        fs::write(&file, &whole[..whole.len() * 9 / 10]).expect("written");
        let error = error_of(&file);
        // A TIFF keeps its directory at the end.
        assert!(error.is_truncation() || extension == "tiff", "{error}: {error:?}");
    }
    let file = name(&folder, "cut.y4m");
    fs::write(&file, b"YUV4MPEG2 W4 H4 F25:1 C420jpeg\nFRAME\nabc").expect("written");
    assert!(error_of(&file).is_truncation());
    fs::write(&file, b"YUV4MPEG2 W2 H2 F25:1 Cmono\nFRAME\nabcdFROMM\nabcd").expect("written");
    assert!(error_of(&file).is_corruption());

    let file = name(&folder, "broken.png");
    write_still(&file, &frame).expect("written");
    let mut bytes = fs::read(&file).expect("a file");
    let middle = bytes.len() / 2;
    bytes[middle..middle + 20].iter_mut().for_each(|byte| *byte ^= 0x55);
    fs::write(&file, &bytes).expect("written");
    let error = error_of(&file);
    assert!(error.is_corruption(), "{error}: {error:?}");

    let file = name(&folder, "broken.gif");
    fs::write(
        &file,
        b"GIF89a\x02\0\x01\0\x80\0\0\0\0\0\xff\xff\xff,\0\0\0\0\x02\0\x01\0\0\x02\x02\xff\xff\0;",
    )
    .expect("written");
    let error = error_of(&file);
    assert!(error.breaks_off(), "{error}: {error:?}");

    let error = error_of(&name(&folder, "missing.png"));
    assert!(!error.breaks_off());
    assert_eq!(error.io_kind(), Some(std::io::ErrorKind::NotFound));
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
