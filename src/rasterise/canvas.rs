//! The picture that triangles of known colours make.

use rayon::prelude::*;

use super::Painting;
use super::style::Style;
use crate::echo::Call;
use crate::frame::{Fill, Frame, Rgba};
use crate::mesh::Mesh;
use crate::scan::runs::{BAND, Bands};

/// Memory to paint in, and who wants to know what the picture is off its frame.
#[derive(Debug)]
pub(super) struct Canvas<'a> {
    pub(super) pixels: Vec<Rgba>,
    pub(super) bands: &'a mut Bands,
    /// The frame, which is opaque, with who asked.
    pub(super) asked: Option<(Call, &'a Frame)>,
}

impl Canvas<'_> {
    /// The picture of `mesh`, its triangles in the colours of `fills`.
    pub(super) fn paint(&mut self, mesh: &Mesh, mut fills: Vec<Fill>, style: &Style) -> Painting {
        let mut pixels = std::mem::take(&mut self.pixels);
        pixels.resize(mesh.size.pixels(), [0; 4]);
        let lined = style.outline.is_some();
        let colours = if lined { fills.iter().map(|f| f.colour).collect() } else { Vec::new() };
        let is_asked = self.asked.is_some();
        if is_asked {
            self.fill_and_tell(mesh, &fills, &mut pixels);
        }
        if !is_asked || style.is_graded() {
            style.grade(&mut fills);
            self.fill(mesh, &fills, &mut pixels);
        }
        fills.extend(style.draw(&mut pixels, mesh, &colours));
        let opaque = fills.iter().all(|fill| fill.colour[3] == 255);
        let frame =
            Frame::known(mesh.size, pixels, opaque).expect("as many pixels as the mesh covers");
        Painting { frame, fills }
    }

    /// Paints the triangles of `mesh` in the colours of `fills` on `pixels`, which are of its size. What
    /// has alpha 0 becomes transparent black.
    fn fill(&mut self, mesh: &Mesh, fills: &[Fill], pixels: &mut [Rgba]) {
        let bands = sorted(self.bands, mesh, fills);
        let width = mesh.size.width as usize;
        let parts = pixels.par_chunks_mut(width * BAND as usize).enumerate();
        parts.for_each(|(band, pixels)| bands.fill(band, width, pixels));
    }

    /// The same, and tells who asked.
    fn fill_and_tell(&mut self, mesh: &Mesh, fills: &[Fill], pixels: &mut [Rgba]) {
        let Some((call, frame)) = &mut self.asked else { return };
        let bands = sorted(self.bands, mesh, fills);
        let width = mesh.size.width as usize;
        let rows = width * BAND as usize;
        let (room, hearing) = call.room(mesh.size);
        let room = room.par_chunks_mut(rows).zip(frame.pixels().par_chunks(rows));
        let parts = pixels.par_chunks_mut(rows).zip(room).enumerate();
        parts.for_each(|(band, (pixels, (room, source)))| {
            bands.fill(band, width, pixels);
            hearing.hear(room, pixels, source);
        });
    }
}

fn sorted<'a>(bands: &'a mut Bands, mesh: &Mesh, fills: &[Fill]) -> &'a Bands {
    let painted = fills.iter().enumerate().map(|(t, fill)| (mesh.triangle(t), fill.colour));
    bands.sort(mesh.size.height, painted);
    bands
}
