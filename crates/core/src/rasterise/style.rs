//! Grades colours, and draws lines between them.

use crate::draw;
use crate::frame::{Fill, Rgba, luma};
use crate::mesh::Mesh;
use crate::options::{Edges, Options};

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
    saturation: f64,
    wash: f64,
}

impl Style {
    /// No grading, and lines of one pixel along all edges.
    pub(super) fn plain(edges: Edges, outline: Option<Rgba>) -> Self {
        Self { edges, outline, width: 1, contrast: 0, saturation: 1.0, wash: 0.0 }
    }

    pub(super) fn of(options: &Options) -> Self {
        Self {
            edges: options.edges,
            outline: options.outline.map(|colour| colour.0),
            width: options.outline_width,
            contrast: options.outline_contrast,
            saturation: options.saturation,
            wash: options.wash,
        }
    }

    /// Whether the colours are changed at all.
    pub(super) fn is_graded(&self) -> bool {
        self.saturation != 1.0 || self.wash != 0.0
    }

    /// Applies saturation and wash.
    pub(super) fn grade(&self, fills: &mut [Fill]) {
        if !self.is_graded() {
            return;
        }
        for Fill { colour, .. } in fills {
            if colour[3] == 0 {
                continue;
            }
            let grey = f64::from(luma(*colour));
            for channel in &mut colour[..3] {
                let vivid = grey + self.saturation * (f64::from(*channel) - grey);
                let vivid = vivid.clamp(0.0, 255.0);
                // The cast takes whole numbers within 0..=255.
                *channel = (vivid + self.wash * (255.0 - vivid)).round() as u8;
            }
        }
    }

    /// Draws the lines on `pixels`; `colours` are those of the triangles before grading. Returns the fills of the
    /// lines.
    pub(super) fn draw(&self, pixels: &mut [Rgba], mesh: &Mesh, colours: &[Rgba]) -> Vec<Fill> {
        let Some(colour) = self.outline else { return Vec::new() };
        if colours.iter().any(|colour| colour[3] < 255) {
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

    /// The colour of the line of `outline` between triangles of two colours, or between one and the frame's border;
    /// `None` for no line. Its opacity is the larger one of the triangles'.
    fn line(&self, outline: Rgba, here: Rgba, there: Option<Rgba>) -> Option<Rgba> {
        let wanted = match there {
            Some(there) => self.contrast == 0 || difference(here, there) > self.contrast,
            None => self.contrast == 0,
        };
        let alpha = u32::from(here[3].max(there.map_or(0, |there| there[3])));
        let [r, g, b, a] = outline;
        // At most 255 * 255 / 255.
        let alpha = ((u32::from(a) * alpha + 127) / 255) as u8;
        (wanted && alpha > 0).then_some([r, g, b, alpha])
    }
}

/// The largest difference of a channel.
pub(super) fn difference(a: Rgba, b: Rgba) -> u32 {
    (0..4).map(|c| u32::from(a[c].abs_diff(b[c]))).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graded(saturation: f64, wash: f64, colour: Rgba) -> Rgba {
        let mut fills = [Fill { colour, area: 1 }];
        Style { saturation, wash, ..Style::plain(Edges::Hard, None) }.grade(&mut fills);
        fills[0].colour
    }

    #[test]
    fn colours_are_made_vivid_grey_and_light() {
        let red = [180, 60, 60, 200];
        assert_eq!(graded(1.0, 0.0, red), red);
        let grey = graded(0.0, 0.0, red);
        assert!(grey[0] == grey[1] && grey[1] == grey[2] && grey[3] == 200, "{grey:?}");
        let vivid = graded(1.5, 0.0, red);
        assert!(vivid[0] > 180 && vivid[1] < 60, "{vivid:?}");
        assert_eq!(graded(1.0, 1.0, red), [255, 255, 255, 200]);
        assert_eq!(graded(9.0, 0.0, [90; 4]), [90; 4], "grey stays grey");
    }
}
