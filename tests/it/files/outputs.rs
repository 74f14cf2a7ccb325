//! Bad output, and outputs that are given up.

use std::fs;
use std::path::PathBuf;

use polyreel::colour::Range;
use polyreel::frame::Colorimetry;
use polyreel::geom::Size;
use polyreel::sink::{self, SinkOptions};
use polyreel::stream::StreamInfo;

use super::given::*;

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
    let error = sink::create(name(&folder, "there.png"), &info(size, 1), &options).err();
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
            name(&folder, output),
            &info(frame.size(), frames),
            &SinkOptions::default(),
        )
        .expect("a sink");
        for _ in 0..frames {
            sink.write(picture(frame.clone(), still_span()), None).expect("written");
        }
        drop(sink);
        assert_eq!(listed(folder.path()), [""; 0], "{output}");
    }
}

/// As it would be for a real output: what is measured is what it takes.
#[test]
fn null_takes_a_video_as_planes_and_all_else_as_pixels() {
    let size = Size::new(64, 48);
    let form = |info: &StreamInfo| {
        let sink = sink::create("null:", info, &SinkOptions::default()).expect("nothing can fail");
        sink.needs().form
    };
    let pixels = info(size, 9);
    assert_eq!(form(&pixels), None);
    let tags = Colorimetry { range: Some("pc".into()), ..Colorimetry::default() };
    let video = StreamInfo { colour: Some(tags), ..info(size, 9) };
    let planes = form(&video).expect("even sides");
    assert_eq!((planes.layout.size, planes.coding.range), (size, Range::Full));
    assert_eq!(form(&StreamInfo { size: Size::new(63, 48), ..video }), None);
}

#[test]
fn null_takes_everything() {
    let frame = patches(Size::new(16, 16), 1, false);
    write("null:", &[frame.clone(), frame], &[4], &SinkOptions::default()).expect("discarded");
}
