//! The options of the look.

mod load;
mod repaint;

use std::fmt::Display;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use polyreel::error::{Error, Result};
use polyreel::options::{
    CellPercentiles, Colour, Duotone, Edges, FillMode, Focus, FrontEnd, Length, Method, Options,
    Palette, Points, Prefilter, Quality, Shape, Target, Thresholds,
};

pub(crate) use load::{preset, study};

use load::{load_focus, palette};

/// How the result looks. Every field that is given replaces the preset's.
#[derive(Debug, Args)]
#[command(next_help_heading = "Look")]
pub(crate) struct LookArgs {
    /// Begin with the settings of a preset (see 'polyreel presets') or of a preset file; options given
    /// with it win [default: none]
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub(crate) preset: Option<String>,
    /// Begin with the settings of an earlier system: gai-2015, zhang-2016, qian-2016, uasmith-2017, ma-2017, ng-2017,
    /// lawonn-2018, pic2polyart-2021, laske-2024, joseph-entropy-2024, joseph-region-2024, or the paper's hrlp, help,
    /// hslp; options given with it win [default: none]
    #[arg(long, value_name = "NAME", conflicts_with = "preset")]
    pub(crate) study: Option<String>,
    /// How feature points and seeds are found
    #[arg(long, value_name = "NAME", value_parser = methods(), help = with_default(
        "How feature points and seeds are found", Options::default().method.name()))]
    pub(crate) method: Option<Method>,
    #[arg(long, value_name = "N|N%|auto", help = with_default(
        "Seeds of a frame: a count (2000), a count that is the same at any size but for sprites, which have fewer \
         (1200@1MP), a share of its pixels (1.5%), or auto: as many as the picture asks for, by how its error falls, \
         followed slowly over the frames of a shot; with --error the fewest, to 2 %, that reach it on the first \
         frame",
        Options::default().points))]
    pub(crate) points: Option<Points>,
    #[arg(long, value_name = "S", help = with_default(
        "Decides all chance: the same seed gives the same bytes", Options::default().seed))]
    seed: Option<u64>,
    #[arg(long, value_name = "C", help = with_default(
        "How firmly a frame holds to the one before, 0 (each frame alone) to 1 (least flicker)",
        Options::default().coherence))]
    coherence: Option<f64>,
    #[arg(long, value_name = "NAME", value_parser = one_of(Quality::ALL, Quality::name), help = with_default(
        "How much work goes into refinement: none, most of the gain, all of it; auto is best for a still, normal for a \
         film",
        Options::default().quality.name()))]
    quality: Option<Quality>,
    /// Steps of refinement in place of --quality: of a still, and of each frame of an animation, the
    /// first of a shot getting a few more [default: as --quality]
    #[arg(long, value_name = "STEPS", conflicts_with = "quality")]
    refine: Option<u32>,
    /// Refine a still, and the first frame of a shot, until it is as like its source as this, in place
    /// of a number of steps: psnr:30 or 30dB (over RGB), ssim:0.8 (of the luma, window of 7x7); where
    /// that is out of reach, a warning is given [default: none]
    #[arg(long, value_name = "E", conflicts_with = "refine")]
    error: Option<Target>,
    #[arg(long, value_name = "R", help = with_default(
        "How much well-shaped triangles count against the error, 0 (not at all) to 1 (only they do)",
        Options::default().regularity))]
    regularity: Option<f64>,
    /// Side of the smallest facets, in pixels or as a share of the picture's shorter side (2%), as of equilateral
    /// triangles: refinement keeps to it, but for a few in a hundred [default: none]
    #[arg(long, value_name = "PX|N%")]
    min_facet: Option<Length>,
    /// Side of the largest facets [default: none]
    #[arg(long, value_name = "PX|N%")]
    max_facet: Option<Length>,
    #[arg(long, value_name = "NAME", value_parser = one_of(Edges::ALL, Edges::name), help = with_default(
        "How triangles meet: smooth, a step spread over two pixels, or hard; GIFs always have hard edges",
        Options::default().edges.name()))]
    pub(crate) edges: Option<Edges>,
    /// Draw the edges of the mesh, in black or in COLOUR (white, #802040, or darker or lighter: tints
    /// of the facets beside it); the other options of the
    /// outline draw them, too [default: none]
    #[arg(long, value_name = "COLOUR", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "black")]
    outline: Option<Ink>,
    #[arg(long, value_name = "PX|N%", help = with_default(
        "Width of the outline: pixels (2, 2px), or a share of the picture's shorter side (0.3%)",
        Options::default().outline_width))]
    outline_width: Option<Length>,
    #[arg(long, value_name = "N", help = with_default(
        "Draw the outline the stronger the more colours differ, half as strong where they do by N of 255; 0 draws \
         all of it alike",
        Options::default().outline_contrast))]
    outline_contrast: Option<u32>,
    #[arg(long, value_name = "O", help = with_default(
        "How opaque the outline is, 0 to 1", Options::default().outline_opacity))]
    outline_opacity: Option<f64>,
    #[arg(long, value_name = "T", help = with_default(
        "How much of the outline's colour is that of the facets beside it, 0 to 1: --outline=white \
         --outline-tint 0.6 is a lighter tint of each",
        Options::default().outline_tint))]
    outline_tint: Option<f64>,
    #[arg(long, value_name = "S", help = with_default(
        "How strong colours are, 0 (grey) to 4", Options::default().saturation))]
    saturation: Option<f64>,
    #[arg(long, value_name = "W", help = with_default(
        "How far colours are washed out as by water, 0 (not at all) to 1 (white); black stays", Options::default().wash))]
    wash: Option<f64>,
    #[arg(long, value_name = "NAME", value_parser = one_of(FillMode::ALL, FillMode::name), help = with_default(
        "What triangles are filled with: their mean or median colour, that at their centroid, a plane of colour \
         (linear), colours that go on over edges (gouraud), or none: lines on transparency",
        Options::default().fill.name()))]
    fill: Option<FillMode>,
    #[arg(long, value_name = "C", help = with_default(
        "How far light and dark lie apart, 0 to 4, in steps that look equal", Options::default().contrast))]
    contrast: Option<f64>,
    #[arg(long, value_name = "S", help = with_default(
        "As --saturation, but lightness and hue stay: skin does not burn", Options::default().chroma))]
    chroma: Option<f64>,
    /// Print in two tones: colours in place of black and white (navy,#ffe8c0) [default: none]
    #[arg(long, value_name = "DARK,LIGHT")]
    duotone: Option<Duotone>,
    /// The colours that the picture may have: a number of them, learned from the first frame and kept; a list
    /// (#102030,gold,white); or a file of them, .gpl or .hex [default: none]
    #[arg(long, value_name = "N|COLOURS|NAME.gpl", value_parser = palette)]
    palette: Option<Palette>,
    #[arg(long, value_name = "NAME", value_parser = one_of(Shape::ALL, Shape::name), help = with_default(
        "What is filled and outlined together: triangles, polygons (panes of like colour), or the cells of a \
         Voronoi diagram",
        Options::default().shape.name()))]
    shape: Option<Shape>,
    /// Where the picture gets more and smaller facets: faces, or saliency, found in every frame; X,Y,R, a place and a radius
    /// (50%,40%,20%, or pixels); or MASK, a picture that is light there [default: none]
    #[arg(long, value_name = "faces|X,Y,R|MASK")]
    focus: Option<Focus>,
    #[arg(long, value_name = "N", help = with_default(
        "How often a frame is smoothed before its colours are clustered, 0 to 8 (in the paper 0)",
        Options::default().smoothing))]
    smoothing: Option<u32>,
    #[arg(long, value_name = "K", help_heading = PAPER, help = with_default(
        "Colour clusters of the regions, 2 to 64", Options::default().clusters))]
    clusters: Option<u32>,
    #[arg(long, value_name = "N", help_heading = PAPER, help = with_default(
        "Every how many pixels of a region's boundary one is a feature point, 1 to 64",
        Options::default().interval))]
    interval: Option<u32>,
    #[arg(long, value_name = "SHARE", help_heading = PAPER, help = with_default(
        "Share of the pixels inside regions that are feature points, 0 to 1",
        Options::default().interior))]
    interior: Option<f64>,
    /// Area of a grid cell as a share of the frame's, in place of --points [default: solved from
    /// --points]
    #[arg(long, value_name = "SHARE", conflicts_with = "points", help_heading = PAPER)]
    hex_density: Option<f64>,
    #[arg(long, value_name = "N", help_heading = PAPER, help = with_default(
        "Points that the densest cells keep, 1 to 64", Options::default().max_points))]
    max_points: Option<u32>,
    #[arg(long, value_name = "N", help_heading = PAPER, help = with_default(
        "Points that the sparsest cells keep, 0 to --max-points", Options::default().default_points))]
    default_points: Option<u32>,
    #[arg(long, value_name = "H,M,L", help_heading = PAPER, help = with_default(
        "Feature points per pixel above which a cell counts as of high, medium, low density",
        thresholds()))]
    thresholds: Option<Thresholds>,
    #[arg(long, value_name = "NAME", help_heading = SCORES, value_parser = one_of(FrontEnd::ALL, FrontEnd::name))]
    /// Where feature points come from, for any method [default: the method's own]
    features: Option<FrontEnd>,
    #[arg(long, value_name = "NAME", help_heading = SCORES, value_parser = one_of(Prefilter::ALL, Prefilter::name))]
    /// What a frame goes through before features are looked for: a blur, sharpening, or the bilateral filter [default:
    /// none]
    prefilter: Option<Prefilter>,
    #[arg(long, value_name = "SHARE", help_heading = SCORES, help = with_default(
        "Share of the seeds that lie anywhere, at random, 0 to 1", Options::default().scatter))]
    scatter: Option<f64>,
    #[arg(long, value_name = "SHARE", help_heading = SCORES, help = with_default(
        "Share of the pixels that a map (entropy, saliency, sobel, laplacian) or slic makes feature \
         points, up to 1",
        Options::default().candidates))]
    candidates: Option<f64>,
    #[arg(long, value_name = "N", help_heading = SCORES, help = with_default(
        "Points that every cell gets before the rest is shared out by value (help, hslp), 0 to 64",
        Options::default().min_points))]
    min_points: Option<u32>,
    #[arg(long, value_name = "H,M", help_heading = SCORES, help = with_default(
        "Percentiles of the cells' mean value that tell high, medium and low cells (help, hslp)",
        percentiles()))]
    percentiles: Option<CellPercentiles>,
    #[arg(long, value_name = "PX", help_heading = SCORES, help = with_default(
        "Radius of the disk of the entropy, 1 to 32", Options::default().entropy_radius))]
    entropy_radius: Option<u32>,
    #[arg(long, value_name = "N", help_heading = SCORES, help = with_default(
        "Steps of the anisotropic diffusion before the entropy, 0 to 1000",
        Options::default().diffusion_iterations))]
    diffusion_iterations: Option<u32>,
    #[arg(long, value_name = "K", help_heading = SCORES, help = with_default(
        "Differences of luma above which the diffusion takes them for edges, up to 1000",
        Options::default().diffusion_kappa))]
    diffusion_kappa: Option<f64>,
    #[arg(long, value_name = "G", help_heading = SCORES, help = with_default(
        "Length of a step of the diffusion, up to 0.25", Options::default().diffusion_gamma))]
    diffusion_gamma: Option<f64>,
}

/// What an outline is drawn with.
#[derive(Clone, Copy, Debug)]
struct Ink {
    colour: Colour,
    /// How much of it is of the facets' colour; `None` for what the other options say.
    tint: Option<f64>,
}

/// The share of the facets' colour in a tint of it.
const TINT: f64 = 0.55;

impl std::str::FromStr for Ink {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let tint_with = |grey| Ink { colour: Colour([grey, grey, grey, 255]), tint: Some(TINT) };
        match text {
            "darker" | "auto" => Ok(tint_with(0)),
            "lighter" => Ok(tint_with(255)),
            _ => Ok(Ink { colour: text.parse()?, tint: None }),
        }
    }
}

const PAPER: &str = "The paper's parameters";
const SCORES: &str = "Feature maps, and the methods that score every pixel";

impl LookArgs {
    /// The given options without those of the study.
    pub(crate) fn without_study(&self) -> Result<Options> {
        self.changed(Options::default())
    }

    fn ink(&self) -> Option<Colour> {
        self.outline.map(|ink| ink.colour)
    }

    fn tint(&self) -> Option<f64> {
        self.outline_tint.or(self.outline.and_then(|ink| ink.tint))
    }

    /// The outline of whoever gives only its width or contrast: in black, as `--outline` alone.
    fn implied_outline(&self) -> Option<Colour> {
        let implied = self.outline_width.is_some()
            || self.outline_contrast.is_some()
            || self.outline_opacity.is_some()
            || self.outline_tint.is_some();
        implied.then_some(Colour([0, 0, 0, 255]))
    }

    /// The preset's options (by default `Options::default()`), changed by the given ones.
    pub(crate) fn options(&self) -> Result<Options> {
        self.changed(match (&self.preset, &self.study) {
            (Some(name), _) => preset(name)?,
            (None, Some(name)) => study(name)?,
            (None, None) => Options::default(),
        })
    }

    /// `options` changed by the given ones.
    fn changed(&self, mut options: Options) -> Result<Options> {
        fn put<T: Clone>(field: &mut T, given: &Option<T>) {
            if let Some(value) = given {
                field.clone_from(value);
            }
        }
        put(&mut options.method, &self.method);
        put(&mut options.points, &self.points);
        put(&mut options.seed, &self.seed);
        put(&mut options.coherence, &self.coherence);
        put(&mut options.quality, &self.quality);
        put(&mut options.regularity, &self.regularity);
        put(&mut options.edges, &self.edges);
        put(&mut options.outline_width, &self.outline_width);
        put(&mut options.outline_contrast, &self.outline_contrast);
        put(&mut options.outline_opacity, &self.outline_opacity);
        put(&mut options.outline_tint, &self.tint());
        put(&mut options.saturation, &self.saturation);
        put(&mut options.wash, &self.wash);
        put(&mut options.fill, &self.fill);
        put(&mut options.contrast, &self.contrast);
        put(&mut options.chroma, &self.chroma);
        options.duotone = self.duotone.or(options.duotone);
        options.palette = self.palette.clone().or(options.palette);
        put(&mut options.shape, &self.shape);
        options.focus = self.focus.clone().or(options.focus);
        load_focus(&mut options)?;
        options.min_facet = self.min_facet.or(options.min_facet);
        options.max_facet = self.max_facet.or(options.max_facet);
        put(&mut options.smoothing, &self.smoothing);
        put(&mut options.clusters, &self.clusters);
        put(&mut options.interval, &self.interval);
        put(&mut options.interior, &self.interior);
        put(&mut options.max_points, &self.max_points);
        put(&mut options.default_points, &self.default_points);
        put(&mut options.thresholds, &self.thresholds);
        if self.refine.is_some() || self.quality.is_some() {
            options.refine = self.refine;
        }
        options.error = self.error.or(options.error);
        put(&mut options.candidates, &self.candidates);
        put(&mut options.min_points, &self.min_points);
        put(&mut options.percentiles, &self.percentiles);
        put(&mut options.entropy_radius, &self.entropy_radius);
        put(&mut options.diffusion_iterations, &self.diffusion_iterations);
        put(&mut options.diffusion_kappa, &self.diffusion_kappa);
        put(&mut options.diffusion_gamma, &self.diffusion_gamma);
        options.features = self.features.or(options.features);
        options.prefilter = self.prefilter.or(options.prefilter);
        put(&mut options.scatter, &self.scatter);
        options.outline = self.ink().or(options.outline).or(self.implied_outline());
        options.hex_density = self.hex_density.or(options.hex_density);
        if self.points.is_some() {
            // A given number of points replaces the grid of the preset.
            options.hex_density = None;
        }
        options.validate()?;
        Ok(options)
    }
}

/// `options` for a stream of frames: even where each frame is alone, the first is no still.
pub(crate) fn of_a_stream(mut options: Options) -> Options {
    if options.quality == Quality::Auto {
        options.quality = Quality::Normal;
    }
    options
}

/// A help text with the default at its end.
fn with_default(text: &str, default: impl Display) -> String {
    format!("{text} [default: {default}]")
}

fn thresholds() -> String {
    let Thresholds { high, medium, low } = Options::default().thresholds;
    format!("{high},{medium},{low}")
}

fn percentiles() -> String {
    let CellPercentiles { high, medium } = Options::default().percentiles;
    format!("{high},{medium}")
}

/// A value by its name, one of `all`.
pub(crate) fn one_of<T, const N: usize>(
    all: [T; N],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T>
where
    T: Copy + Send + Sync + 'static,
{
    PossibleValuesParser::new(all.map(name)).try_map(move |given| {
        let found = all.into_iter().find(|&value| name(value) == given);
        found.ok_or_else(|| Error::usage(format!("there is no {given}")))
    })
}

pub(crate) fn methods() -> impl TypedValueParser<Value = Method> {
    one_of(Method::ALL, Method::name)
}

#[cfg(test)]
mod tests;
