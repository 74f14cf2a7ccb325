//! Video as planes, from the source to the sink, against the same as pixels.

use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex};

use polyreel::colour::{
    Coding, Form, Layout, Matrix, Planes, Range, Sampling, Siting, from_rgba, to_rgba,
};
use polyreel::error::Result;
use polyreel::frame::{Buffers, Frame, Rational};
use polyreel::geom::Size;
use polyreel::options::{Edges, Options, Points};
use polyreel::pipeline::{Settings, Stop, run};
use polyreel::render::{Rendered, Renderer};
use polyreel::sink::{Needs, Origin, Picture, Sink};
use polyreel::source::{Decoded, Source};
use polyreel::stream::Span;

const SIZE: Size = Size::new(160, 98);
const FRAMES: u32 = 12;

const FORM: Form = Form {
    layout: Layout { size: SIZE, sampling: Sampling::Yuv420, siting: Siting::Left, alpha: false },
    coding: Coding { matrix: Matrix::Bt709, range: Range::Limited },
};

/// A disc that wanders over a gradient, with a shade that grows.
fn film() -> Vec<Frame> {
    let pixel = |number: u32, x: u32, y: u32| {
        let centre = (20.0 + 9.0 * f64::from(number), 40.0 + 2.0 * f64::from(number));
        if (f64::from(x) - centre.0).hypot(f64::from(y) - centre.1) < 17.0 {
            [200, 30, (y * 2) as u8, 255]
        } else {
            [x as u8, (y * 2) as u8, (40 + 9 * number + x / 40 * 30) as u8, 255]
        }
    };
    let planar = |number: u32| {
        let places = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
        let pixels: Vec<_> = places.map(|(x, y)| pixel(number, x, y)).collect();
        let mut data = Vec::new();
        from_rgba(SIZE, &pixels, &FORM.layout, FORM.coding, &mut data);
        Frame::planar(Planes { form: FORM, data }, Vec::new()).expect("even sides")
    };
    (0..FRAMES).map(planar).collect()
}

/// The default options and those without refinement.
fn kinds() -> [Options; 2] {
    let options = Options { points: Points::Count(250), ..Options::default() };
    [options.clone(), Options { refine: Some(0), ..options }]
}

fn render(options: &Options, form: Option<Form>, film: &[Frame]) -> Vec<Rendered> {
    let mut renderer = Renderer::new(options).expect("sound options").with_form(form);
    film.iter().map(|frame| renderer.render(frame).expect("renders")).collect()
}

struct Film(std::vec::IntoIter<Frame>);

impl Source for Film {
    fn next(&mut self) -> Result<Option<Decoded>> {
        let span = Span { start: Rational::new(self.0.len() as i64, 1), length: None };
        Ok(self.0.next().map(|frame| Decoded::new(frame, span)))
    }
}

#[derive(Clone, Default)]
struct Screen(Arc<Mutex<Vec<Frame>>>);

impl Sink for Screen {
    fn needs(&self) -> Needs {
        Needs { form: Some(FORM), ..Needs::default() }
    }

    fn write(&mut self, picture: Picture, _: Option<Origin>) -> Result<Buffers> {
        self.0.lock().expect("the lock").push(picture.frame);
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}

#[test]
fn threads_paint_the_planes_of_the_serial_renderer() {
    for options in kinds() {
        let serial = render(&options, Some(FORM), &film());
        for threads in [1, 2, 8] {
            let threads = NonZeroUsize::new(threads);
            let settings = Settings { options: options.clone(), threads, ..Settings::default() };
            let screen = Screen::default();
            let start = || Ok(Box::new(Film(film().into_iter())) as Box<dyn Source>);
            let sink = Box::new(screen.clone());
            run(start, sink, &settings, &mut (), &Stop::default()).expect("runs");
            let shown = screen.0.lock().expect("the lock");
            assert_eq!(shown.len(), serial.len());
            for (shown, serial) in shown.iter().zip(&serial) {
                assert!(shown.planes().is_some());
                assert!(shown.planes() == serial.picture.planes(), "planes differ");
            }
        }
    }
}

#[test]
fn the_mesh_does_not_depend_on_how_pictures_are_wanted() {
    let full = Coding { range: Range::Full, ..FORM.coding };
    for options in kinds() {
        let as_planes = render(&options, Some(FORM), &film());
        for other in [None, Some(Form { coding: full, ..FORM })] {
            let others = render(&options, other, &film());
            for (planes, other) in as_planes.iter().zip(&others) {
                assert!(planes.mesh == other.mesh);
                assert!(planes.mesh.fills == other.mesh.fills);
            }
        }
    }
}

#[test]
fn planes_are_those_of_the_pixels() {
    for (options, edges) in kinds().into_iter().flat_map(|o| Edges::ALL.map(|e| (o.clone(), e))) {
        let options = Options { edges, ..options };
        let as_planes = render(&options, Some(FORM), &film());
        for (planes, pixels) in as_planes.iter().zip(render(&options, None, &film())) {
            let mut wanted = Vec::new();
            let pixels = pixels.picture;
            from_rgba(SIZE, pixels.pixels(), &FORM.layout, FORM.coding, &mut wanted);
            let planes = planes.picture.planes().expect("planes were wanted");
            // Of smooth edges chroma has no more than what it is a mean over in any case.
            let alike = if edges == Edges::Smooth { SIZE.pixels() } else { wanted.len() };
            let pairs = planes.data.iter().zip(&wanted).take(alike);
            let off = pairs.map(|(a, b)| a.abs_diff(*b)).max();
            // Colours are rounded before they are mixed.
            assert!(off <= Some(1), "{off:?}");
        }
    }
}

#[test]
fn pixels_that_are_there_already_change_nothing() {
    for options in kinds() {
        let bare = render(&options, Some(FORM), &film());
        assert!(bare[1..].iter().any(|rendered| rendered.life.born > 0), "rows were looked at");
        let made = film();
        made.iter().for_each(|frame| assert_eq!(frame.pixels().len(), SIZE.pixels()));
        assert!(bare == render(&options, Some(FORM), &made));
    }
}

#[test]
fn planes_look_like_their_pixels() {
    let pixels = |frame: &Frame| {
        let planes = frame.planes().expect("planes");
        let mut pixels = Vec::new();
        to_rgba(&FORM.layout, FORM.coding, &planes.data, &mut pixels);
        Frame::new(SIZE, pixels).expect("as many as there are")
    };
    let error = |frames: &[Frame], options: &Options| {
        let rendered = render(options, None, frames);
        let pairs = rendered.iter().zip(frames);
        let errors = pairs.map(|(rendered, frame)| {
            polyreel::metric::mse::mse(&rendered.picture, frame).expect("one size")
        });
        errors.sum::<f64>() / f64::from(FRAMES)
    };
    for options in kinds() {
        let as_pixels: Vec<_> = film().iter().map(pixels).collect();
        let (planes, pixels) = (error(&film(), &options), error(&as_pixels, &options));
        assert!((planes / pixels - 1.0).abs() < 0.05, "{planes}, as pixels {pixels}");
    }
}

#[test]
fn what_planes_cannot_tell_comes_as_pixels() {
    let [_, options] = kinds();
    let lined = Options { outline: Some("#000000".parse().expect("a colour")), ..options.clone() };
    let clear: Vec<_> =
        film().iter().map(|_| Frame::filled(SIZE, [9, 9, 9, 128]).expect("a frame")).collect();
    for (options, film) in [(&lined, &film()), (&options, &clear)] {
        for rendered in render(options, Some(FORM), film) {
            assert!(rendered.picture.planes().is_none());
        }
    }
}
