//! Draws lines between colours.

use crate::draw;
use crate::frame::{Fill, Rgba};
use crate::mesh::Mesh;
use crate::options::{Edges, FillMode, Options, Shape};

/// How a mesh of known colours is painted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Style {
    /// How triangles meet.
    pub(super) edges: Edges,
    /// Colour of the lines; `None` draws none.
    pub(super) outline: Option<Rgba>,
    /// Pixels.
    width: u32,
    /// Lines are drawn between colours that differ by more.
    contrast: u32,
    pub(super) fill: FillMode,
    pub(super) shape: Shape,
}

impl Style {
    /// Lines of one pixel along all edges.
    pub(super) fn plain(edges: Edges, outline: Option<Rgba>) -> Self {
        Self { edges, outline, ..Self::of(&Options::default()) }
    }

    pub(super) fn of(options: &Options) -> Self {
        Self {
            edges: options.edges,
            outline: options.line_colour().map(|colour| colour.0),
            width: options.outline_width,
            contrast: options.outline_contrast,
            fill: options.fill,
            shape: options.shape,
        }
    }

    /// Draws the lines on `pixels`; `colours` are those of the triangles before grading. Returns the fills of the
    /// lines.
    pub(super) fn draw(&self, pixels: &mut [Rgba], mesh: &Mesh, colours: &[Rgba]) -> Vec<Fill> {
        let Some(colour) = self.outline else { return Vec::new() };
        if self.shape != Shape::Triangles || colours.iter().any(|colour| colour[3] < 255) {
            return draw::shaded_edges(pixels, mesh, self.width, |t, u| {
                self.line(colour, colours[t as usize], u.map(|u| colours[u as usize]))
            });
        }
        let area = if self.contrast == 0 {
            draw::edges(pixels, mesh, colour, self.width)
        } else {
            draw::some_edges(pixels, mesh, colour, self.width, |t, u| {
                difference(colours[t as usize], colours[u as usize]) > self.contrast
            })
        };
        vec![Fill { colour, area }]
    }

    /// Whether a line runs between triangles of two colours, or between one and the frame's border. Triangles of one
    /// cell have one colour, see [`super::cells`].
    pub(super) fn is_lined(&self, here: Rgba, there: Option<Rgba>) -> bool {
        let is_all = self.contrast == 0;
        there.map_or(is_all, |there| {
            difference(here, there) > self.contrast || (is_all && self.shape == Shape::Triangles)
        })
    }

    /// The colour of the line of `outline` between triangles of two colours, or between one and the frame's border;
    /// `None` for no line. Its opacity is the larger one of the triangles'.
    pub(super) fn line(&self, outline: Rgba, here: Rgba, there: Option<Rgba>) -> Option<Rgba> {
        let wanted = self.is_lined(here, there);
        let alpha = u32::from(here[3].max(there.map_or(0, |there| there[3])));
        let [r, g, b, a] = outline;
        // At most 255 * 255 / 255.
        let alpha = ((u32::from(a) * alpha + 127) / 255) as u8;
        (wanted && alpha > 0).then_some([r, g, b, alpha])
    }
}

/// The largest difference of a channel.
fn difference(a: Rgba, b: Rgba) -> u32 {
    (0..4).map(|c| u32::from(a[c].abs_diff(b[c]))).max().unwrap_or(0)
}
