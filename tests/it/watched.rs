//! What the pipeline offers to those who look on: sources that wait, sinks that see where a picture
//! comes from.

use std::sync::{Arc, Mutex};

use polyreel::error::Result;
use polyreel::frame::{Buffers, Frame, Rational};
use polyreel::geom::Size;
use polyreel::options::{Edges, Options, Points};
use polyreel::pipeline::{self, Settings, Stop};
use polyreel::rasterise::rasterise;
use polyreel::sink::{Needs, Origin, Picture, Sink};
use polyreel::source::{Decoded, Source};
use polyreel::stream::Span;

const SIZE: Size = Size::new(60, 40);

/// A gradient that changes with `t`.
fn frame(t: usize) -> Frame {
    let pixel = |i: usize| [(i % 60 * 4) as u8, (i / 60 * 6) as u8, (i * (t + 2) / 9) as u8, 255];
    Frame::new(SIZE, (0..SIZE.pixels()).map(pixel).collect()).expect("a frame")
}

/// Three frames; each must be waited for, once.
#[derive(Default)]
struct Slow {
    waited: usize,
    given: usize,
}

impl Source for Slow {
    fn wait(&mut self) {
        self.waited += 1;
    }

    fn next(&mut self) -> Result<Option<Decoded>> {
        assert_eq!(self.waited, self.given + 1, "a frame is waited for before it is asked for");
        self.given += 1;
        let start = Rational::new(self.given as i64, 10);
        let span = Span { start, length: None };
        Ok((self.given <= 3).then(|| Decoded::new(frame(self.given), span)))
    }
}

type Seen = Arc<Mutex<Vec<(Picture, Option<Origin>)>>>;

/// Keeps everything.
struct Watching {
    seen: Seen,
    wants: bool,
}

impl Sink for Watching {
    fn needs(&self) -> Needs {
        Needs { origin: self.wants, ..Needs::default() }
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        self.seen.lock().expect("nobody panicked").push((picture, origin));
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}

fn seen(wants: bool) -> Vec<(Picture, Option<Origin>)> {
    let seen = Seen::default();
    let sink = Box::new(Watching { seen: seen.clone(), wants });
    let options = Options { points: Points::Count(40), coherence: 0.0, ..Options::default() };
    let settings = Settings { options, ..Settings::default() };
    let start = || Ok(Box::<Slow>::default() as Box<dyn Source>);
    pipeline::run(start, sink, &settings, &mut (), &Stop::default()).expect("a run");
    std::mem::take(&mut *seen.lock().expect("nobody panicked"))
}

#[test]
fn a_sink_that_wants_to_sees_what_its_pictures_were_made_from() {
    let seen = seen(true);
    assert_eq!(seen.len(), 3);
    for (t, (picture, origin)) in seen.into_iter().enumerate() {
        let Origin { frame: source, mesh } = origin.expect("it was asked for");
        assert_eq!(source, frame(t + 1));
        assert_eq!(mesh.check(), Ok(()));
        assert_eq!(rasterise(&mesh, &source, Edges::Smooth, None).frame, picture.frame);
    }
}

#[test]
fn a_sink_that_does_not_gets_the_picture_alone() {
    let (with, without) = (seen(true), seen(false));
    assert!(without.iter().all(|(_, origin)| origin.is_none()));
    let pictures = |seen: Vec<(Picture, _)>| seen.into_iter().map(|(p, _)| p).collect::<Vec<_>>();
    assert_eq!(pictures(with), pictures(without));
}
