//! Animated SVG: every frame a group that is shown in its time (SMIL, no script), so that it plays in an `<img>`.

use std::fmt::Write as _;

use super::{Document, SvgOptions, path};
use crate::frame::Rgba;
use crate::mesh::Mesh;

/// The most facets, of all frames together, that an animated SVG may hold: some 6 MB, which browsers take half a
/// second to read (measured in Chromium).
pub const MOST_FACETS: usize = 100_000;

/// An animation would hold more than [`MOST_FACETS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "an animated SVG holds at most {MOST_FACETS} triangles in all its frames, and {frames} frames have {facets}"
)]
pub struct TooManyFacets {
    /// Frames so far.
    pub frames: usize,
    /// Triangles in them.
    pub facets: usize,
}

/// An animation being written.
#[derive(Debug, Default)]
pub struct AnimatedSvg {
    document: Option<Document>,
    /// Where each frame's group begins in the text, and when it is shown, in seconds.
    frames: Vec<(usize, f64)>,
    facets: usize,
}

impl AnimatedSvg {
    /// Adds a frame that is shown from `start` on, in seconds. The first frame's title is the document's.
    ///
    /// # Errors
    /// When that makes it too large.
    ///
    /// # Panics
    /// When there are not as many colours as triangles.
    pub fn push(
        &mut self,
        mesh: &Mesh,
        colours: &[Rgba],
        start: f64,
        options: &SvgOptions<'_>,
    ) -> Result<(), TooManyFacets> {
        self.facets += mesh.triangles.len();
        if self.facets > MOST_FACETS {
            return Err(TooManyFacets { frames: self.frames.len() + 1, facets: self.facets });
        }
        let document = self.document.get_or_insert_with(|| Document::begin(mesh, options.title));
        self.frames.push((document.text.len(), start));
        document.frame(mesh, colours, options);
        Ok(())
    }

    /// The document; it plays until `end`, in seconds, and `plays` times (`None` is without end).
    pub fn finish(self, end: f64, plays: Option<u32>) -> String {
        let Some(Document { text, .. }) = self.document else { return String::new() };
        let first = self.frames[0];
        let length = (end - first.1).max(1e-3);
        let mut out = String::with_capacity(text.len() + 200 * self.frames.len());
        out.push_str(&text[..first.0]);
        let ends = self.frames.iter().skip(1).map(|&(at, start)| (at, (start - first.1) / length));
        let ends = ends.chain([(text.len(), 1.0)]);
        for (&(at, start), (until, stop)) in self.frames.iter().zip(ends) {
            let body = &text[at..until];
            // Ids are the document's: an animation's frames have none of their own.
            let body = body.replacen(" id=\"facets\"", "", 1).replacen(" id=\"outline\"", "", 1);
            let shown = ((start - first.1) / length, stop);
            let _ = write!(out, "<g{}>", if at == first.0 { "" } else { " display=\"none\"" });
            if self.frames.len() > 1 {
                out.push_str(&animation(shown, length, plays));
            }
            let _ = write!(out, "\n{body}</g>\n");
        }
        out.push_str("</svg>\n");
        out
    }
}

/// Shows a group from one share of the animation's `length` to another.
fn animation((from, to): (f64, f64), length: f64, plays: Option<u32>) -> String {
    let share = |share: f64| path::decimal(share.clamp(0.0, 1.0), 6);
    let (mut values, mut times) = ("inline".to_owned(), "0".to_owned());
    if from > 0.0 {
        values = "none;inline".to_owned();
        let _ = write!(times, ";{}", share(from));
    }
    if to < 1.0 {
        values.push_str(";none");
        let _ = write!(times, ";{}", share(to));
    }
    let repeat = match plays {
        None => "repeatCount=\"indefinite\"".to_owned(),
        Some(n) => format!("repeatCount=\"{}\" fill=\"freeze\"", n.max(1)),
    };
    let length = path::decimal(length, 6);
    format!(
        "<animate attributeName=\"display\" values=\"{values}\" keyTimes=\"{times}\" dur=\"{length}s\" \
         calcMode=\"discrete\" {repeat}/>"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use crate::triangulate::triangulate;

    #[test]
    fn each_frame_has_its_time() {
        let mesh = triangulate(Size::new(8, 8), &[]).expect("corners");
        let colours = [[1, 2, 3, 255], [200, 3, 4, 255]];
        let mut svg = AnimatedSvg::default();
        for start in [1.0, 1.5, 2.0] {
            svg.push(&mesh, &colours, start, &SvgOptions::default()).expect("small");
        }
        let text = svg.finish(3.0, None);
        assert!(text.contains("values=\"inline;none\" keyTimes=\"0;0.25\" dur=\"2s\""), "{text}");
        assert!(text.contains("values=\"none;inline;none\" keyTimes=\"0;0.25;0.5\""), "{text}");
        assert!(text.contains("values=\"none;inline\" keyTimes=\"0;0.5\""), "{text}");
        assert_eq!(text.matches("display=\"none\"").count(), 2);
        assert!(resvg::usvg::Tree::from_str(&text, &resvg::usvg::Options::default()).is_ok());
    }

    #[test]
    fn too_many_facets_are_refused() {
        let mesh = triangulate(Size::new(8, 8), &[]).expect("corners");
        let mut svg = AnimatedSvg { facets: MOST_FACETS - 3, ..AnimatedSvg::default() };
        let colours = [[1, 2, 3, 255]; 2];
        svg.push(&mesh, &colours, 0.0, &SvgOptions::default()).expect("just below");
        let error = svg.push(&mesh, &colours, 1.0, &SvgOptions::default()).expect_err("above");
        assert_eq!(error, TooManyFacets { frames: 2, facets: MOST_FACETS + 1 });
    }
}
