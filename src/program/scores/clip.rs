//! The figures of a clip: speed, likeness, flicker, and how long seeds live.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::{Plan, Variant, over_white};
use polyreel::error::Result;
use polyreel::frame::Frame;
use polyreel::geom::Size;
use polyreel::metric::flicker::Flicker;
use polyreel::metric::mse::mse;
use polyreel::metric::ssim::ssim;
use polyreel::metric::warp::WarpError;
use polyreel::render::Renderer;
use polyreel::source::Source;

/// The figures of a method on a clip.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct ClipMethodScores {
    /// The method, study or preset.
    pub(crate) method: String,
    /// Frames per second from pixels to pixels, one frame after the other: no decoding, no encoding.
    pub(crate) fps: f64,
    /// Mean SSIM of the frames (rounded luma, 7x7); `None` for frames smaller than the window.
    pub(crate) ssim: Option<f64>,
    /// Mean squared error over all frames.
    pub(crate) mse: f64,
    /// FDB ([`Flicker`]), 0..510; `None` for a single frame.
    pub(crate) fdb: Option<f64>,
    /// E_warp of the rendering ([`WarpError`]), 0..1.
    pub(crate) warp_error: Option<f64>,
    /// Seeds of a frame in the mean.
    pub(crate) seeds: f64,
    /// Seeds of the frame before that a frame keeps in the mean, in place or moved; from the second
    /// frame on.
    pub(crate) seeds_kept: f64,
}

/// The figures of a clip.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct ClipScores {
    /// The file.
    pub(crate) path: PathBuf,
    /// Width and height as evaluated.
    pub(crate) size: Size,
    /// Frames that were evaluated.
    pub(crate) frames: u64,
    /// E_warp of the source itself: what is left to its own motion and noise.
    pub(crate) source_warp_error: Option<f64>,
    /// One entry a method, in the plan's order, without refinement.
    pub(crate) methods: Vec<ClipMethodScores>,
    /// The same with refinement; empty where the plan has none.
    pub(crate) refined: Vec<ClipMethodScores>,
}

impl ClipScores {
    /// One entry a method, without or with refinement.
    pub(crate) fn of(&self, refined: bool) -> &[ClipMethodScores] {
        if refined { &self.refined } else { &self.methods }
    }
}

/// A method in the middle of a clip.
struct Run<'a> {
    variant: Variant<'a>,
    renderer: Renderer,
    time: Duration,
    ssim: Option<f64>,
    mse: f64,
    flicker: Flicker,
    warp: WarpError,
    seeds: usize,
    kept: usize,
}

impl<'a> Run<'a> {
    fn new(variant: Variant<'a>) -> Result<Self> {
        Ok(Self {
            variant,
            renderer: Renderer::new(variant.options())?,
            time: Duration::ZERO,
            ssim: Some(0.0),
            mse: 0.0,
            flicker: Flicker::new(),
            warp: WarpError::new(),
            seeds: 0,
            kept: 0,
        })
    }

    /// The next frame, as it is and over white. Returns the rendering over white.
    fn push(&mut self, frame: &Frame, source: &Frame) -> Result<Frame> {
        let began = Instant::now();
        let rendered = self.renderer.render(frame)?;
        self.time += began.elapsed();
        let painted = over_white(&rendered.picture);
        let like = ssim(source, &painted).ok();
        self.ssim = self.ssim.zip(like).map(|(sum, ssim)| sum + ssim);
        self.mse += mse(source, &painted)?;
        self.flicker.push(source, &painted)?;
        self.warp.push(source, &painted)?;
        self.seeds += rendered.mesh.seed_ids().count();
        self.kept += rendered.life.kept + rendered.life.moved;
        Ok(painted)
    }

    fn scores(&self, frames: u64) -> ClipMethodScores {
        let n = frames.max(1) as f64;
        ClipMethodScores {
            method: self.variant.subject.name.clone(),
            fps: frames as f64 / self.time.as_secs_f64().max(1e-9),
            ssim: self.ssim.map(|sum| sum / n),
            mse: self.mse / n,
            fdb: self.flicker.value(),
            warp_error: self.warp.value(),
            seeds: self.seeds as f64 / n,
            seeds_kept: self.kept as f64 / (frames.max(2) - 1) as f64,
        }
    }
}

/// Evaluates all frames of `frames`, one at a time; memory does not grow with their number. `seen` is
/// shown the first frame's renderings, over white, and `done` is called after every frame.
///
/// # Errors
/// When a frame cannot be read, or an option is out of range.
pub(crate) fn evaluate_clip(
    path: PathBuf,
    frames: &mut dyn Source,
    plan: &Plan,
    seen: &mut dyn FnMut(Option<Variant<'_>>, &Frame),
    done: &mut dyn FnMut(),
) -> Result<ClipScores> {
    let runs = plan.variants().map(Run::new);
    let mut runs = runs.collect::<Result<Vec<_>>>()?;
    let mut own = WarpError::new();
    let (mut size, mut count) = (Size::new(0, 0), 0);
    while let Some(decoded) = frames.next()? {
        let source = over_white(&decoded.frame);
        size = source.size();
        own.push(&source, &source)?;
        if count == 0 {
            seen(None, &source);
        }
        for run in &mut runs {
            let painted = run.push(&decoded.frame, &source)?;
            if count == 0 {
                seen(Some(run.variant), &painted);
            }
        }
        count += 1;
        done();
    }
    let scores = |refined: bool| {
        let runs = runs.iter().filter(|run| run.variant.refined == refined);
        runs.map(|run| run.scores(count)).collect()
    };
    Ok(ClipScores {
        path,
        size,
        frames: count,
        source_warp_error: own.value(),
        methods: scores(false),
        refined: scores(true),
    })
}
