//! A sink that paints meshes at another size for a second sink.

use super::facets::Facets;
use super::{Needs, Origin, Picture, Sink};
use crate::error::Result;
use crate::frame::{Buffers, Fill, Frame};
use crate::geom::{Point, Size, orient};
use crate::mesh::Mesh;
use crate::options::{Length, Options};
use crate::rasterise::Painter;

/// Paints for an inner sink.
pub struct Repainted {
    inner: Box<dyn Sink>,
    painter: Painter,
    size: Size,
}

impl Repainted {
    /// Paints at `size` with the edges, lines and grading of `look`, for `inner`, which was made for pictures of that
    /// size.
    pub fn new(inner: Box<dyn Sink>, look: &Options, size: Size) -> Self {
        let mut look = look.clone();
        let needs = inner.needs();
        needs.adapt(&mut look);
        Self { painter: Painter::new(&look).with_form(needs.form), inner, size }
    }

    /// `look` for pictures `times` as large: the width of lines grows in proportion.
    pub fn look_at(look: &Options, times: f64) -> Options {
        let mut look = look.clone();
        if let Length::Pixels(pixels) = look.outline_width {
            look.outline_width = Length::Pixels((pixels * times).clamp(0.1, 256.0));
        }
        look
    }
}

impl Sink for Repainted {
    fn needs(&self) -> Needs {
        Needs { origin: true, plain: true, ..Needs::default() }
    }

    fn write(&mut self, picture: Picture, origin: Option<Origin>) -> Result<Buffers> {
        let Facets { mut mesh, mut colours, span } = Facets::of(picture, origin)?;
        stretch(&mut mesh, &mut colours, self.size);
        let needs = self.inner.needs();
        let (frame, fills) = if needs.plain {
            let fills = colours.iter().map(|&colour| Fill { colour, area: 0 }).collect();
            (nothing()?, fills)
        } else {
            let painting = self.painter.paint_known(&mesh, &colours);
            (painting.frame, painting.fills)
        };
        let origin = if needs.origin { Some(Origin { frame: nothing()?, mesh }) } else { None };
        let buffers = self.inner.write(Picture { frame, fills, span }, origin)?;
        self.painter.recycle(buffers);
        Ok(Buffers::default())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        self.inner.finish()
    }

    fn warnings(&self) -> &[String] {
        self.inner.warnings()
    }
}

/// A placeholder for a frame that is not used.
pub(crate) fn nothing() -> Result<Frame> {
    Ok(Frame::filled(Size::new(1, 1), [0; 4])?)
}

/// Stretches `mesh` to `size`. Triangles that lose their area are removed, with their colours.
fn stretch(mesh: &mut Mesh, colours: &mut Vec<crate::frame::Rgba>, size: Size) {
    if mesh.size == size {
        return;
    }
    let (from, to) = (mesh.size.far(), size.far());
    let stretched = |v: i32, from: i32, to: i32| {
        ((2 * i64::from(v) * i64::from(to) + i64::from(from)) / (2 * i64::from(from))) as i32
    };
    for p in &mut mesh.vertices {
        *p = Point::new(stretched(p.x, from.x, to.x), stretched(p.y, from.y, to.y));
    }
    mesh.size = size;
    let kept = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
        orient(a, b, c) > 0
    };
    let keep: Vec<bool> = mesh.triangles.iter().map(kept).collect();
    let mut flags = keep.iter();
    colours.retain(|_| flags.next().is_some_and(|&keep| keep));
    let mut flags = keep.iter();
    mesh.triangles.retain(|_| flags.next().is_some_and(|&keep| keep));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangulate::triangulate;

    #[test]
    fn a_stretched_mesh_covers_its_frame() {
        let seeds = [Point::new(700, 900), Point::new(0, 500), Point::new(701, 901)];
        for (width, height) in [(40, 30), (17, 13), (5, 3), (10, 7)] {
            let mut mesh = triangulate(Size::new(10, 7), &seeds).expect("three seeds");
            let mut colours = vec![[9, 9, 9, 255]; mesh.triangles.len()];
            stretch(&mut mesh, &mut colours, Size::new(width, height));
            assert_eq!(colours.len(), mesh.triangles.len());
            let painted = Painter::new(&Options::default()).paint_known(&mesh, &colours).frame;
            assert_eq!(painted.size(), Size::new(width, height));
            assert!(painted.pixels().iter().all(|&pixel| pixel == [9, 9, 9, 255]));
        }
    }
}
