//! The picture that triangles of known colours make.

use rayon::prelude::*;

use super::Painting;
use super::planar::{self, Easels};
use super::style::Style;
use crate::colour::{Form, Planes};
use crate::echo::Call;
use crate::frame::{Fill, Frame, Memory, Rgba};
use crate::mesh::Mesh;
use crate::scan::runs::{BAND, Bands};

/// Memory to paint in, and who wants to know what the picture is off its frame.
#[derive(Debug)]
pub(super) struct Canvas<'a> {
    pub(super) memory: &'a mut Memory,
    pub(super) bands: &'a mut Bands,
    pub(super) easels: &'a mut Easels,
    /// How the picture is wanted; pixels unless it is opaque and without outlines.
    pub(super) form: Option<Form>,
    /// The frame, which is opaque, with who asked.
    pub(super) asked: Option<(Call, &'a Frame)>,
}

/// What was painted, before its colours were graded, for who asked.
enum Told {
    Pixels(Vec<Rgba>),
    Planes(Planes),
}

impl Canvas<'_> {
    /// The picture of `mesh`, its triangles in the colours of `fills`.
    pub(super) fn paint(&mut self, mesh: &Mesh, mut fills: Vec<Fill>, style: &Style) -> Painting {
        let lined = style.outline.is_some();
        let colours = if lined { fills.iter().map(|f| f.colour).collect() } else { Vec::new() };
        let told = self.tell(mesh, &fills);
        let told = if style.is_graded() { self.take_back(told) } else { told };
        style.grade(&mut fills);
        let opaque = fills.iter().all(|fill| fill.colour[3] == 255);
        if let Some(form) = self.form.filter(|_| opaque && !lined) {
            let planes = match told {
                Some(Told::Planes(planes)) if planes.form == form => planes,
                told => {
                    self.take_back(told);
                    let memory = std::mem::take(&mut self.memory.planes);
                    planar::paint(mesh, &fills, form, (self.bands, self.easels), memory)
                }
            };
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
        fills.extend(style.draw(&mut pixels, mesh, &colours));
        let opaque = fills.iter().all(|fill| fill.colour[3] == 255);
        let frame =
            Frame::known(mesh.size, pixels, opaque).expect("as many pixels as the mesh covers");
        Painting { frame, fills }
    }

    /// Paints for who asked, if anybody did, and answers.
    fn tell(&mut self, mesh: &Mesh, fills: &[Fill]) -> Option<Told> {
        let (call, frame) = self.asked.as_mut()?;
        if let Some(source) = frame.planes() {
            let memory = std::mem::take(&mut self.memory.planes);
            let planes = planar::paint(mesh, fills, source.form, (self.bands, self.easels), memory);
            let (room, hearing) = call.room_of_planes(source.data.len());
            hearing.hear_all(room, &planes.data, &source.data);
            return Some(Told::Planes(planes));
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
        Some(Told::Pixels(pixels))
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
