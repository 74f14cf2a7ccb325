//! What triangles are filled with, and the picture that they make.

mod antialias;
mod canvas;
mod cells;
pub mod colours;
mod gouraud;
mod grade;
mod gradient;
mod known;
mod lines;
mod median;
mod per_thread;
mod planar;
mod sparse;
mod stretch;
mod strokes;
mod style;
mod tally;
mod wanted;

use crate::parallel::prelude::*;

use crate::colour::Form;
use crate::frame::{Buffers, Fill, Frame, Rgba};
use crate::geom::Point;
use crate::mesh::Mesh;
use crate::options::{Edges, FillMode, Options, Shape};
use crate::residual::{Residual, ResidualRequest};
use crate::simd::dispatch;
use canvas::Canvas;
use cells::Panes;
use colours::Colours;
use gradient::Gradient;
use sparse::sparse_means;
use style::Style;
use tally::Tally;

pub use grade::Grade;
pub use known::{Outlined, outlined};
pub use stretch::stretch;

/// A painted mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Painting {
    /// The low-poly picture.
    pub frame: Frame,
    /// The colours of the picture where edges are hard, with their areas in pixels: one for each triangle, in the
    /// triangles' order (areas without outlines), then the outline's.
    pub fills: Vec<Fill>,
}

/// Results of the mesh stage that help to paint a mesh, and its request for a residual.
#[derive(Clone, Debug, Default)]
pub struct PaintHints {
    /// Whether the mesh is fresh: its triangles are not those of the last frame.
    pub is_fresh: bool,
    /// The mean colours in the form of [`Refined::fills`](crate::refine::Refined::fills), or empty.
    pub fills: Vec<Fill>,
    /// The request for a residual. Frames that are not opaque have none.
    pub residual: Option<ResidualRequest>,
}

/// Triangles in one parallel piece of work.
const PACK: usize = 512;

/// Paints frame after frame. It remembers the colours of triangles, to smooth them in time.
#[derive(Debug)]
pub struct Painter {
    style: Style,
    grade: Grade,
    coherence: f64,
    colours: Colours,
    panes: Panes,
    canvas: Canvas,
}

impl Painter {
    /// A painter with the colours and lines of `options`.
    pub fn new(options: &Options) -> Self {
        Self {
            style: Style::of(options),
            grade: Grade::of(options),
            coherence: options.coherence,
            colours: Colours::default(),
            panes: Panes::default(),
            canvas: Canvas::with_coherence(options.coherence),
        }
    }

    /// The same, but opaque pictures without outlines are painted as planes of this `form`, if any, which must be
    /// [squared](crate::colour::Layout::is_squared).
    pub fn with_form(mut self, form: Option<Form>) -> Self {
        self.canvas.form = form.filter(|form| form.layout.is_squared());
        self
    }

    /// Takes back the buffers of a picture that is no longer needed: the next one is painted in them.
    pub fn recycle(&mut self, buffers: Buffers) {
        let Buffers { pixels, planes } = buffers;
        if !pixels.is_empty() {
            self.canvas.buffers.pixels = pixels;
        }
        if !planes.is_empty() {
            self.canvas.buffers.planes = planes;
        }
    }

    /// Changes the options from the next frame on.
    pub fn retune(&mut self, options: &Options) {
        self.style = Style::of(options);
        self.grade.retune(options);
        self.coherence = options.coherence;
        self.canvas.coherence = options.coherence;
    }

    /// Paints the next frame, see [`rasterise`]. Calls `send` once, with the picture's residual if the `hints`
    /// ask for it, as soon as it is known: before colours are graded, edges made smooth and outlines drawn. Mean
    /// colours that are not known are taken from every `rows`-th row, where a triangle has enough of them.
    pub fn paint(
        &mut self,
        mesh: &Mesh,
        frame: &Frame,
        rows: u32,
        hints: PaintHints,
        send: impl FnOnce(Option<Residual>),
    ) -> Painting {
        let mut fills = if hints.fills.len() == mesh.triangles.len() {
            seen_below(mesh, frame, hints.fills)
        } else if let Some(planes) = frame.planes() {
            planar::means(mesh, planes, rows)
        } else if rows > 1 {
            sparse_means(mesh, frame, rows)
        } else {
            means(mesh, frame)
        };
        if hints.is_fresh {
            self.colours.forget();
            self.panes.forget();
        }
        let gradients = self.refill(mesh, frame, &mut fills);
        self.unite(mesh, &mut fills);
        let request = hints.residual.filter(|_| frame.is_opaque()).map(|request| (request, frame));
        self.grade.learn(mesh, fills.iter().map(|fill| fill.colour));
        let look = (&self.style, &self.grade);
        self.canvas.paint(mesh, (fills, gradients), look, request, send)
    }

    /// Gives the triangles of each cell one colour.
    fn unite(&mut self, mesh: &Mesh, fills: &mut [Fill]) {
        match self.style.shape {
            Shape::Triangles => {}
            Shape::Polygons => self.panes.merge(mesh, fills, self.coherence),
            Shape::Voronoi => cells::fill_cells(mesh, fills, &mut self.colours, self.coherence),
        }
    }

    /// Gives the triangles of `mesh`, whose means are `fills`, the colours of their fill, held back from
    /// shimmering; returns gradients where there are any.
    fn refill(&mut self, mesh: &Mesh, frame: &Frame, fills: &mut [Fill]) -> Option<Vec<Gradient>> {
        let mut gradients = match self.style.fill {
            FillMode::Mean | FillMode::None => None,
            FillMode::Median => {
                let before = self.colours.before(mesh);
                median::medians(mesh, frame, fills, &before, self.coherence);
                None
            }
            FillMode::Centroid => {
                for (t, fill) in fills.iter_mut().enumerate() {
                    fill.colour = below_centroid(frame, mesh.triangle(t));
                }
                None
            }
            FillMode::Linear => Some(gradient::planes(mesh, frame, fills)),
            FillMode::Gouraud => Some(gouraud::gradients(mesh, frame, fills)),
        };
        if self.coherence > 0.0 && self.style.shape != Shape::Voronoi {
            let found: Vec<_> = match gradients {
                Some(_) => fills.iter().map(|fill| fill.colour).collect(),
                None => Vec::new(),
            };
            self.colours.steady(mesh, fills, self.coherence);
            for ((gradient, from), fill) in gradients.iter_mut().flatten().zip(found).zip(fills) {
                gradient.shift(from, fill.colour);
            }
        }
        gradients
    }
}

/// Fills each triangle of `mesh` with the mean colour of the pixels of `frame` that it covers (paper,
/// section 3: the last step), and draws its edges in `outline`, one pixel wide. Where `edges` are smooth every
/// pixel is mixed with its neighbours, by 1 6 1 of eight across and down.
///
/// Colours are weighted by alpha, and a triangle's alpha is the mean alpha. An exception keeps the outline of a
/// cut-out figure free of haze: a triangle less than a quarter of which is visible, and that part mostly opaque,
/// becomes transparent; one less than a quarter of which is transparent becomes opaque. `mesh` and `frame` must have
/// the same size.
pub fn rasterise(mesh: &Mesh, frame: &Frame, edges: Edges, outline: Option<Rgba>) -> Painting {
    let style = Style::plain(edges, outline);
    let grade = Grade::of(&Options::default());
    Canvas::default().paint(mesh, (means(mesh, frame), None), (&style, &grade), None, |_| ())
}

/// The picture of `mesh` alone, its triangles filled as `fill` says, without lines.
pub fn filled(mesh: &Mesh, frame: &Frame, edges: Edges, fill: FillMode) -> Painting {
    if fill == FillMode::Mean {
        return rasterise(mesh, frame, edges, None);
    }
    let options = Options { edges, fill, coherence: 0.0, ..Options::default() };
    Painter::new(&options).paint(mesh, frame, 1, PaintHints::default(), |_| ())
}

/// The mean colour and the area of each triangle. One that covers no pixel's centre has the colour of
/// the pixel below its centroid, and no area.
pub fn means(mesh: &Mesh, frame: &Frame) -> Vec<Fill> {
    if let Some(planes) = frame.planes() {
        return planar::means(mesh, planes, 1);
    }
    each_triangle(
        mesh,
        #[inline(always)]
        |triangle| mean(frame, triangle),
    )
}

/// Calls `find` for each triangle of `mesh`, in parallel.
fn each_triangle(mesh: &Mesh, find: impl Fn([Point; 3]) -> Fill + Sync) -> Vec<Fill> {
    each_triangle_with(
        mesh,
        Fill { colour: [0; 4], area: 0 },
        #[inline(always)]
        |_, triangle| find(triangle),
    )
}

/// The same for values of any type, of each triangle with its number. `initial` is replaced everywhere.
fn each_triangle_with<T: Clone + Send>(
    mesh: &Mesh,
    initial: T,
    find: impl Fn(usize, [Point; 3]) -> T + Sync,
) -> Vec<T> {
    let mut found = vec![initial; mesh.triangles.len()];
    found.par_chunks_mut(PACK).enumerate().for_each(|(pack, found)| {
        dispatch(
            #[inline(always)]
            || {
                for (i, value) in found.iter_mut().enumerate() {
                    let t = pack * PACK + i;
                    *value = find(t, mesh.triangle(t));
                }
            },
        );
    });
    found
}

#[inline(always)]
fn mean(frame: &Frame, triangle: [Point; 3]) -> Fill {
    let all = Tally::of(
        frame,
        triangle,
        #[inline(always)]
        |_| true,
    );
    if all.area == 0 {
        return Fill { colour: below_centroid(frame, triangle), area: 0 };
    }
    all.fill()
}

/// Fills in the colours of triangles that cover no pixel's centre.
fn seen_below(mesh: &Mesh, frame: &Frame, mut fills: Vec<Fill>) -> Vec<Fill> {
    for (t, fill) in fills.iter_mut().enumerate().filter(|(_, fill)| fill.area == 0) {
        fill.colour = below_centroid(frame, mesh.triangle(t));
    }
    fills
}

fn below_centroid(frame: &Frame, triangle: [Point; 3]) -> Rgba {
    let (x, y) = centroid(triangle).pixel(frame.size());
    frame.near(x, y)
}

fn centroid([a, b, c]: [Point; 3]) -> Point {
    Point::new((a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};
    use crate::geom::Size;
    use crate::scan;
    use crate::triangulate::triangulate;
    use proptest::prelude::*;

    pub(super) fn noise(size: Size, seed: u64, opaque: bool) -> Frame {
        let pixel = |x, y| {
            let [r, g, b, a, ..] = rank(seed, Purpose::Noise, x, y).to_le_bytes();
            [r, g, b, if opaque { 255 } else { a & 0xf0 }]
        };
        let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| pixel(x, y)));
        Frame::new(size, pixels.collect()).expect("a small frame")
    }

    /// The alpha of a triangle whose pixels have these, from its definition.
    fn alpha_of<I: Iterator<Item = f64>>(alphas: impl Fn() -> I) -> f64 {
        let mean = alphas().sum::<f64>() / alphas().count() as f64;
        let is_stray = |part: fn(f64) -> f64| {
            let (sum, squares) =
                alphas().map(part).fold((0.0, 0.0), |(s, q), part| (s + part, q + part * part));
            sum / (alphas().count() as f64) < 255.0 / 4.0 && squares / sum > 127.5
        };
        match (is_stray(|alpha| alpha), is_stray(|alpha| 255.0 - alpha)) {
            (true, _) => 0.0,
            (_, true) => 255.0,
            _ => mean,
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// The slow, obvious version: each pixel asks every triangle, and takes the mean of its peers.
        #[test]
        fn every_pixel_has_the_mean_of_its_one_triangle(
            (width, height) in (1u32..90, 1u32..90),
            places in proptest::collection::vec((0i32..90 * 256, 0i32..90 * 256), 0..40),
            seed: u64,
            opaque: bool,
        ) {
            let size = Size::new(width, height);
            let mut seeds: Vec<_> = places
                .iter()
                .map(|&(x, y)| Point::new(x, y))
                .filter(|&p| size.contains(p) && !Mesh::corners(size).contains(&p))
                .collect();
            seeds.sort_unstable();
            seeds.dedup();
            let mesh = triangulate(size, &seeds).expect("distinct seeds");
            let frame = noise(size, seed, opaque);
            let painting = rasterise(&mesh, &frame, Edges::Hard, None);
            let mut owner = vec![u32::MAX; size.pixels()];
            for t in 0..mesh.triangles.len() {
                scan::spans(mesh.triangle(t), 0..height, |y, xs| for x in xs {
                    let at = &mut owner[y as usize * width as usize + x];
                    assert_eq!(*at, u32::MAX, "two triangles cover ({x}, {y})");
                    *at = t as u32;
                });
            }
            prop_assert!(owner.iter().all(|&t| t != u32::MAX), "a gap");
            let total: u32 = painting.fills.iter().map(|f| f.area).sum();
            prop_assert_eq!(total as usize, size.pixels());
            for t in 0..mesh.triangles.len() as u32 {
                let mine: Vec<_> = (0..size.pixels()).filter(|&i| owner[i] == t).collect();
                let alphas = || mine.iter().map(|&i| f64::from(frame.pixels()[i][3]));
                let weight: f64 = alphas().sum();
                let alpha = alpha_of(alphas);
                for i in &mine {
                    let painted = painting.frame.pixels()[*i];
                    prop_assert!((f64::from(painted[3]) - alpha).abs() <= 0.5);
                    for c in 0..3 {
                        let sum: f64 = mine
                            .iter()
                            .map(|&i| f64::from(frame.pixels()[i][c]) * f64::from(frame.pixels()[i][3]))
                            .sum();
                        let mean = if painted[3] == 0 { 0.0 } else { sum / weight };
                        prop_assert!((f64::from(painted[c]) - mean).abs() <= 0.5 + 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn a_transparent_pixel_costs_nothing() {
        let frame = Frame::new(Size::new(2, 1), vec![[200, 100, 50, 255], [0, 255, 0, 0]])
            .expect("two pixels");
        let mesh = triangulate(Size::new(2, 1), &[]).expect("corners");
        let colours: Vec<_> = means(&mesh, &frame).iter().map(|f| f.colour).collect();
        assert!(colours.contains(&[200, 100, 50, 255]) || colours.contains(&[200, 100, 50, 128]));
    }

    /// The alpha of the upper right half of a square, of whose 190 pixels the first `part` have `alpha` and the
    /// others `rest`.
    fn alpha_of_half(part: u32, alpha: u8, rest: u8) -> u8 {
        let size = Size::new(20, 20);
        let mesh = triangulate(size, &[]).expect("corners");
        let triangle = (0..2).find(|&t| {
            let mut has = false;
            scan::spans(mesh.triangle(t), 0..20, |y, xs| has |= y == 0 && xs.contains(&15));
            has
        });
        let mut pixels = vec![[9, 9, 9, 255]; size.pixels()];
        let mut count = 0;
        scan::spans(mesh.triangle(triangle.expect("one has it")), 0..20, |y, xs| {
            for x in xs {
                pixels[y as usize * 20 + x][3] = if count < part { alpha } else { rest };
                count += 1;
            }
        });
        let frame = Frame::new(size, pixels).expect("a small frame");
        means(&mesh, &frame)[triangle.expect("as above")].colour[3]
    }

    #[test]
    fn a_figure_that_is_cut_out_has_no_haze_around_it_nor_holes() {
        assert_eq!(alpha_of_half(40, 255, 0), 0);
        assert_eq!(alpha_of_half(40, 0, 255), 255);
        assert!((70..90).contains(&alpha_of_half(60, 255, 0)), "three tenths are not left out");
        assert_eq!(alpha_of_half(400, 20, 0), 20, "what is faint all over stays");
        assert_eq!(alpha_of_half(400, 235, 0), 235, "so does what is nearly opaque");
    }

    #[test]
    fn outlines_come_with_their_colour() {
        let size = Size::new(20, 10);
        let mesh = triangulate(size, &[Point::pixel_centre(9, 5)]).expect("one seed");
        let red = [255, 0, 0, 255];
        let grey = Frame::filled(size, [9, 9, 9, 255]).expect("grey");
        let painting = rasterise(&mesh, &grey, Edges::Hard, Some(red));
        assert_eq!(painting.fills.last().map(|f| f.colour), Some(red));
        assert_eq!(painting.frame.at(0, 0), red);
        assert_eq!(painting.frame.at(9, 5), red);
        assert_eq!(painting.frame.at(10, 2), [9, 9, 9, 255]);
    }
}
