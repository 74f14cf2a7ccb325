//! Inputs read round after round, and from the middle.

use polyreel::error::Result;
use polyreel::frame::{Frame, Rational};
use polyreel::geom::Size;
use polyreel::sink::{self, SinkOptions};
use polyreel::source::{self, Decoded, Input, SourceOptions};
use polyreel::stream::{Span, StreamInfo};

use super::given::{self, folder, name};

/// Ten pictures, 10 a second, as `file`.
fn write(file: &str) {
    let size = Size::new(20, 16);
    let pixels = |t: u8| (0..size.pixels()).map(move |i| [20 * t, (i / 20 * 9) as u8, 90, 255]);
    let frame = |t| Frame::new(size, pixels(t).collect()).expect("a frame");
    let tenth = Rational::new(1, 10);
    let info = StreamInfo { rate: tenth.recip(), ..given::info(size, 10) };
    let mut sink = sink::create(file, &info, &SinkOptions::default()).expect("a sink");
    for t in 0..10 {
        let span = Span { start: Rational::new(t.into(), 10), length: Some(tenth) };
        sink.write(given::picture(frame(t), span), None).expect("written");
    }
    sink.finish().expect("finished");
}

fn round(input: &mut Input, from: Rational) -> Result<Vec<Decoded>> {
    let mut source = input.restart()?;
    source.skip_to(from);
    let mut frames = Vec::new();
    while let Some(decoded) = source.next()? {
        frames.push(decoded);
    }
    Ok(frames)
}

#[test]
fn files_are_the_same_in_every_round_and_can_be_entered_in_the_middle() {
    let folder = folder();
    let half = Rational::new(1, 2);
    for file in ["ten.gif", "ten.y4m", "ten_%02d.png"] {
        let file = name(&folder, file);
        write(&file);
        let fps = Rational::new(10, 1);
        let all = SourceOptions { fps: Some(fps), ..SourceOptions::default() };
        let part =
            SourceOptions { start: Some(Rational::new(3, 10)), max_size: Some(10), ..all.clone() };
        for (options, frames) in [(all, 10), (part, 7)] {
            let mut input = source::open(std::slice::from_ref(&file), &options).expect("an input");
            assert!(input.repeats(), "{file}");
            let first = round(&mut input, Rational::ZERO).expect("a round");
            assert_eq!(first.len(), frames, "{file}");
            assert_eq!(round(&mut input, Rational::ZERO).expect("another"), first, "{file}");
            // Formats may leave out what comes before, or not: what comes after is the same.
            let later = |frames: &[Decoded]| {
                frames.iter().filter(|d| d.span.start >= half).cloned().collect::<Vec<_>>()
            };
            let entered = round(&mut input, half).expect("from the middle");
            assert_eq!(later(&entered), later(&first), "{file}");
            assert!(!later(&first).is_empty());
        }
    }
}

#[test]
fn nothing_is_left_at_the_end_and_that_is_no_error() {
    let folder = folder();
    let file = name(&folder, "ten.gif");
    write(&file);
    let options = SourceOptions { start: Some(Rational::new(3, 10)), ..SourceOptions::default() };
    let mut input = source::open(&[file], &options).expect("an input");
    let late = round(&mut input, Rational::new(9, 1)).expect("an empty end");
    assert!(late.iter().all(|decoded| decoded.span.start < Rational::new(1, 1)));
}
