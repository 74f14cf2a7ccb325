//! What a render is asked to do: one plain structure, presets, and their validation.

mod cells;
mod colour;
mod detail;
mod facets;
mod focus;
mod names;
mod palette;
mod points;
mod preset;
mod study;
mod target;
mod validate;

pub use cells::{CellPercentiles, Thresholds};
pub use colour::Colour;
#[doc(hidden)]
pub use detail::EIGHTHS;
pub use detail::{Detail, Look, Steps};
pub use facets::FacetSides;
pub use focus::{Focus, FocusMask, Length, Spot};
pub use names::{Edges, FillMode, FrontEnd, Method, Prefilter, Quality, Shape};
pub use palette::{Duotone, Palette};
pub use points::Points;
pub use preset::{PRESETS, Preset};
pub use study::STUDIES;
pub use target::Target;

use crate::geom::MAX_SIDE;

/// How to render: everything that decides the bytes of the output, but the input itself.
///
/// ```
/// use polyreel_core::{Options, Points};
/// let mut options = Options::default();
/// options.points = Points::Count(500);
/// options.seed = 7;
/// options.validate().expect("these are sound");
/// ```
///
/// Fields may be added in later versions: begin with [`Options::default`], [`Options::paper`] or
/// [`Options::preset`], and set fields.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields, rename_all = "kebab-case")
)]
#[cfg_attr(not(feature = "literals"), non_exhaustive)]
pub struct Options {
    /// Levels one and two. Default [`Method::Hrlp`].
    pub method: Method,
    /// Target seeds for a frame. Default 1200 of a picture of 1024 x 1024 pixels, see [`Points::Scaled`].
    pub points: Points,
    /// Seed of all random numbers. Default 0.
    pub seed: u64,
    /// How closely a frame follows the one before, 0 (each frame alone) to 1 (least flicker, at the
    /// price of likeness). Above 0 the mesh is carried from frame to frame. Default 0.4.
    pub coherence: f64,
    /// How much work goes into refinement: on video, frames smaller than 1280 x 720 get more steps in the
    /// time that these take. Default [`Quality::Auto`].
    pub quality: Quality,
    /// Number of refinement steps, 0..=1000, in place of [`Options::quality`]: for a still, and for each frame
    /// of a stream. The first frame of a shot gets at least 4, unless the number is 0. Default `None`.
    pub refine: Option<u32>,
    /// Likeness at which the refinement of a fresh mesh stops, in place of a number of steps; it goes
    /// as far as [`Quality::Best`] where the target is out of reach. The frames that follow it in a
    /// shot are refined as [`Options::quality`] says. Default `None`.
    pub error: Option<Target>,
    /// How much well-shaped triangles count against the error, 0 (contours above all) to 1 (nothing else). Above 0.5
    /// facets are of more equal size, too: the less points go where the error is, the higher it is. Default 0.5.
    pub regularity: f64,
    /// How often the frame is smoothed (3x3 binomial) before its colours are clustered, 0..=8, so that
    /// grain draws no regions; the paper does not. Default 2.
    pub smoothing: u32,
    /// Colour clusters of level one, 2..=64. Default 8.
    pub clusters: u32,
    /// Distance of candidates along a region's boundary in pixels, 1..=64. Default 3 (see `docs/calibration.md`).
    pub interval: u32,
    /// Share of the pixels inside the regions that become candidates, 0..=1. Default 0.001.
    pub interior: f64,
    /// Area of a grid cell as a share of the frame's area, above 0 and at most 1; `None` solves it
    /// from [`Options::points`]. Default `None`.
    pub hex_density: Option<f64>,
    /// Points that the densest cells keep, 1..=64. Default 4.
    pub max_points: u32,
    /// Points that the sparsest cells keep, where they have any, 0..=`max_points`. Default 1.
    pub default_points: u32,
    /// Densities that divide cells into dense and sparse ones.
    pub thresholds: Thresholds,
    /// Where feature points come from; `None` takes the method's own. Default `None`.
    pub features: Option<FrontEnd>,
    /// What a frame goes through before features are looked for. Default `None`.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub prefilter: Option<Prefilter>,
    /// Share of the seeds that lie anywhere, at random, 0..=1. Default 0.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub scatter: f64,
    /// Share of the pixels that a map which scores every pixel (entropy, saliency, Sobel, Laplacian)
    /// or superpixels make feature points, above 0 and at most 1. Default 0.054 (paper, Table 2).
    pub candidates: f64,
    /// Points that every cell gets before the rest is shared out by value (paper, Algorithm 3),
    /// 0..=64. Default 1.
    pub min_points: u32,
    /// Which cells are high, medium and low (paper, Algorithm 3). Default 75, 25.
    pub percentiles: CellPercentiles,
    /// Radius of the entropy's disk in pixels, 1..=32. Default 5 (paper, HELP).
    pub entropy_radius: u32,
    /// Steps of the diffusion before the entropy, 0..=1000. Default 10.
    pub diffusion_iterations: u32,
    /// Differences of luma above which the diffusion takes them for edges, above 0 and at most 1000.
    /// Default 50 (see `docs/calibration.md`).
    pub diffusion_kappa: f64,
    /// Length of a step of the diffusion, above 0 and at most 0.25. Default 0.25.
    pub diffusion_gamma: f64,
    /// How two triangles meet. Default [`Edges::Smooth`]. Pictures with a palette always have hard edges.
    pub edges: Edges,
    /// Colour of lines drawn along the edges of the mesh; `None` draws none. Default `None`.
    pub outline: Option<Colour>,
    /// Width of these lines: up to 256 pixels, or a share of the frame's shorter side of at most a tenth. Default 1
    /// pixel.
    pub outline_width: Length,
    /// The difference in a channel, 0..=255, of the colours of two triangles between which a line has half its
    /// strength: it has none at half of that, and all at half as much again. 0 draws all lines alike. Default 0.
    pub outline_contrast: u32,
    /// How opaque lines are, 0..=1. Default 1.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_one"))]
    pub outline_opacity: f64,
    /// How much of a line's colour is that of the facets beside it, 0 (none) to 1 (all). Default 0.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub outline_tint: f64,
    /// How strong colours are, 0 (grey) to 4; 1 leaves them as they are. Default 1.
    pub saturation: f64,
    /// How far colours are washed out towards white, as paint by water, 0 (not at all) to 1 (white): what is light
    /// first, black not at all. Default 0.
    pub wash: f64,
    /// What a triangle is filled with. Default [`FillMode::Mean`].
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub fill: FillMode,
    /// What is filled and outlined together. Default [`Shape::Triangles`].
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub shape: Shape,
    /// How far light and dark lie apart, 0 (all the same) to 4, in steps of equal lightness (CIE L*); 1 leaves colours
    /// as they are. Default 1.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_one"))]
    pub contrast: f64,
    /// How strong colours are, 0 (grey) to 4, of the same lightness and hue (CIE L*a*b*); 1 leaves them as they are.
    /// Default 1.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_one"))]
    pub chroma: f64,
    /// The colours that black and white become, and all between them by lightness. Default `None`.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub duotone: Option<Duotone>,
    /// The colours that a picture may have; a number of them is learned from the first frame and kept. Default
    /// `None`.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub palette: Option<Palette>,
    /// Where a picture gets more and smaller facets. Default `None`.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub focus: Option<Focus>,
    /// The side of the smallest facet: that of an equilateral triangle of its area. Refinement keeps to it. Default
    /// `None`.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub min_facet: Option<Length>,
    /// The side of the largest facet. Default `None`.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "is_default"))]
    pub max_facet: Option<Length>,
}

/// The same of options whose default is 1.
#[cfg(feature = "serde")]
fn is_one(value: &f64) -> bool {
    *value == 1.0
}

/// Whether an option has its default, and so need not be written: options of later versions are left out where
/// nothing asks for them.
#[cfg(feature = "serde")]
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl Default for Options {
    fn default() -> Self {
        Self {
            method: Method::default(),
            points: Points::default(),
            seed: 0,
            coherence: 0.4,
            quality: Quality::default(),
            refine: None,
            error: None,
            regularity: 0.5,
            smoothing: 2,
            clusters: 8,
            interval: 3,
            interior: 0.001,
            hex_density: None,
            max_points: 4,
            default_points: 1,
            thresholds: Thresholds::default(),
            features: None,
            prefilter: None,
            scatter: 0.0,
            candidates: 0.054,
            min_points: 1,
            percentiles: CellPercentiles::default(),
            entropy_radius: 5,
            diffusion_iterations: 10,
            diffusion_kappa: 50.0,
            diffusion_gamma: 0.25,
            edges: Edges::default(),
            outline: None,
            outline_width: Length::Pixels(1.0),
            outline_contrast: 0,
            outline_opacity: 1.0,
            outline_tint: 0.0,
            saturation: 1.0,
            wash: 0.0,
            fill: FillMode::default(),
            shape: Shape::default(),
            contrast: 1.0,
            chroma: 1.0,
            duotone: None,
            palette: None,
            focus: None,
            min_facet: None,
            max_facet: None,
        }
    }
}

impl Options {
    /// How far all places get equally many points, 0 (as many as the picture asks for) to 1.
    #[doc(hidden)]
    pub fn evenness(&self) -> f64 {
        (2.0 * self.regularity - 1.0).max(0.0)
    }

    /// The colour of lines that are drawn: [`Options::outline`]; black where nothing else would be seen.
    #[doc(hidden)]
    pub fn line_colour(&self) -> Option<Colour> {
        const BLACK: Colour = Colour([0, 0, 0, 255]);
        self.outline.or((self.fill == FillMode::None).then_some(BLACK))
    }

    /// The same look without grading: colours stay as they were found, for what grades them later. Lines stay, as
    /// meshes of looks with lines are calmer.
    #[doc(hidden)]
    pub fn ungraded(&self) -> Self {
        Self {
            outline: self.line_colour(),
            saturation: 1.0,
            wash: 0.0,
            contrast: 1.0,
            chroma: 1.0,
            duotone: None,
            palette: None,
            ..self.clone()
        }
    }

    /// The same without lines that are seen, and with a colour for each facet: for outputs that store meshes.
    #[doc(hidden)]
    pub fn plain(&self) -> Self {
        let fill = if self.fill == FillMode::None { FillMode::Mean } else { self.fill };
        Self { fill, outline_opacity: 0.0, ..self.ungraded() }
    }

    /// The same look for pictures `times` as large: lengths in pixels, of lines and of facets, are so, too.
    #[doc(hidden)]
    pub fn enlarged(&self, times: f64) -> Self {
        let scaled = |length: Length, least: f64, most: f64| match length {
            Length::Pixels(pixels) => Length::Pixels((pixels * times).clamp(least, most)),
            share => share,
        };
        // The least ones of facets are as far apart as they have to be.
        let facet = |side: Option<Length>, least| side.map(|s| scaled(s, least, MAX_SIDE.into()));
        Self {
            outline_width: scaled(self.outline_width, 0.1, 256.0),
            min_facet: facet(self.min_facet, 1.0),
            max_facet: facet(self.max_facet, 1.5),
            ..self.clone()
        }
    }

    /// Whether seeds that were chosen by `other` are still valid under these options: all differences, if any,
    /// concern later stages.
    #[doc(hidden)]
    pub fn keeps_seeds_of(&self, other: &Self) -> bool {
        self.seed_options() == other.seed_options()
    }

    /// The options that decide the choice of seeds; all others have their defaults.
    fn seed_options(&self) -> Self {
        // Exhaustive: the compiler asks where a new option belongs.
        let Self {
            method,
            points,
            seed,
            error,
            smoothing,
            clusters,
            interval,
            interior,
            hex_density,
            max_points,
            default_points,
            thresholds,
            features,
            prefilter,
            scatter,
            candidates,
            min_points,
            percentiles,
            entropy_radius,
            diffusion_iterations,
            diffusion_kappa,
            diffusion_gamma,
            // For the time between frames and for refinement.
            coherence: _,
            quality: _,
            refine: _,
            regularity,
            // For painting.
            edges: _,
            outline: _,
            outline_width: _,
            outline_contrast: _,
            outline_opacity: _,
            outline_tint: _,
            saturation: _,
            wash: _,
            fill: _,
            shape: _,
            contrast: _,
            chroma: _,
            duotone: _,
            palette: _,
            focus,
            min_facet,
            max_facet,
        } = self.clone();
        Self {
            method,
            points,
            seed,
            // Below that, the sizes of facets do not depend on it.
            regularity: regularity.max(0.5),
            // The number of points follows from it.
            error: error.filter(|_| points == Points::Auto),
            smoothing,
            clusters,
            interval,
            interior,
            hex_density,
            max_points,
            default_points,
            thresholds,
            features,
            prefilter,
            scatter,
            candidates,
            min_points,
            percentiles,
            entropy_radius,
            diffusion_iterations,
            diffusion_kappa,
            diffusion_gamma,
            focus,
            min_facet,
            max_facet,
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;

    #[test]
    fn points_are_counts_or_shares() {
        assert_eq!("2000".parse::<Points>().expect("a count"), Points::Count(2000));
        assert_eq!("0.8%".parse::<Points>().expect("a share"), Points::Share(0.008));
        assert_eq!(Points::Share(0.008).to_string(), "0.8%");
        assert!("0.8".parse::<Points>().is_err());
        assert!("many".parse::<Points>().is_err());
        assert_eq!(Points::Share(0.008).target(Size::new(1024, 1024)), 8388);
        assert_eq!(Points::Count(9).target(Size::new(2, 2)), 4);
        assert_eq!("1200@1MP".parse::<Points>().expect("of a megapixel"), Points::Scaled(1200));
        assert_eq!(Points::Scaled(1200).to_string(), "1200@1MP");
        assert!("1200@2MP".parse::<Points>().is_err());
    }

    #[test]
    fn the_same_picture_has_about_as_many_points_at_any_size() {
        let count = |side| Points::default().target(Size::new(side, side)) as f64;
        let counts = [512, 1024, 4096].map(count);
        assert!(counts.is_sorted() && counts[2] / counts[0] <= 1.2, "{counts:?}");
        assert_eq!(counts[1], 1200.0);
        // A sprite of few pixels has no more than the paper gives it.
        assert_eq!(count(64), 32.0);
        assert_eq!(count(1), 0.0);
    }

    #[test]
    fn colours_parse_and_print() {
        for (text, rgba) in [
            ("#fff", [255; 4]),
            ("#102030", [16, 32, 48, 255]),
            ("#10203040", [16, 32, 48, 64]),
            ("Teal", [0, 128, 128, 255]),
        ] {
            let colour: Colour = text.parse().expect(text);
            assert_eq!(colour.0, rgba);
            assert_eq!(colour.to_string().parse::<Colour>().expect("printed").0, rgba);
        }
        for wrong in ["", "#", "#12", "#ggg", "blurple"] {
            assert!(wrong.parse::<Colour>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn validation_names_the_field() {
        Options::default().validate().expect("the defaults are sound");
        let said = |options: Options| options.validate().expect_err("out of range").to_string();
        let base = Options::default;
        assert!(said(Options { points: Points::Count(0), ..base() }).contains("points"));
        assert!(said(Options { points: Points::Share(f64::NAN), ..base() }).contains("points"));
        let error = Some(Target::Ssim(0.5));
        Options { points: Points::Auto, error, ..base() }.validate().expect("a target to reach");
        Options { points: Points::Auto, ..base() }.validate().expect("what the picture asks for");
        let both = Options { points: Points::Auto, error, hex_density: Some(0.01), ..base() };
        assert!(said(both).contains("hex-density"));
        for wrong in [Target::Ssim(1.0), Target::Psnr(f64::NAN), Target::Psnr(0.0)] {
            assert!(said(Options { error: Some(wrong), ..base() }).contains("error"));
        }
        assert!(said(Options { clusters: 1, ..base() }).contains("clusters"));
        assert!(said(Options { hex_density: Some(0.0), ..base() }).contains("hex-density"));
        assert!(said(Options { candidates: 0.0, ..base() }).contains("candidates"));
        assert!(said(Options { min_points: 65, ..base() }).contains("min-points"));
        assert!(said(Options { entropy_radius: 0, ..base() }).contains("entropy-radius"));
        assert!(said(Options { diffusion_kappa: f64::NAN, ..base() }).contains("diffusion-kappa"));
        assert!(said(Options { diffusion_gamma: 0.3, ..base() }).contains("diffusion-gamma"));
        // Above 0, but not in 32 bits.
        assert!(said(Options { diffusion_kappa: 1e-60, ..base() }).contains("diffusion-kappa"));
        assert!(said(Options { diffusion_gamma: 1e-60, ..base() }).contains("diffusion-gamma"));
        let percentiles = CellPercentiles { high: 20.0, medium: 30.0 };
        assert!(said(Options { percentiles, ..base() }).contains("percentiles"));
        let thresholds = Thresholds { high: 0.1, medium: 0.2, low: 0.0 };
        assert!(said(Options { thresholds, ..base() }).contains("thresholds"));
    }

    #[cfg(feature = "serde")]
    #[test]
    fn options_survive_a_preset_file() {
        let options = Options {
            outline: Some(Colour([1, 2, 3, 255])),
            points: Points::Auto,
            error: Some(Target::Psnr(30.0)),
            ..Options::default()
        };
        let text = toml::to_string(&options).expect("options are plain data");
        assert_eq!(toml::from_str::<Options>(&text).expect("what was written"), options);
        let error = toml::from_str::<Options>("pionts = \"3\"").expect_err("a misspelt key");
        assert!(error.to_string().contains("pionts"));
    }
}
