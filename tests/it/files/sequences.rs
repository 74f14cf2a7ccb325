//! Sequences of pictures.

use std::fs;

use polyreel::frame::{Frame, Rational};
use polyreel::geom::Size;
use polyreel::sink::SinkOptions;
use polyreel::source::SourceOptions;

use super::given::*;

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

#[test]
fn animations_in_a_sequence_are_refused_alike() {
    let folder = folder();
    let frames: Vec<Frame> = (0..2).map(|i| patches(Size::new(12, 10), i, false)).collect();
    write(&name(&folder, "f_%d.png"), &frames, &[4], &SinkOptions::default()).expect("written");
    let file = |number: usize| folder.path().join(format!("f_{number}.png"));
    let apng = super::formats::apng(&[(Size::new(12, 10), (0, 0), 0, 0); 2], 8, false);
    let webp = super::formats::webp(&[(0, 0), (0, 0)]);
    for (animation, words) in [(apng, "an APNG"), (webp, "an animated WebP")] {
        fs::write(file(3), animation).expect("a file");
        let (_, error) = read_broken(&name(&folder, "f_%d.png"), &SourceOptions::default());
        let expected = format!("frame 2: {words} cannot be one picture of a sequence");
        assert!(error.contains(&expected), "{error}");
    }
    write(&name(&folder, "a.gif"), &frames, &[4], &SinkOptions::default()).expect("written");
    fs::rename(name(&folder, "a.gif"), file(3)).expect("renamed");
    let (_, error) = read_broken(&name(&folder, "f_%d.png"), &SourceOptions::default());
    assert!(error.contains("frame 2: a GIF cannot be one picture of a sequence"), "{error}");
}
