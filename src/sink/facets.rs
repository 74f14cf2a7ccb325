//! A frame as a mesh with colours, for formats that store these rather than pixels.

use super::{Origin, Picture};
use crate::error::{Error, Result};
use crate::frame::Rgba;
use crate::mesh::Mesh;
use crate::options::Options;
use crate::rasterise::{Grade, Outlined, outlined};
use crate::stream::Span;

/// A frame's facets.
#[derive(Debug)]
pub(super) struct Facets {
    pub(super) mesh: Mesh,
    /// One for each triangle, before grading.
    pub(super) colours: Vec<Rgba>,
    pub(super) span: Span,
}

impl Facets {
    /// The facets of a picture that came [plain](super::Needs::plain), with its origin.
    pub(super) fn of(picture: Picture, origin: Option<Origin>) -> Result<Self> {
        let Some(Origin { mesh, .. }) = origin else {
            return Err(Error::usage(
                "this output needs the mesh of a frame, and none came with it",
            ));
        };
        let colours = picture.fills.iter().take(mesh.triangles.len()).map(|fill| fill.colour);
        Ok(Self { colours: colours.collect(), mesh, span: picture.span })
    }

    /// The colours after grading by `look`.
    pub(super) fn graded(&self, grade: &mut Grade) -> Vec<Rgba> {
        grade.graded(&self.mesh, &self.colours)
    }

    /// The edges along which `look` has lines, by the looks of the lines.
    pub(super) fn outlined(&self, look: &Options) -> Vec<Outlined> {
        outlined(&self.mesh, &self.colours, look)
    }
}
