//! GIF out.

use std::fs;
use std::io::Cursor;

use image::AnimationDecoder;
use polyreel::frame::{Frame, Rational, Rgba};
use polyreel::geom::Size;
use polyreel::sink::SinkOptions;
use polyreel::stream::Loops;

use super::given::*;

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
        assert_eq!(info.alpha, frames.iter().any(|f| !f.is_opaque()), "seed {seed}");
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
