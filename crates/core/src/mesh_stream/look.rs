//! Edges, lines and grading as text in the header of a stream.

use super::Header;
use crate::options::{Colour, Edges, FillMode, Options, Shape};

impl Header {
    /// Adds the options for painting.
    pub fn put_look(&mut self, options: &Options) {
        self.put("edges", options.edges.name());
        if let Some(outline) = options.outline {
            self.put("outline", outline);
        }
        self.put("outline-width", options.outline_width);
        self.put("outline-contrast", options.outline_contrast);
        if options.line_colour().is_some() && options.coherence != Options::default().coherence {
            // Lines hold to those of the frame before.
            self.put("coherence", options.coherence);
        }
        self.put("saturation", options.saturation);
        self.put("wash", options.wash);
        if options.outline_opacity != 1.0 {
            self.put("outline-opacity", options.outline_opacity);
        }
        if options.outline_tint != 0.0 {
            self.put("outline-tint", options.outline_tint);
        }
        if options.contrast != 1.0 {
            self.put("contrast", options.contrast);
        }
        if options.chroma != 1.0 {
            self.put("chroma", options.chroma);
        }
        if let Some(duotone) = options.duotone {
            self.put("duotone", duotone);
        }
        if let Some(palette) = &options.palette {
            self.put("palette", palette);
        }
        if options.fill != FillMode::Mean {
            self.put("fill", options.fill.name());
        }
        if options.shape != Shape::Triangles {
            self.put("shape", options.shape.name());
        }
    }

    /// The options for painting; all others are the defaults. Invalid values are ignored.
    pub fn look(&self) -> Options {
        let mut options = Options::default();
        if let Some(name) = self.get("edges") {
            options.edges = Edges::ALL.into_iter().find(|e| e.name() == name).unwrap_or_default();
        }
        options.outline = self.get("outline").and_then(|text| text.parse::<Colour>().ok());
        if let Some(name) = self.get("fill") {
            options.fill = FillMode::ALL.into_iter().find(|f| f.name() == name).unwrap_or_default();
        }
        if let Some(name) = self.get("shape") {
            options.shape = Shape::ALL.into_iter().find(|s| s.name() == name).unwrap_or_default();
        }
        fn read<T: std::str::FromStr>(header: &Header, name: &str, value: &mut T) {
            if let Some(found) = header.get(name).and_then(|text| text.parse().ok()) {
                *value = found;
            }
        }
        read(self, "outline-width", &mut options.outline_width);
        read(self, "outline-contrast", &mut options.outline_contrast);
        read(self, "outline-opacity", &mut options.outline_opacity);
        read(self, "outline-tint", &mut options.outline_tint);
        read(self, "coherence", &mut options.coherence);
        read(self, "saturation", &mut options.saturation);
        read(self, "wash", &mut options.wash);
        read(self, "contrast", &mut options.contrast);
        read(self, "chroma", &mut options.chroma);
        options.duotone = self.get("duotone").and_then(|text| text.parse().ok());
        options.palette = self.get("palette").and_then(|text| text.parse().ok());
        if options.validate().is_ok() { options } else { Options::default() }
    }
}
