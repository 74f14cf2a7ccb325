//! Edges, lines and grading as text in the header of a mesh stream.

use crate::mesh_stream::Header;
use crate::options::{Colour, Edges, Options};

/// Writes the options for painting to `header`.
pub(crate) fn put(options: &Options, header: &mut Header) {
    header.put("edges", options.edges.name());
    if let Some(outline) = options.outline {
        header.put("outline", outline);
    }
    header.put("outline-width", options.outline_width);
    header.put("outline-contrast", options.outline_contrast);
    header.put("saturation", options.saturation);
    header.put("wash", options.wash);
}

/// Reads the options for painting from `header`; all others are the defaults. Invalid values are ignored.
pub(crate) fn of(header: &Header) -> Options {
    let mut options = Options::default();
    if let Some(name) = header.get("edges") {
        options.edges = Edges::ALL.into_iter().find(|e| e.name() == name).unwrap_or_default();
    }
    options.outline = header.get("outline").and_then(|text| text.parse::<Colour>().ok());
    fn read<T: std::str::FromStr>(header: &Header, name: &str, value: &mut T) {
        if let Some(found) = header.get(name).and_then(|text| text.parse().ok()) {
            *value = found;
        }
    }
    read(header, "outline-width", &mut options.outline_width);
    read(header, "outline-contrast", &mut options.outline_contrast);
    read(header, "saturation", &mut options.saturation);
    read(header, "wash", &mut options.wash);
    if options.validate().is_ok() { options } else { Options::default() }
}
