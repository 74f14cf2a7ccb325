//! The chain on one thread: the API for stills and streams, and the oracle of the threaded pipeline.

use crate::chain::Chain;
use crate::colour::Form;
use crate::error::Result;
use crate::frame::Frame;
use crate::mesh::Mesh;
use crate::options::{Detail, Options};
use crate::sample::Life;

/// A frame that went through the chain.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rendered {
    /// The low-poly picture, of the frame's size.
    pub picture: Frame,
    /// The mesh behind it, with its colours.
    pub mesh: Mesh,
    /// How its seeds came to be.
    pub life: Life,
    /// Steps of refinement that were done.
    pub refine_steps: u32,
    /// Likeness to the source in the measure of [`Options::error`], where it was refined to that.
    pub likeness: Option<f64>,
    /// Number of faces in focus, where [`Focus::Faces`](crate::Focus::Faces) asks for them; with none saliency was in
    /// their place.
    pub faces: Option<usize>,
    /// Number of feature points that level one found.
    pub candidates: usize,
}

/// Renders a stream of frames. The mesh and its colours are carried from each frame to the next.
///
/// ```
/// use polyreel_core::{Frame, Options, Points, Renderer, Size};
/// # fn main() -> polyreel_core::Result<()> {
/// let size = Size::new(64, 48);
/// let gradient = (0..size.pixels()).map(|i| [(i % 64 * 4) as u8, (i / 64 * 5) as u8, 90, 255]);
/// let frame = Frame::new(size, gradient.collect())?;
///
/// let mut options = Options::default();
/// options.points = Points::Count(60);
/// let rendered = Renderer::new(&options)?.render(&frame)?;
/// assert_eq!(rendered.mesh.seeds().len(), 60);
/// assert_eq!(rendered.picture.size(), size);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Renderer(Chain);

impl Renderer {
    /// A renderer for one stream of frames.
    ///
    /// # Errors
    /// When an option is out of range, or options do not fit together: see [`Options::validate`].
    pub fn new(options: &Options) -> Result<Self> {
        Chain::new(options).map(Self)
    }

    /// The same, and pictures are painted as planes of this `form` where they can be: see
    /// [`Painter::with_form`](crate::rasterise::Painter::with_form).
    #[doc(hidden)]
    pub fn with_form(self, form: Option<Form>) -> Self {
        Self(self.0.with_form(form))
    }

    /// Forgets all frames, as if the renderer were new: the next frame is the first of a new stream. The options
    /// stay as they are. Frames that follow may have another size.
    ///
    /// ```
    /// use polyreel_core::{Frame, Options, Points, Renderer, Size};
    /// # fn main() -> polyreel_core::Result<()> {
    /// let mut options = Options::default();
    /// options.points = Points::Count(20);
    /// let mut renderer = Renderer::new(&options)?;
    /// let frame = Frame::filled(Size::new(64, 48), [90, 120, 60, 255])?;
    /// let first = renderer.render(&frame)?;
    /// renderer.reset();
    /// assert_eq!(renderer.render(&frame)?, first);
    /// # Ok(())
    /// # }
    /// ```
    pub fn reset(&mut self) {
        self.0.reset();
    }

    /// Changes the options from the next frame on. The mesh is kept if the change concerns only what is done with
    /// it (coherence, refinement, edges, outline, grading); else the next frame starts afresh.
    ///
    /// # Errors
    /// When an option is out of range, or options do not fit together. Nothing is changed then.
    pub fn retune(&mut self, options: &Options) -> Result<()> {
        self.0.retune(options)
    }

    /// The next frame as low-poly art. A frame of another size than the last one starts afresh.
    ///
    /// # Errors
    /// When [`Options::error`] cannot be measured (SSIM of a frame smaller than its window of 7 x 7 pixels), or no
    /// number of points reaches it ([`Points::Auto`](crate::options::Points::Auto)).
    pub fn render(&mut self, frame: &Frame) -> Result<Rendered> {
        self.render_in(frame, &Detail::FULL)
    }

    /// The next frame, at the cost of `detail`.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    #[doc(hidden)]
    pub fn render_in(&mut self, frame: &Frame, detail: &Detail) -> Result<Rendered> {
        let (features, meshed, painting) = self.0.run(frame, detail, &mut ())?;
        let mut mesh = meshed.mesh;
        mesh.fills = painting.fills;
        // The outline's colour is no triangle's.
        mesh.fills.truncate(mesh.triangles.len());
        Ok(Rendered {
            picture: painting.frame,
            mesh,
            life: meshed.life,
            refine_steps: meshed.refined.steps,
            likeness: meshed.refined.likeness,
            faces: meshed.faces,
            candidates: features.candidates.len(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{Coding, Layout, Matrix, Range};
    use crate::geom::Size;
    use crate::options::{Points, Target};

    const SIZE: Size = Size::new(64, 48);

    /// A disc that moves over a gradient.
    fn frame(index: usize) -> Frame {
        let pixel = |i: usize| {
            let (x, y) = (i % 64, i / 64);
            let inside = x.abs_diff(16 + 3 * index).pow(2) + y.abs_diff(24).pow(2) < 90;
            if inside { [210, 40, 30, 255] } else { [(x * 4) as u8, (y * 5) as u8, 90, 255] }
        };
        Frame::new(SIZE, (0..SIZE.pixels()).map(pixel).collect()).expect("a small frame")
    }

    #[test]
    fn a_reset_renderer_renders_as_a_new_one() {
        let coding = Coding { matrix: Matrix::Bt709, range: Range::Limited };
        let planes = Form { layout: Layout::of_video(SIZE), coding };
        let auto =
            Options { points: Points::Auto, error: Some(Target::Psnr(22.0)), ..Options::default() };
        let counted = Options { points: Points::Count(60), ..Options::default() };
        for (options, form) in [(&counted, None), (&counted, Some(planes)), (&auto, None)] {
            let new = || Renderer::new(options).expect("sound options").with_form(form);
            let three = |renderer: &mut Renderer, first: usize| {
                [0, 1, 2].map(|i| renderer.render(&frame(first + i)).expect("renders"))
            };
            let expected = three(&mut new(), 4);
            let mut renderer = new();
            three(&mut renderer, 0);
            renderer.reset();
            assert!(three(&mut renderer, 4) == expected, "{options:?} {form:?}");
        }
    }
}
