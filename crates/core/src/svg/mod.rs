//! Meshes as SVG: one path a facet, in integers, without seams.
//!
//! Renderers mix a pixel that two facets share from both and from the ground below them, so that facets which
//! only touch show a hairline of ground (linebender/resvg#234). The cure that works everywhere is underlap: what
//! is painted earlier reaches under what is painted later. Here the facet that is painted first at a vertex is
//! drawn as a polygon around that vertex; the facets after it cover what is too much, so that every edge that is
//! seen is exact. See [`Seams`].

mod animated;
mod lines;
mod path;
mod underlap;

use std::fmt::Write as _;

use crate::frame::Rgba;
use crate::geom::Size;
use crate::mesh::Mesh;
use crate::options::Options;
use crate::rasterise::Outlined;
use path::PathData;

pub use animated::{AnimatedSvg, MOST_FACETS, TooManyFacets};

/// What is done so that no ground shows between facets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Seams {
    /// What is painted earlier reaches under what is painted later. Edges stay exact.
    #[default]
    Underlap,
    /// Every facet has a thin line of its own colour around it.
    Stroke,
    /// Nothing: facets are exactly the triangles.
    None,
}

impl Seams {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Underlap, Self::Stroke, Self::None];

    /// The name on command lines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Underlap => "underlap",
            Self::Stroke => "stroke",
            Self::None => "none",
        }
    }
}

/// Lines between facets. Where their colour is not opaque, what lies below them does not show through; where they are
/// not strong, it does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lines<'a> {
    /// The mesh's edges that are drawn, by the numbers of their vertices.
    pub edges: &'a [[u32; 2]],
    /// Their colour.
    pub colour: Rgba,
    /// Their width in pixels.
    pub width: f64,
    /// How strongly they are drawn over what lies below them, 0 to 1.
    pub strength: f64,
}

impl<'a> Lines<'a> {
    /// The lines of a mesh of `size` that `outlined` gives for `look`, as wide as `look` says.
    pub fn of(outlined: &'a [Outlined], look: &Options, size: Size) -> Vec<Self> {
        let width = look.outline_width.of(size.width.min(size.height));
        let lines = outlined.iter().map(|Outlined { edges, colour, strength }| Self {
            edges,
            colour: *colour,
            width,
            strength: *strength,
        });
        lines.collect()
    }
}

/// How a mesh is written.
#[derive(Clone, Copy, Debug, Default)]
pub struct SvgOptions<'a> {
    /// The document's title; an empty one is left out.
    pub title: &'a str,
    /// What is done about seams. Default: underlap.
    pub seams: Seams,
    /// Lines over the facets, later ones over earlier ones. Default: none.
    pub lines: &'a [Lines<'a>],
}

/// Units of the document in one pixel: the finest of these that keeps steps between vertices short.
fn units_per_pixel(mesh: &Mesh) -> i32 {
    let facets = mesh.triangles.len().max(1);
    let side = (mesh.size.pixels() as f64 / facets as f64).sqrt();
    // With steps of two digits most bytes are digits that make no visible difference where facets are large.
    if side < 24.0 { 8 } else { 4 }
}

/// `mesh` as an SVG document, its triangles in `colours`, one each and in their order.
///
/// The document's unit is an eighth or a quarter of a pixel, which its description states; `width` and `height`
/// are the mesh's in pixels. What has alpha 0 is left out.
///
/// # Panics
/// When there are not as many colours as triangles.
pub fn to_svg(mesh: &Mesh, colours: &[Rgba], options: &SvgOptions<'_>) -> String {
    let mut svg = Document::begin(mesh, options.title);
    svg.frame(mesh, colours, options);
    svg.end()
}

/// A document being written.
#[derive(Debug)]
pub(crate) struct Document {
    text: String,
    units: i32,
    masks: usize,
}

impl Document {
    /// A document for meshes like `mesh`.
    pub(crate) fn begin(mesh: &Mesh, title: &str) -> Self {
        let units = units_per_pixel(mesh);
        let mut text = String::with_capacity(400 + 70 * mesh.triangles.len());
        let (width, height) = (mesh.size.width, mesh.size.height);
        let (across, down) =
            (i64::from(width) * i64::from(units), i64::from(height) * i64::from(units));
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(
            text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {across} {down}\">"
        );
        if !title.is_empty() {
            let _ = writeln!(text, "<title>{}</title>", escaped(title));
        }
        let _ = writeln!(text, "<desc>low-poly by polyreel; {units} units are one pixel</desc>");
        Self { text, units, masks: 0 }
    }

    /// The facets and lines of a mesh, each in a group.
    pub(crate) fn frame(&mut self, mesh: &Mesh, colours: &[Rgba], options: &SvgOptions<'_>) {
        let lines = options.lines;
        let masked = lines.iter().any(|lines| lines.colour[3] < 255);
        if masked {
            self.masks += 1;
            let (id, units) = (self.masks, self.units);
            let [w, h] = [mesh.size.width, mesh.size.height].map(|side| (side as i32 + 2) * units);
            let _ = writeln!(
                self.text,
                "<mask id=\"beside-lines-{id}\" maskUnits=\"userSpaceOnUse\" x=\"-{units}\" y=\"-{units}\" \
                 width=\"{w}\" height=\"{h}\">\n<path fill=\"#fff\" d=\"m-{units}-{units}h{w}v{h}h-{w}z\"/>"
            );
            for line in lines {
                if line.colour[3] < 255 {
                    self.lines(mesh, "", &Lines { colour: [0, 0, 0, 255], strength: 1.0, ..*line });
                }
            }
            let _ = writeln!(self.text, "</mask>\n<g mask=\"url(#beside-lines-{id})\">");
        }
        self.facets(mesh, colours, options.seams);
        if masked {
            self.text.push_str("</g>\n");
        }
        for (i, line) in lines.iter().enumerate() {
            self.lines(mesh, if i == 0 { " id=\"outline\"" } else { "" }, line);
        }
    }

    /// The facets, in a group.
    fn facets(&mut self, mesh: &Mesh, colours: &[Rgba], seams: Seams) {
        assert_eq!(colours.len(), mesh.triangles.len(), "a colour a triangle");
        let vertices = self.rounded(mesh);
        let ground = ground(colours).filter(|_| seams != Seams::None);
        match seams {
            Seams::Stroke => {
                let width = self.units;
                let _ = writeln!(
                    self.text,
                    "<g id=\"facets\" stroke-width=\"{width}\" stroke-linejoin=\"round\">"
                );
            }
            _ => self.text.push_str("<g id=\"facets\">\n"),
        }
        if let Some(colour) = ground {
            self.ground(mesh, colour);
        }
        let shapes = match seams {
            Seams::Underlap => underlap::shapes(mesh, &vertices, colours, self.units),
            _ => underlap::triangles(mesh, colours),
        };
        for shape in &shapes {
            let colour = colours[shape.facet as usize];
            let mut data = PathData::default();
            for polygon in &shape.polygons {
                data.polygon(polygon.iter().map(|&v| vertices[v as usize]), seams == Seams::Stroke);
            }
            self.path(colour, &data, seams == Seams::Stroke);
        }
        self.text.push_str("</g>\n");
    }

    /// What shows where facets are smaller than a pixel, and in the last pixels at sizes that are no whole number.
    fn ground(&mut self, mesh: &Mesh, colour: Rgba) {
        let (units, [r, g, b, _]) = (self.units, colour);
        let [w, h] = [mesh.size.width, mesh.size.height].map(|side| (side as i32 + 2) * units);
        let _ = writeln!(
            self.text,
            "<path fill=\"#{r:02x}{g:02x}{b:02x}\" d=\"m-{units}-{units}h{w}v{h}h-{w}z\"/>"
        );
    }

    fn path(&mut self, [r, g, b, a]: Rgba, data: &PathData, stroked: bool) {
        let _ = write!(self.text, "<path fill=\"#{r:02x}{g:02x}{b:02x}\"");
        if stroked {
            let _ = write!(self.text, " stroke=\"#{r:02x}{g:02x}{b:02x}\"");
        }
        if a < 255 {
            let _ = write!(self.text, " opacity=\"{}\"", path::decimal(f64::from(a) / 255.0, 3));
        }
        let _ = writeln!(self.text, " d=\"{}\"/>", data.text());
    }

    fn lines(&mut self, mesh: &Mesh, id: &str, lines: &Lines<'_>) {
        let vertices = self.rounded(mesh);
        let [r, g, b, a] = lines.colour;
        let width = path::decimal(lines.width * f64::from(self.units), 2);
        let _ = write!(
            self.text,
            "<g{id} fill=\"none\" stroke=\"#{r:02x}{g:02x}{b:02x}\" stroke-width=\"{width}\" \
             stroke-linecap=\"round\" stroke-linejoin=\"round\""
        );
        let opacity = f64::from(a) / 255.0 * lines.strength;
        if opacity < 1.0 {
            let _ = write!(self.text, " opacity=\"{}\"", path::decimal(opacity, 3));
        }
        let data = lines::path(&vertices, lines.edges);
        let _ = writeln!(self.text, ">\n<path d=\"{}\"/>\n</g>", data.text());
    }

    /// The document's text, complete.
    pub(crate) fn end(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    fn rounded(&self, mesh: &Mesh) -> Vec<(i32, i32)> {
        let part = crate::geom::SUBPIXEL / self.units;
        let round = |v: i32| (v + part / 2).div_euclid(part);
        mesh.vertices.iter().map(|p| (round(p.x), round(p.y))).collect()
    }
}

/// The mean colour, where all facets are opaque.
fn ground(colours: &[Rgba]) -> Option<Rgba> {
    if colours.is_empty() || colours.iter().any(|colour| colour[3] < 255) {
        return None;
    }
    let mean = |c: usize| {
        let sum: u64 = colours.iter().map(|colour| u64::from(colour[c])).sum();
        (sum / colours.len() as u64) as u8
    };
    Some([mean(0), mean(1), mean(2), 255])
}

/// `text` with what XML needs otherwise; control characters, which XML has none of, are left out.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => {}
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests;
