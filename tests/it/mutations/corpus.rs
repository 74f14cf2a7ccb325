//! What is mutated: small files of every format that is read without ffmpeg, made here.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageEncoder, ImageFormat, RgbaImage};
use polyreel::options::{Detail, Options, Points};
use polyreel::pipeline::{self, Settings, Stop};
use polyreel::sink::{self, SinkOptions};
use polyreel::source::{self, SourceOptions};

use super::mend::{self, crc32};

/// A sound file.
pub(super) struct Seed {
    pub(super) extension: &'static str,
    pub(super) bytes: Vec<u8>,
    pub(super) used_as: Use,
    /// What makes checksums right, where the format has any.
    pub(super) mend: Option<fn(&mut [u8])>,
}

/// What a file is given to the program as.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Use {
    Input,
    Preset,
    Report,
}

/// All seeds. Files that are needed to make them are put into `folder`.
pub(super) fn seeds(folder: &Path) -> Vec<Seed> {
    let input = |extension, bytes| Seed {
        extension,
        bytes,
        used_as: Use::Input,
        mend: match extension {
            "png" => Some(mend::png),
            "polyreel" => Some(mend::mesh_stream),
            _ => None,
        },
    };
    let mut seeds = vec![
        input("png", still(ImageFormat::Png, true)),
        input("jpg", still(ImageFormat::Jpeg, false)),
        input("bmp", still(ImageFormat::Bmp, false)),
        input("tiff", still(ImageFormat::Tiff, true)),
        input("webp", still(ImageFormat::WebP, true)),
        input("ppm", still(ImageFormat::Pnm, false)),
        input("gif", gif()),
        input("png", apng()),
        input("webp", animated_webp()),
        input("y4m", y4m()),
        input("polyreel", mesh_stream(folder)),
    ];
    let preset = Options { points: Points::Count(300), saturation: 1.5, ..Options::default() };
    let preset = polyreel::preset::to_toml(&preset).expect("plain data").into_bytes();
    seeds.push(Seed { extension: "toml", bytes: preset, used_as: Use::Preset, mend: None });
    seeds.push(Seed { extension: "json", bytes: report(), used_as: Use::Report, mend: None });
    // That they are sound is worth knowing: of what is broken anyway, mutations say little.
    for (n, seed) in seeds.iter().enumerate().filter(|(_, seed)| seed.used_as == Use::Input) {
        let path = folder.join(format!("seed-{n}.{}", seed.extension));
        std::fs::write(&path, &seed.bytes).expect("a writable folder");
        let input = polyreel::source::open(&[&path], &Default::default()).expect("a sound seed");
        let mut source = input.start().expect("a sound seed");
        while source.next().expect("a sound seed").is_some() {}
    }
    seeds
}

/// A small picture that changes with `t`.
fn picture(t: u32) -> RgbaImage {
    RgbaImage::from_fn(20, 14, |x, y| {
        let alpha = if (x + t).is_multiple_of(9) { 0 } else { 255 };
        image::Rgba([(x * 12) as u8, (y * 17) as u8, ((x / 4 + y / 4 + t) % 2 * 200) as u8, alpha])
    })
}

fn still(format: ImageFormat, alpha: bool) -> Vec<u8> {
    let picture = DynamicImage::from(picture(0));
    let picture = if alpha { picture } else { picture.into_rgb8().into() };
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).expect("a picture");
    bytes.into_inner()
}

fn gif() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = image::codecs::gif::GifEncoder::new(&mut bytes);
    encoder.set_repeat(image::codecs::gif::Repeat::Infinite).expect("a GIF");
    for t in 0..3 {
        let delay = image::Delay::from_numer_denom_ms(40, 1);
        let frame = image::Frame::from_parts(picture(t), 0, 0, delay);
        encoder.encode_frame(frame).expect("a GIF");
    }
    drop(encoder);
    bytes
}

/// An animated PNG of three frames, made of the data of three stills.
fn apng() -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let chunk = |out: &mut Vec<u8>, kind: &[u8; 4], data: &[u8]| {
        let body = [&kind[..], data].concat();
        out.extend((data.len() as u32).to_be_bytes());
        out.extend(&body);
        out.extend(crc32(&body).to_be_bytes());
    };
    let mut number = 0u32;
    for t in 0..3 {
        let mut still = Vec::new();
        let picture = picture(t);
        let (width, height) = picture.dimensions();
        image::codecs::png::PngEncoder::new(&mut still)
            .write_image(&picture, width, height, image::ExtendedColorType::Rgba8)
            .expect("a PNG");
        if t == 0 {
            chunk(&mut out, b"IHDR", &still[16..29]);
            chunk(&mut out, b"acTL", &[0, 0, 0, 3, 0, 0, 0, 0]);
        }
        let mut control = number.to_be_bytes().to_vec();
        control.extend([width, height, 0, 0].map(u32::to_be_bytes).concat());
        control.extend([0, 4, 0, 100, (t % 3) as u8, (t % 2) as u8]);
        chunk(&mut out, b"fcTL", &control);
        number += 1;
        let mut at = 33;
        while at + 12 <= still.len() {
            let length =
                u32::from_be_bytes(still[at..at + 4].try_into().expect("four bytes")) as usize;
            if &still[at + 4..at + 8] == b"IDAT" {
                let data = &still[at + 8..at + 8 + length];
                if t == 0 {
                    chunk(&mut out, b"IDAT", data);
                } else {
                    chunk(&mut out, b"fdAT", &[&number.to_be_bytes()[..], data].concat());
                    number += 1;
                }
            }
            at += 12 + length;
        }
    }
    chunk(&mut out, b"IEND", &[]);
    out
}

/// An animated WebP of two lossless frames.
fn animated_webp() -> Vec<u8> {
    let chunk = |kind: &[u8; 4], data: &[u8]| {
        let mut chunk = [&kind[..], &(data.len() as u32).to_le_bytes(), data].concat();
        chunk.extend(&[0][..data.len() % 2]);
        chunk
    };
    let frame = |t: u32| {
        let still = still_webp(t);
        let head = [0, 0, 0, 0, 0, 0, 19, 0, 0, 13, 0, 0, 40, 0, 0, (t % 4) as u8];
        chunk(b"ANMF", &[&head[..], &still[12..]].concat())
    };
    let body = [
        b"WEBP".to_vec(),
        chunk(b"VP8X", &[0x12, 0, 0, 0, 19, 0, 0, 13, 0, 0]),
        chunk(b"ANIM", &[0, 0, 0, 0, 0, 0]),
        frame(0),
        frame(1),
    ]
    .concat();
    chunk(b"RIFF", &body)
}

fn still_webp(t: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    image::codecs::webp::WebPEncoder::new_lossless(&mut bytes)
        .write_image(&picture(t), 20, 14, image::ExtendedColorType::Rgba8)
        .expect("a WebP");
    bytes
}

fn y4m() -> Vec<u8> {
    let mut bytes = b"YUV4MPEG2 W20 H14 F25:1 Ip A1:1 C420jpeg\n".to_vec();
    for t in 0..3u8 {
        bytes.extend(b"FRAME\n");
        bytes.extend((0..20 * 14 * 3 / 2).map(|i| (i as u8).wrapping_mul(3).wrapping_add(40 * t)));
    }
    bytes
}

/// The meshes of the GIF.
fn mesh_stream(folder: &Path) -> Vec<u8> {
    let (from, to) = (folder.join("meshes.gif"), folder.join("meshes.polyreel"));
    std::fs::write(&from, gif()).expect("a writable folder");
    let input = source::open(&[&from], &SourceOptions::default()).expect("a sound GIF");
    let sink = sink::create(&to, input.info(), &SinkOptions::default()).expect("a mesh stream");
    let options = Options { points: Points::Count(30), ..Options::default() };
    let settings = Settings { options, ..Settings::default() };
    pipeline::run(move || input.start(), sink, &settings, &mut (), &Stop::default())
        .expect("a run");
    std::fs::read(&to).expect("its output")
}

fn report() -> Vec<u8> {
    let frames: Vec<_> = (0..3)
        .map(|index| serde_json::json!({"index": index, "orders": Detail::FULL, "detail": 1.0}))
        .collect();
    let report = serde_json::json!({
        "options": Options::default(), "frames": 3, "per_frame": frames,
    });
    report.to_string().into_bytes()
}
