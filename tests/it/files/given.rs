//! What the tests share: pictures, and ways to write and read them.

use std::fs;
use std::path::Path;

use polyreel::chance::{Purpose, rank};
use polyreel::error::{Error, Result};
use polyreel::frame::{Fill, Frame, Rational, Rgba};
use polyreel::geom::Size;
use polyreel::sink::{self, Picture, SinkOptions};
use polyreel::source::{self, Decoded, SourceOptions};
use polyreel::stream::{Loops, Span, StreamInfo};
use tempfile::TempDir;

pub(crate) fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

pub(crate) fn name(folder: &TempDir, file: &str) -> String {
    folder.path().join(file).to_string_lossy().into_owned()
}

pub(crate) fn listed(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// All frames up to the end or an error.
pub(crate) fn read(
    input: &str,
    options: &SourceOptions,
) -> (Option<StreamInfo>, Vec<Decoded>, Option<Error>) {
    let opened = match source::open(&[input.to_owned()], options) {
        Ok(opened) => opened,
        Err(e) => return (None, Vec::new(), Some(e)),
    };
    let info = opened.info().clone();
    let mut frames = Vec::new();
    let all = || -> Result<()> {
        let mut source = opened.start()?;
        while let Some(decoded) = source.next()? {
            assert_eq!(decoded.frame.size(), info.size, "the size that the header gave");
            frames.push(decoded);
        }
        Ok(())
    };
    let error = all().err();
    (Some(info), frames, error)
}

pub(crate) fn read_all(input: &str) -> (StreamInfo, Vec<Decoded>) {
    let (info, frames, error) = read(input, &SourceOptions::default());
    assert!(error.is_none(), "{input}: {}", error.expect("an error"));
    (info.expect("a header"), frames)
}

pub(crate) fn read_one(input: &str) -> Frame {
    let (info, mut frames) = read_all(input);
    assert!(info.still && frames.len() == 1, "{input} is a still");
    frames.remove(0).frame
}

/// The error and the number of frames before it.
pub(crate) fn read_broken(input: &str, options: &SourceOptions) -> (usize, String) {
    let (_, frames, error) = read(input, options);
    (frames.len(), error.unwrap_or_else(|| panic!("{input} is not broken")).to_string())
}

pub(crate) fn random(seed: u64, x: u32, y: u32) -> u64 {
    rank(seed, Purpose::Noise, x, y)
}

/// Squares of flat colours; some of them transparent if `alpha`.
pub(crate) fn patches(size: Size, seed: u64, alpha: bool) -> Frame {
    let pixels = (0..size.height)
        .flat_map(|y| (0..size.width).map(move |x| (x, y)))
        .map(|(x, y)| {
            let [r, g, b, a, ..] = random(seed, x / 5, y / 5).to_le_bytes();
            [r & 0xf0, g & 0xf0, b & 0x80, if alpha && a < 90 { 0 } else { 255 }]
        })
        .collect();
    Frame::new(size, pixels).expect("a frame")
}

pub(crate) fn picture(frame: Frame, span: Span) -> Picture {
    let mut colours: Vec<Rgba> = frame.pixels().to_vec();
    colours.sort_unstable();
    let fills = colours
        .chunk_by(|a, b| a == b)
        .map(|run| Fill { colour: run[0], area: run.len() as u32 })
        .collect();
    Picture { frame, fills, span }
}

pub(crate) fn still_span() -> Span {
    Span { start: Rational::ZERO, length: None }
}

pub(crate) fn info(size: Size, frames: u64) -> StreamInfo {
    StreamInfo {
        // Delays of a GIF are kept exactly.
        format: "gif".into(),
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
pub(crate) fn write(
    output: &str,
    frames: &[Frame],
    hundredths: &[i64],
    options: &SinkOptions,
) -> Result<()> {
    let mut sink = sink::create(output, &info(frames[0].size(), frames.len() as u64), options)?;
    let mut start = Rational::ZERO;
    for (frame, &delay) in frames.iter().zip(hundredths.iter().cycle()) {
        let length = Rational::new(delay, 100);
        sink.write(picture(frame.clone(), Span { start, length: Some(length) }), None)?;
        start = start + length;
    }
    sink.finish()
}

pub(crate) fn write_still(output: &str, frame: &Frame) -> Result<()> {
    let mut sink = sink::create(output, &info(frame.size(), 1), &SinkOptions::default())?;
    sink.write(picture(frame.clone(), still_span()), None)?;
    sink.finish()
}

/// What a GIF makes of a frame that has few colours.
pub(crate) fn thresholded(frame: &Frame) -> Vec<Rgba> {
    let one = |&[r, g, b, a]: &Rgba| if a < 128 { [0; 4] } else { [r, g, b, 255] };
    frame.pixels().iter().map(one).collect()
}

pub(crate) fn psnr(a: &Frame, b: &Frame) -> f64 {
    let square = |(p, q): (&Rgba, &Rgba)| {
        (0..3).map(|i| f64::from(p[i]) - f64::from(q[i])).map(|d| d * d).sum::<f64>()
    };
    let sum: f64 = a.pixels().iter().zip(b.pixels()).map(square).sum();
    10.0 * (255.0 * 255.0 * 3.0 * a.pixels().len() as f64 / sum).log10()
}

/// A PNG of chunks.
pub(crate) fn png(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
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
pub(crate) fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &b| {
        (0..8).fold(
            crc ^ u32::from(b),
            |c, _| {
                if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 }
            },
        )
    })
}

/// A zlib stream, not compressed.
pub(crate) fn stored(bytes: &[u8]) -> Vec<u8> {
    let (a, b) = bytes.iter().fold((1u32, 0u32), |(a, b), &v| {
        let a = (a + u32::from(v)) % 65521;
        (a, (b + a) % 65521)
    });
    let mut out = vec![0x78, 0x01];
    let blocks = bytes.len().div_ceil(0xffff).max(1);
    for block in 0..blocks {
        let part = &bytes[block * 0xffff..bytes.len().min((block + 1) * 0xffff)];
        out.push(u8::from(block + 1 == blocks));
        out.extend((part.len() as u16).to_le_bytes());
        out.extend((!(part.len() as u16)).to_le_bytes());
        out.extend(part);
    }
    out.extend(((b << 16) | a).to_be_bytes());
    out
}
