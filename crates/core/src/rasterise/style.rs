//! How lines look, and where they are.

use super::lines::strength;
use crate::frame::Rgba;
use crate::geom::Size;
use crate::options::{Edges, FillMode, Length, Options, Shape};

/// How a mesh of known colours is painted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Style {
    /// How triangles meet.
    pub(super) edges: Edges,
    /// Colour of the lines; `None` draws none.
    pub(super) outline: Option<Rgba>,
    width: Length,
    /// The difference of colours between which a line has half its strength.
    contrast: u32,
    opacity: f64,
    /// How much of a line's colour is that of the facets.
    pub(super) tint: f64,
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
            outline: options
                .line_colour()
                .filter(|_| options.outline_opacity > 0.0)
                .map(|colour| colour.0),
            width: options.outline_width,
            contrast: options.outline_contrast,
            opacity: options.outline_opacity,
            tint: options.outline_tint,
            fill: options.fill,
            shape: options.shape,
        }
    }

    /// The width of lines on pictures of `size`, in pixels.
    pub(super) fn width(&self, size: Size) -> f64 {
        self.width.of(size.width.min(size.height))
    }

    /// Whether some edges have no line.
    pub(super) fn has_gaps(&self) -> bool {
        self.contrast > 0
    }

    /// The colour of the line of `outline` between triangles of two colours, or between one and the frame's border, and
    /// its strength of 255; `None` for no line. Its opacity is the larger one of the triangles'. Triangles of one
    /// cell have one colour, see [`super::cells`].
    pub(super) fn line(
        &self,
        outline: Rgba,
        here: Rgba,
        there: Option<Rgba>,
    ) -> Option<(Rgba, u8)> {
        let strength = match there {
            Some(there) if here == there && self.shape != Shape::Triangles => return None,
            Some(there) => strength(difference(here, there), self.contrast),
            None if self.contrast == 0 => 255,
            None => 0,
        };
        let alpha = u32::from(here[3].max(there.map_or(0, |there| there[3])));
        let [r, g, b, a] = outline;
        // At most 255 * 255 / 255.
        let alpha = ((u32::from(a) * alpha + 127) / 255) as u8;
        // At most 255.
        let strength = (f64::from(strength) * self.opacity).round() as u8;
        (alpha > 0).then_some(([r, g, b, alpha], strength))
    }
}

/// The largest difference of a channel.
fn difference(a: Rgba, b: Rgba) -> u32 {
    (0..4).map(|c| u32::from(a[c].abs_diff(b[c]))).max().unwrap_or(0)
}
