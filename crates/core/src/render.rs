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
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
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
    /// Number of feature points that level one found.
    pub candidates: usize,
}

/// Renders frame after frame; the mesh and its colours live on between them.
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
    /// When an option is out of range.
    pub fn new(options: &Options) -> Result<Self> {
        Chain::new(options).map(Self)
    }

    /// The same, and pictures are painted as planes of this `form` where they can be: see
    /// [`Painter::with_form`](crate::rasterise::Painter::with_form).
    #[doc(hidden)]
    pub fn with_form(self, form: Option<Form>) -> Self {
        Self(self.0.with_form(form))
    }

    /// Changes the options from the next frame on. The mesh lives on where the change only concerns what is
    /// done with it (coherence, refinement, outline); else the next frame starts afresh.
    ///
    /// # Errors
    /// When an option is out of range; nothing is changed then.
    pub fn retune(&mut self, options: &Options) -> Result<()> {
        self.0.retune(options)
    }

    /// The next frame as low-poly art.
    ///
    /// # Errors
    /// Where [`Options::error`] cannot be measured (SSIM of a frame smaller than its window), or not be
    /// reached by any number of [`Points::Auto`](crate::options::Points::Auto).
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
            candidates: features.candidates.len(),
        })
    }
}
