//! The picture that triangles of known colours make.

use crate::parallel::prelude::*;

use super::Painting;
use super::planar::{self, Easels};
use super::soften::Softener;
use super::style::Style;
use crate::colour::{Form, Planes};
use crate::echo::{Call, Echo};
use crate::frame::{Buffers, Fill, Frame, Rgba};
use crate::mesh::Mesh;
use crate::options::Edges;
use crate::scan::runs::{BAND, Bands};

/// Memory to paint in, and how the picture is wanted.
#[derive(Debug)]
pub(super) struct Canvas<'a> {
    pub(super) memory: &'a mut Buffers,
    pub(super) bands: &'a mut Bands,
    pub(super) easels: &'a mut Easels,
    pub(super) softener: &'a mut Softener,
    /// Pixels unless it is opaque and without outlines.
    pub(super) form: Option<Form>,
}

/// Who asked what a picture is off its frame, which is opaque.
type Asked<'a> = Option<(Call, &'a Frame)>;

/// What was painted, before its colours were graded, for who asked.
enum Told {
    Pixels(Vec<Rgba>),
    Planes(Planes),
}

impl Canvas<'_> {
    /// The picture of `mesh`, its triangles in the colours of `fills`. Who asked gets the answer as soon as it
    /// is known.
    pub(super) fn paint(
        &mut self,
        mesh: &Mesh,
        mut fills: Vec<Fill>,
        style: &Style,
        (asked, answer): (Asked<'_>, impl FnOnce(Option<Echo>)),
    ) -> Painting {
        let width = mesh.size.width as usize;
        let smooth = style.edges == Edges::Smooth;
        let lined = style.outline.is_some();
        let colours = if lined { fills.iter().map(|f| f.colour).collect() } else { Vec::new() };
        let (told, echo) = self.tell(mesh, &fills, asked).unzip();
        answer(echo);
        let told = if style.is_graded() { self.take_back(told) } else { told };
        style.grade(&mut fills);
        let opaque = fills.iter().all(|fill| fill.colour[3] == 255);
        if let Some(form) = self.form.filter(|_| opaque && !lined) {
            let mut planes = match told {
                Some(Told::Planes(planes)) if planes.form == form => planes,
                told => {
                    self.take_back(told);
                    let memory = std::mem::take(&mut self.memory.planes);
                    planar::paint(mesh, &fills, form, (self.bands, self.easels), memory)
                }
            };
            if smooth {
                // Samples of chroma are means over several pixels as they are.
                self.softener.plane(planes.split_mut()[0], width);
            }
            let room = std::mem::take(&mut self.memory.pixels);
            let frame = Frame::planar(planes, room).expect("who wants planes wants squared ones");
            return Painting { frame, fills };
        }
        let mut pixels = match told {
            Some(Told::Pixels(pixels)) => pixels,
            told => {
                self.take_back(told);
                let mut pixels = std::mem::take(&mut self.memory.pixels);
                pixels.resize(mesh.size.pixels(), [0; 4]);
                self.fill(mesh, &fills, &mut pixels);
                pixels
            }
        };
        if smooth {
            self.softener.pixels(&mut pixels, width, opaque);
        }
        fills.extend(style.draw(&mut pixels, mesh, &colours));
        let opaque = fills.iter().all(|fill| fill.colour[3] == 255);
        let frame =
            Frame::known(mesh.size, pixels, opaque).expect("as many pixels as the mesh covers");
        Painting { frame, fills }
    }

    /// Paints for who asked, if anybody did, and finds the answer.
    fn tell(&mut self, mesh: &Mesh, fills: &[Fill], asked: Asked<'_>) -> Option<(Told, Echo)> {
        let (mut call, frame) = asked?;
        if let Some(source) = frame.planes() {
            let memory = std::mem::take(&mut self.memory.planes);
            let planes = planar::paint(mesh, fills, source.form, (self.bands, self.easels), memory);
            let (room, hearing) = call.room_of_planes(source.data.len());
            hearing.hear_all(room, &planes.data, &source.data);
            let echo = call.answered(mesh.size, Some(source.form));
            return Some((Told::Planes(planes), echo));
        }
        let mut pixels = std::mem::take(&mut self.memory.pixels);
        pixels.resize(mesh.size.pixels(), [0; 4]);
        let bands = sorted(self.bands, mesh, fills);
        let width = mesh.size.width as usize;
        let rows = width * BAND as usize;
        let (room, hearing) = call.room(mesh.size);
        let room = room.par_chunks_mut(rows).zip(frame.pixels().par_chunks(rows));
        let parts = pixels.par_chunks_mut(rows).zip(room).enumerate();
        parts.for_each(|(band, (pixels, (room, source)))| {
            bands.fill(band, width, pixels);
            let [painted, source] = [&*pixels, source].map(<[Rgba]>::as_flattened);
            hearing.hear(room.as_flattened_mut(), painted, source);
        });
        Some((Told::Pixels(pixels), call.answered(mesh.size, None)))
    }

    /// Takes the memory back of what is not shown.
    fn take_back(&mut self, told: Option<Told>) -> Option<Told> {
        match told {
            Some(Told::Pixels(pixels)) => self.memory.pixels = pixels,
            Some(Told::Planes(planes)) => self.memory.planes = planes.data,
            None => {}
        }
        None
    }

    /// Paints the triangles of `mesh` in the colours of `fills` on `pixels`, which are of its size. What
    /// has alpha 0 becomes transparent black.
    fn fill(&mut self, mesh: &Mesh, fills: &[Fill], pixels: &mut [Rgba]) {
        let bands = sorted(self.bands, mesh, fills);
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
