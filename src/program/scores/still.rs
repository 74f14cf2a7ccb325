//! The figures of one still.

use std::path::PathBuf;
use std::time::Instant;

use super::disturb::Disturbance;
use super::{Plan, Variant, over_white};
use polyreel::error::{Error, Result};
use polyreel::frame::Frame;
use polyreel::geom::Size;
use polyreel::mesh_stream::{Grid, pack};
use polyreel::metric::mse::{mse, psnr};
use polyreel::metric::ssim::{ssim, ssim_gaussian};
use polyreel::options::Options;
use polyreel::render::{Rendered, Renderer};

/// The likeness of a rendering to its source.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct Likeness {
    /// SSIM of the rounded luma, uniform window of 7x7, -1..1; `None` for frames smaller than that.
    pub(crate) ssim: Option<f64>,
    /// SSIM of the rounded luma, Gaussian window of 11x11; `None` for frames smaller than that.
    pub(crate) ssim_gaussian: Option<f64>,
    /// Mean squared error over RGB, 0..65025.
    pub(crate) mse: f64,
    /// Its peak signal-to-noise ratio in decibels; `None` where nothing differs.
    pub(crate) psnr: Option<f64>,
}

impl Likeness {
    /// The likeness of two opaque frames.
    ///
    /// # Errors
    /// When they differ in size.
    pub(crate) fn of(source: &Frame, rendered: &Frame) -> Result<Self> {
        let mse = mse(source, rendered)?;
        Ok(Self {
            ssim: ssim(source, rendered).ok(),
            ssim_gaussian: ssim_gaussian(source, rendered).ok(),
            mse,
            psnr: Some(psnr(mse)).filter(|v| v.is_finite()),
        })
    }
}

/// The figures of a method on a still.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct MethodScores {
    /// The method, study or preset.
    pub(crate) method: String,
    /// Feature points of level one.
    pub(crate) candidates: usize,
    /// 100 - 100 x feature points / pixels, as the paper's Table 2 prints its rates.
    pub(crate) candidates_rate: f64,
    /// Seeds of level two, border points among them, corners not.
    pub(crate) seeds: usize,
    /// 100 - 100 x seeds / pixels.
    pub(crate) seeds_rate: f64,
    /// Triangles of the mesh.
    pub(crate) triangles: usize,
    /// Bytes of the mesh with its colours as a key frame of a mesh stream.
    pub(crate) mesh_bytes: usize,
    /// 100 - 100 x mesh bytes / file bytes, where the picture is a file read at its full size.
    pub(crate) reduction: Option<f64>,
    /// Likeness to the source.
    pub(crate) likeness: Likeness,
    /// Steps of refinement that were done.
    pub(crate) refine_steps: u32,
    /// Milliseconds from pixels to pixels: no decoding, no encoding.
    pub(crate) ms: f64,
    /// Likeness of the renderings of disturbed pictures to the undisturbed source; without refinement
    /// alone.
    pub(crate) robustness: Vec<(Disturbance, Likeness)>,
}

/// The figures of a still.
#[derive(Clone, Debug, serde::Serialize)]
pub(crate) struct StillScores {
    /// The file.
    pub(crate) path: PathBuf,
    /// Width and height as evaluated.
    pub(crate) size: Size,
    /// Bytes of the file.
    pub(crate) file_bytes: Option<u64>,
    /// One entry a method, in the plan's order, without refinement.
    pub(crate) methods: Vec<MethodScores>,
    /// The same with refinement; empty where the plan has none.
    pub(crate) refined: Vec<MethodScores>,
}

impl StillScores {
    /// One entry a method, without or with refinement.
    pub(crate) fn of(&self, refined: bool) -> &[MethodScores] {
        if refined { &self.refined } else { &self.methods }
    }
}

/// Evaluates `frame` of the file `path`; `file_bytes` where the frame is all of the file. `seen` is
/// shown every rendering, over white.
///
/// # Errors
/// When an option is out of range.
pub(crate) fn evaluate_still(
    path: PathBuf,
    frame: &Frame,
    file_bytes: Option<u64>,
    plan: &Plan,
    seen: &mut dyn FnMut(Variant<'_>, &Frame),
) -> Result<StillScores> {
    let source = over_white(frame);
    let disturbed: Vec<(Disturbance, Frame)> = if plan.robustness {
        let all = Disturbance::ALL.into_iter();
        all.map(|d| Ok((d, d.apply(&source, plan.options.seed)?))).collect::<Result<_>>()?
    } else {
        Vec::new()
    };
    let (mut methods, mut refined) = (Vec::new(), Vec::new());
    for variant in plan.variants() {
        // No frame follows a still: the number of steps is exact.
        let options = Options { coherence: 0.0, ..variant.options().clone() };
        let render = |frame: &Frame| Renderer::new(&options)?.render(frame);
        let began = Instant::now();
        let rendered = render(frame)?;
        let ms = began.elapsed().as_secs_f64() * 1e3;
        let painted = over_white(&rendered.picture);
        seen(variant, &painted);
        let likeness = Likeness::of(&source, &painted)?;
        let disturbed = if variant.refined { &[] } else { &disturbed[..] };
        let tried = disturbed.iter().map(|(disturbance, frame)| {
            Ok((*disturbance, Likeness::of(&source, &render(frame)?.picture)?))
        });
        let robustness = tried.collect::<Result<_>>()?;
        let scores = scores(variant.subject.name.clone(), file_bytes, &rendered, likeness, ms)?;
        let list = if variant.refined { &mut refined } else { &mut methods };
        list.push(MethodScores { robustness, ..scores });
    }
    Ok(StillScores { path, size: frame.size(), file_bytes, methods, refined })
}

fn scores(
    method: String,
    file_bytes: Option<u64>,
    rendered: &Rendered,
    likeness: Likeness,
    ms: f64,
) -> Result<MethodScores> {
    let size = rendered.mesh.size;
    let rate = |points: usize| 100.0 - 100.0 * points as f64 / size.pixels() as f64;
    let seeds = rendered.mesh.seed_ids().count();
    let colours: Vec<_> = rendered.mesh.fills.iter().map(|fill| fill.colour).collect();
    let packed = pack(&rendered.mesh, &colours, Grid::EXACT);
    let mesh_bytes = packed.map_err(|fault| Error::failed(fault.to_string()))?.len();
    let reduction = |bytes: u64| 100.0 - 100.0 * mesh_bytes as f64 / bytes.max(1) as f64;
    Ok(MethodScores {
        method,
        candidates: rendered.candidates,
        candidates_rate: rate(rendered.candidates),
        seeds,
        seeds_rate: rate(seeds),
        triangles: rendered.mesh.triangles.len(),
        mesh_bytes,
        reduction: file_bytes.map(reduction),
        likeness,
        refine_steps: rendered.refine_steps,
        ms,
        robustness: Vec::new(),
    })
}
