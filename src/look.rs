//! Edges, lines and grading as text in the header of a mesh stream.

use crate::mesh_stream::Header;
use crate::options::{Colour, Edges, FillMode, Options, Shape};

/// Writes the options for painting to `header`.
pub(crate) fn put(options: &Options, header: &mut Header) {
    header.put("edges", options.edges.name());
    if let Some(outline) = options.outline {
        header.put("outline", outline);
    }
    header.put("outline-width", options.outline_width);
    header.put("outline-contrast", options.outline_contrast);
    if options.line_colour().is_some() && options.coherence != Options::default().coherence {
        // Lines hold to those of the frame before.
        header.put("coherence", options.coherence);
    }
    header.put("saturation", options.saturation);
    header.put("wash", options.wash);
    if options.outline_opacity != 1.0 {
        header.put("outline-opacity", options.outline_opacity);
    }
    if options.outline_tint != 0.0 {
        header.put("outline-tint", options.outline_tint);
    }
    if options.contrast != 1.0 {
        header.put("contrast", options.contrast);
    }
    if options.chroma != 1.0 {
        header.put("chroma", options.chroma);
    }
    if let Some(duotone) = options.duotone {
        header.put("duotone", duotone);
    }
    if let Some(palette) = &options.palette {
        header.put("palette", palette);
    }
    if options.fill != FillMode::Mean {
        header.put("fill", options.fill.name());
    }
    if options.shape != Shape::Triangles {
        header.put("shape", options.shape.name());
    }
}

/// Reads the options for painting from `header`; all others are the defaults. Invalid values are ignored.
pub(crate) fn of(header: &Header) -> Options {
    let mut options = Options::default();
    if let Some(name) = header.get("edges") {
        options.edges = Edges::ALL.into_iter().find(|e| e.name() == name).unwrap_or_default();
    }
    options.outline = header.get("outline").and_then(|text| text.parse::<Colour>().ok());
    if let Some(name) = header.get("fill") {
        options.fill = FillMode::ALL.into_iter().find(|f| f.name() == name).unwrap_or_default();
    }
    if let Some(name) = header.get("shape") {
        options.shape = Shape::ALL.into_iter().find(|s| s.name() == name).unwrap_or_default();
    }
    fn read<T: std::str::FromStr>(header: &Header, name: &str, value: &mut T) {
        if let Some(found) = header.get(name).and_then(|text| text.parse().ok()) {
            *value = found;
        }
    }
    read(header, "outline-width", &mut options.outline_width);
    read(header, "outline-contrast", &mut options.outline_contrast);
    read(header, "outline-opacity", &mut options.outline_opacity);
    read(header, "outline-tint", &mut options.outline_tint);
    read(header, "coherence", &mut options.coherence);
    read(header, "saturation", &mut options.saturation);
    read(header, "wash", &mut options.wash);
    read(header, "contrast", &mut options.contrast);
    read(header, "chroma", &mut options.chroma);
    options.duotone = header.get("duotone").and_then(|text| text.parse().ok());
    options.palette = header.get("palette").and_then(|text| text.parse().ok());
    if options.validate().is_ok() { options } else { Options::default() }
}
