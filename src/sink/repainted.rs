//! A sink that paints meshes at another size for a second sink.

use super::facets::Facets;
use super::{Needs, Origin, Picture, Sink};
use crate::error::Result;
use crate::frame::{Buffers, Fill, Frame};
use crate::geom::Size;
use crate::options::Options;
use crate::rasterise::{Painter, stretch};

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
