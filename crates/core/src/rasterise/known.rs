//! Paints meshes whose colours are known, as those of a mesh stream.

use std::collections::BTreeMap;

use super::style::Style;
use super::wanted::{Wanted, wanted};
use super::{Grade, Painter, Painting};
use crate::frame::{Fill, Rgba};
use crate::mesh::Mesh;
use crate::options::Options;
use crate::scan::spans;

impl Painter {
    /// Paints `mesh` in `colours`: one for each triangle, in the triangles' order, before grading. Triangles
    /// without area are invisible.
    ///
    /// # Panics
    /// When there are not as many colours as triangles.
    pub fn paint_known(&mut self, mesh: &Mesh, colours: &[Rgba]) -> Painting {
        assert_eq!(colours.len(), mesh.triangles.len(), "a colour a triangle");
        let height = mesh.size.height;
        let area = |t: usize| {
            let mut area = 0;
            spans(mesh.triangle(t), 0..height, |_, columns| area += columns.len());
            area as u32
        };
        let fills = colours.iter().enumerate().map(|(t, &colour)| Fill { colour, area: area(t) });
        let fills: Vec<_> = fills.collect();
        self.grade.learn(mesh, colours.iter().copied());
        self.canvas.paint(mesh, (fills, None), (&self.style, &self.grade), None, |_| ())
    }
}

/// Lines of one look.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlined {
    /// Their colour, and the opacity of what they run along.
    pub colour: Rgba,
    /// How strongly they are drawn over it, above 0 and at most 1.
    pub strength: f64,
    /// The mesh's edges, by the numbers of their vertices.
    pub edges: Vec<[u32; 2]>,
}

/// Strengths are rounded to this number of steps, so that lines of one look are few groups.
const STRENGTHS: u32 = 8;

/// The edges of `mesh` along which `options` have lines drawn, each once, by the looks of the lines, the most opaque
/// last: all edges, or those between colours that differ enough, but none between triangles that are both transparent.
/// A line is as opaque as the more opaque of its sides. `colours` are those before they are graded.
pub fn outlined(mesh: &Mesh, colours: &[Rgba], options: &Options) -> Vec<Outlined> {
    let style = Style::of(options);
    let mut lines: BTreeMap<(u8, u32, Rgba), Outlined> = BTreeMap::new();
    let graded = (style.tint > 0.0).then(|| Grade::of(options).graded(mesh, colours));
    let shown = graded.as_deref().unwrap_or(colours);
    for Wanted { edge, paint, strength, .. } in wanted(&style, mesh, colours, shown) {
        let step = (u32::from(strength) * STRENGTHS + 127) / 255;
        if step > 0 {
            let strength = f64::from(step) / f64::from(STRENGTHS);
            let new = Outlined { colour: paint, strength, edges: Vec::new() };
            lines.entry((paint[3], step, paint)).or_insert(new).edges.push(edge);
        }
    }
    lines.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::geom::{Point, Size};
    use crate::options::{Colour, Edges};
    use crate::rasterise::{means, rasterise};
    use crate::triangulate::triangulate;

    fn sample() -> (Mesh, Frame) {
        let size = Size::new(40, 30);
        let seeds = [Point::pixel_centre(9, 5), Point::pixel_centre(25, 20), Point::new(0, 3000)];
        let pixel = |i: usize| [(i % 40 * 6) as u8, (i / 40 * 8) as u8, 90, 255];
        let frame = Frame::new(size, (0..size.pixels()).map(pixel).collect()).expect("a picture");
        (triangulate(size, &seeds).expect("three seeds"), frame)
    }

    #[test]
    fn known_colours_paint_the_same_picture() {
        let (mesh, frame) = sample();
        let colours: Vec<_> = means(&mesh, &frame).iter().map(|fill| fill.colour).collect();
        for edges in Edges::ALL {
            let options = Options { edges, ..Options::default() };
            let painted = Painter::new(&options).paint_known(&mesh, &colours);
            assert_eq!(painted, rasterise(&mesh, &frame, edges, None));
        }
    }

    #[test]
    fn lines_stand_where_colours_differ_and_something_is_seen() {
        let (mesh, frame) = sample();
        let mut colours: Vec<_> = means(&mesh, &frame).iter().map(|fill| fill.colour).collect();
        let black = Some(Colour([0, 0, 0, 255]));
        let all = Options { outline: black, ..Options::default() };
        let count = |colours: &[Rgba], options: &Options| -> usize {
            outlined(&mesh, colours, options).iter().map(|lines| lines.edges.len()).sum()
        };
        let every = count(&colours, &all);
        // The number of edges follows from those of vertices and triangles (Euler's formula).
        assert_eq!(every, mesh.vertices.len() + mesh.triangles.len() - 1);
        assert_eq!(count(&colours, &Options::default()), 0);
        let some = Options { outline_contrast: 30, ..all.clone() };
        let few = count(&colours, &some);
        assert!(few > 0 && few < every, "{few} of {every}");
        colours[0][3] = 100;
        let shades: Vec<_> =
            outlined(&mesh, &colours, &all).iter().map(|line| line.colour).collect();
        assert!(shades.len() == 2 && shades[0][3] == 100 && shades[1][3] == 255, "{shades:?}");
        colours.iter_mut().for_each(|colour| colour[3] = 0);
        assert_eq!(count(&colours, &all), 0);
    }
}
