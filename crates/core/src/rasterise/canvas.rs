//! Paints triangles of known colours.

use crate::parallel::prelude::*;

use super::Painting;
use super::antialias::AntialiasFilter;
use super::grade::Grade;
use super::gradient::{self, Gradient};
use super::lines::Lines;
use super::planar::{self, PlaneScratches};
use super::strokes;
use super::style::Style;
use crate::colour::{Form, Planes};
use crate::frame::{Buffers, Fill, Frame, Rgba};
use crate::mesh::Mesh;
use crate::options::Edges;
use crate::residual::{Residual, ResidualRequest};
use crate::scan::runs::{BAND, Bands};

/// Paints one picture after another in the same buffers.
#[derive(Debug, Default)]
pub(super) struct Canvas {
    /// The form of pictures of its size that are opaque and have no outlines. Other pictures are painted as pixels.
    pub(super) form: Option<Form>,
    /// Of pictures that are no longer needed.
    pub(super) buffers: Buffers,
    bands: Bands,
    scratches: PlaneScratches,
    filter: AntialiasFilter,
    lines: Lines,
    pub(super) coherence: f64,
}

/// A request for the residual, with the opaque frame to compare with.
type Request<'a> = Option<(ResidualRequest, &'a Frame)>;

/// A picture painted for the residual, before grading.
enum Painted {
    Pixels(Vec<Rgba>),
    Planes(Planes),
}

impl Canvas {
    /// A canvas whose lines hold to those of the frame before.
    pub(super) fn with_coherence(coherence: f64) -> Self {
        Self { coherence, ..Self::default() }
    }

    /// Paints `mesh` in the colours of `fills`, or with gradients that have those at their centres. Calls `send` with
    /// the residual, if there is a `request`, as soon as it is known.
    pub(super) fn paint(
        &mut self,
        mesh: &Mesh,
        (mut fills, gradients): (Vec<Fill>, Option<Vec<Gradient>>),
        (style, grade): (&Style, &Grade),
        request: Request<'_>,
        send: impl FnOnce(Option<Residual>),
    ) -> Painting {
        let width = mesh.size.width as usize;
        let smooth = style.edges == Edges::Smooth;
        let lined = style.outline.is_some();
        let colours = if lined { fills.iter().map(|f| f.colour).collect() } else { Vec::new() };
        if let Some(gradients) = gradients {
            // Without a residual: it would cost as much as all else.
            send(None);
            return self.paint_gradients(mesh, (fills, &gradients), (style, grade), &colours);
        }
        let (painted, residual) = self.residual(mesh, &fills, request).unzip();
        send(residual);
        let painted = if grade.is_any() { self.recycle(painted) } else { painted };
        grade.apply(&mut fills);
        let opaque = fills.iter().all(|fill| fill.colour[3] == 255);
        if let Some(form) =
            self.form.filter(|form| opaque && !lined && form.layout.size == mesh.size)
        {
            let mut planes = match painted {
                Some(Painted::Planes(planes)) if planes.form == form => planes,
                painted => {
                    self.recycle(painted);
                    let buffers = std::mem::take(&mut self.buffers.planes);
                    let scratch = (&mut self.bands, &mut self.scratches);
                    planar::paint(mesh, &fills, form, scratch, buffers)
                }
            };
            if smooth {
                // Chroma is not filtered: its samples are means over several pixels already.
                self.filter.plane(planes.split_mut()[0], width);
            }
            let buffers = std::mem::take(&mut self.buffers.pixels);
            let frame = Frame::planar(planes, buffers).expect("only squared forms are accepted");
            return Painting { frame, fills };
        }
        let mut pixels = match painted {
            Some(Painted::Pixels(pixels)) => pixels,
            painted => {
                self.recycle(painted);
                let mut pixels = std::mem::take(&mut self.buffers.pixels);
                pixels.resize(mesh.size.pixels(), [0; 4]);
                self.fill(mesh, &fills, &mut pixels);
                pixels
            }
        };
        if smooth {
            self.filter.pixels(&mut pixels, width, opaque);
        }
        let lines = self.draw_lines(&mut pixels, mesh, (style, &colours), &fills);
        fills.extend(lines);
        let opaque = fills.iter().all(|fill| fill.colour[3] == 255);
        let frame =
            Frame::known(mesh.size, pixels, opaque).expect("as many pixels as the mesh covers");
        Painting { frame, fills }
    }

    fn paint_gradients(
        &mut self,
        mesh: &Mesh,
        (fills, gradients): (Vec<Fill>, &[Gradient]),
        (style, grade): (&Style, &Grade),
        colours: &[Rgba],
    ) -> Painting {
        let mut pixels = std::mem::take(&mut self.buffers.pixels);
        pixels.resize(mesh.size.pixels(), [0; 4]);
        gradient::paint(mesh, &fills, gradients, &mut pixels);
        grade.pixels(&mut pixels);
        let opaque = fills.iter().all(|fill| fill.colour[3] == 255);
        if style.edges == Edges::Smooth {
            self.filter.pixels(&mut pixels, mesh.size.width as usize, opaque);
        }
        let mut held = fills;
        grade.apply(&mut held);
        let lines = self.draw_lines(&mut pixels, mesh, (style, colours), &held);
        let opaque = opaque && lines.iter().all(|fill| fill.colour[3] == 255);
        let mut within = gradient::fills(mesh, &held, gradients);
        grade.apply(&mut within);
        held.extend(lines);
        held.extend(within);
        let frame =
            Frame::known(mesh.size, pixels, opaque).expect("as many pixels as the mesh covers");
        Painting { frame, fills: held }
    }

    /// Draws the lines; `colours` are those of the triangles before grading, which `fills` have behind them. Returns
    /// the fills of the lines.
    fn draw_lines(
        &mut self,
        pixels: &mut [Rgba],
        mesh: &Mesh,
        (style, colours): (&Style, &[Rgba]),
        fills: &[Fill],
    ) -> Vec<Fill> {
        if style.outline.is_none() {
            return Vec::new();
        }
        let graded: Vec<_> = fills.iter().map(|fill| fill.colour).collect();
        let drawn = self.lines.of(style, mesh, (colours, &graded), self.coherence);
        let width = style.width(mesh.size);
        strokes::draw(pixels, mesh.size, width, &drawn, style.edges == Edges::Hard);
        strokes::fills(&drawn, width)
    }

    /// Paints in the form of the frame, pixels or planes, and computes the residual, if there is a `request`.
    fn residual(
        &mut self,
        mesh: &Mesh,
        fills: &[Fill],
        request: Request<'_>,
    ) -> Option<(Painted, Residual)> {
        let (mut request, frame) = request?;
        if let Some(source) = frame.planes() {
            let buffers = std::mem::take(&mut self.buffers.planes);
            let scratch = (&mut self.bands, &mut self.scratches);
            let planes = planar::paint(mesh, fills, source.form, scratch, buffers);
            let (offsets, writer) = request.planes(source.data.len());
            writer.write_all(offsets, &planes.data, &source.data);
            let residual = request.finish(mesh.size, Some(source.form));
            return Some((Painted::Planes(planes), residual));
        }
        let mut pixels = std::mem::take(&mut self.buffers.pixels);
        pixels.resize(mesh.size.pixels(), [0; 4]);
        let bands = sorted(&mut self.bands, mesh, fills);
        let width = mesh.size.width as usize;
        let rows = width * BAND as usize;
        let (offsets, writer) = request.pixels(mesh.size);
        let offsets = offsets.par_chunks_mut(rows).zip(frame.pixels().par_chunks(rows));
        let parts = pixels.par_chunks_mut(rows).zip(offsets).enumerate();
        parts.for_each(|(band, (pixels, (offsets, source)))| {
            bands.fill(band, width, pixels);
            let [painted, source] = [&*pixels, source].map(<[Rgba]>::as_flattened);
            writer.write(offsets.as_flattened_mut(), painted, source);
        });
        Some((Painted::Pixels(pixels), request.finish(mesh.size, None)))
    }

    /// Takes back the buffers of what is not shown. Returns `None`, for what was painted.
    fn recycle(&mut self, painted: Option<Painted>) -> Option<Painted> {
        match painted {
            Some(Painted::Pixels(pixels)) => self.buffers.pixels = pixels,
            Some(Painted::Planes(planes)) => self.buffers.planes = planes.data,
            None => {}
        }
        None
    }

    /// Paints the triangles of `mesh` in the colours of `fills` on `pixels`, which are of its size. What
    /// has alpha 0 becomes transparent black.
    fn fill(&mut self, mesh: &Mesh, fills: &[Fill], pixels: &mut [Rgba]) {
        let bands = sorted(&mut self.bands, mesh, fills);
        let width = mesh.size.width as usize;
        let parts = pixels.par_chunks_mut(width * BAND as usize).enumerate();
        parts.for_each(|(band, pixels)| bands.fill(band, width, pixels));
    }
}

fn sorted<'a>(bands: &'a mut Bands, mesh: &Mesh, fills: &[Fill]) -> &'a Bands {
    let painted = fills.iter().enumerate().map(|(t, fill)| (mesh.triangle(t), fill.colour));
    bands.sort(mesh.size.height, painted);
    bands
}
