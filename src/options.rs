//! What a render is asked to do: one plain structure, presets, and their validation.

mod target;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::frame::Rgba;
use crate::geom::Size;
pub use target::Target;

/// Level one and two of the chain, by the names of the paper (its section 3; the last three are the
/// methods that it compares itself with in section 4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// K-means colour regions, thinned by density on the hexagonal grid (HRLP; Algorithm 1).
    #[default]
    Hrlp,
    /// Anisotropic diffusion, then local entropy; cells share by their mean entropy (HELP;
    /// Algorithm 3).
    Help,
    /// Spectral-residual saliency; cells share by their mean saliency (HSLP; Algorithm 3).
    Hslp,
    /// The colour regions of HRLP, thinned at random, without a grid (baseline RLP).
    Rlp,
    /// The entropy of HELP, its maximum taken again and again, each time suppressed by a Gaussian
    /// (baseline ENTROPY).
    Entropy,
    /// Canny's edges and salient points, a quarter of the seeds for each band of saliency (baseline
    /// Pic2PolyArt). The original looks for faces as well; this one does not: see
    /// [`crate::sample::bands`].
    Pic2polyart,
}

impl Method {
    /// All methods, in the order in which they are listed.
    pub const ALL: [Method; 6] = [
        Method::Hrlp,
        Method::Help,
        Method::Hslp,
        Method::Rlp,
        Method::Entropy,
        Method::Pic2polyart,
    ];

    /// The name on the command line and in presets.
    pub const fn name(self) -> &'static str {
        match self {
            Method::Hrlp => "hrlp",
            Method::Help => "help",
            Method::Hslp => "hslp",
            Method::Rlp => "rlp",
            Method::Entropy => "entropy",
            Method::Pic2polyart => "pic2polyart",
        }
    }

    /// The front end that the method brings along. That of [`Method::Pic2polyart`] adds salient
    /// points to it.
    pub const fn own_features(self) -> FrontEnd {
        match self {
            Method::Hrlp | Method::Rlp => FrontEnd::Regions,
            Method::Help | Method::Entropy => FrontEnd::Entropy,
            Method::Hslp => FrontEnd::Saliency,
            Method::Pic2polyart => FrontEnd::Canny,
        }
    }
}

/// Ways to find feature points: those of the paper's methods, and those of the related work that it
/// names in section 2. Any of them can stand before any method's level two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FrontEnd {
    /// Sobel's gradient ([`crate::feature::edges::sobel`]).
    Sobel,
    /// The Laplacian ([`crate::feature::edges::laplacian`]).
    Laplacian,
    /// Canny's edges ([`crate::feature::canny`]).
    Canny,
    /// Corners of SLIC superpixels ([`crate::feature::slic`]).
    Slic,
    /// Boundaries of k-means colour regions ([`crate::feature::region`]).
    Regions,
    /// Entropy after anisotropic diffusion ([`crate::feature::entropy`]).
    Entropy,
    /// Spectral-residual saliency ([`crate::feature::saliency`]).
    Saliency,
}

impl FrontEnd {
    /// All front ends, in the order in which they are listed.
    pub const ALL: [FrontEnd; 7] = [
        FrontEnd::Sobel,
        FrontEnd::Laplacian,
        FrontEnd::Canny,
        FrontEnd::Slic,
        FrontEnd::Regions,
        FrontEnd::Entropy,
        FrontEnd::Saliency,
    ];

    /// The name on the command line and in presets.
    pub const fn name(self) -> &'static str {
        match self {
            FrontEnd::Sobel => "sobel",
            FrontEnd::Laplacian => "laplacian",
            FrontEnd::Canny => "canny",
            FrontEnd::Slic => "slic",
            FrontEnd::Regions => "regions",
            FrontEnd::Entropy => "entropy",
            FrontEnd::Saliency => "saliency",
        }
    }
}

/// How much work goes into refinement, where [`Options::refine`] does not say it in steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// None.
    Draft,
    /// Most of the gain for a third of the time.
    #[default]
    Normal,
    /// Until nothing is left to gain.
    Best,
}

impl Quality {
    /// All, in rising order.
    pub const ALL: [Quality; 3] = [Quality::Draft, Quality::Normal, Quality::Best];

    /// The name on the command line and in presets.
    pub const fn name(self) -> &'static str {
        match self {
            Quality::Draft => "draft",
            Quality::Normal => "normal",
            Quality::Best => "best",
        }
    }
}

/// How many seeds a frame is to have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Points {
    /// This many.
    Count(u32),
    /// This share of the pixels, 0..1 (the command line and presets write per cent).
    Share(f64),
    /// The fewest that reach [`Options::error`], found on the first frame.
    Auto,
}

impl Points {
    /// The number of seeds for a frame of `size`; never more than it has pixels. Of [`Points::Auto`],
    /// as long as it has not been found, the default.
    pub fn target(self, size: Size) -> usize {
        let wanted = match self {
            Points::Count(n) => n as usize,
            Points::Share(share) => (size.pixels() as f64 * share).floor() as usize,
            Points::Auto => Points::default().target(size),
        };
        wanted.min(size.pixels())
    }
}

impl Default for Points {
    fn default() -> Self {
        // Paper, Table 2: 0.8 % of the pixels are left after level two.
        Points::Share(0.008)
    }
}

impl std::str::FromStr for Points {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let wrong = || {
            Error::usage(format!(
                "'{text}' is not a number of points: write a count (2000), a share (0.8%) or auto"
            ))
        };
        if let Some(percent) = text.strip_suffix('%') {
            let percent: f64 = percent.trim().parse().map_err(|_| wrong())?;
            Ok(Points::Share(percent / 100.0))
        } else if text.trim() == "auto" {
            Ok(Points::Auto)
        } else {
            Ok(Points::Count(text.trim().parse().map_err(|_| wrong())?))
        }
    }
}

impl TryFrom<String> for Points {
    type Error = Error;
    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<Points> for String {
    fn from(points: Points) -> String {
        points.to_string()
    }
}

impl std::fmt::Display for Points {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Points::Count(n) => write!(f, "{n}"),
            // Six digits hide the binary rounding of percent / 100 * 100.
            Points::Share(share) => write!(f, "{}%", (share * 1e8).round() / 1e6),
            Points::Auto => f.write_str("auto"),
        }
    }
}

/// A colour as options name it: `#rgb`, `#rrggbb`, `#rrggbbaa` or a basic name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Colour(pub Rgba);

/// The sixteen colour names of HTML 4, and `transparent`.
const COLOUR_NAMES: [(&str, Rgba); 17] = [
    ("black", [0, 0, 0, 255]),
    ("silver", [192, 192, 192, 255]),
    ("gray", [128, 128, 128, 255]),
    ("white", [255, 255, 255, 255]),
    ("maroon", [128, 0, 0, 255]),
    ("red", [255, 0, 0, 255]),
    ("purple", [128, 0, 128, 255]),
    ("fuchsia", [255, 0, 255, 255]),
    ("green", [0, 128, 0, 255]),
    ("lime", [0, 255, 0, 255]),
    ("olive", [128, 128, 0, 255]),
    ("yellow", [255, 255, 0, 255]),
    ("navy", [0, 0, 128, 255]),
    ("blue", [0, 0, 255, 255]),
    ("teal", [0, 128, 128, 255]),
    ("aqua", [0, 255, 255, 255]),
    ("transparent", [0, 0, 0, 0]),
];

impl std::str::FromStr for Colour {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let lower = text.to_ascii_lowercase();
        if let Some((_, colour)) = COLOUR_NAMES.iter().find(|(name, _)| *name == lower) {
            return Ok(Colour(*colour));
        }
        let wrong = || {
            Error::usage(format!(
                "'{text}' is not a colour: write #rgb, #rrggbb, #rrggbbaa or a name such as white"
            ))
        };
        let hex = lower.strip_prefix('#').ok_or_else(wrong)?;
        let digits: Option<Vec<u8>> =
            hex.chars().map(|c| c.to_digit(16).map(|d| d as u8)).collect();
        match digits.ok_or_else(wrong)?[..] {
            [r, g, b] => Ok(Colour([r * 17, g * 17, b * 17, 255])),
            [r, s, g, h, b, c] => Ok(Colour([r * 16 + s, g * 16 + h, b * 16 + c, 255])),
            [r, s, g, h, b, c, a, d] => {
                Ok(Colour([r * 16 + s, g * 16 + h, b * 16 + c, a * 16 + d]))
            }
            _ => Err(wrong()),
        }
    }
}

impl TryFrom<String> for Colour {
    type Error = Error;
    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<Colour> for String {
    fn from(colour: Colour) -> String {
        colour.to_string()
    }
}

impl std::fmt::Display for Colour {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b, a] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")?;
        if a == 255 { Ok(()) } else { write!(f, "{a:02x}") }
    }
}

/// Density above which a cell of the grid counts as high, medium or low (paper, Algorithm 1):
/// candidates per pixel of the cell, 0..1, falling.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// Above it a cell keeps `max_points`.
    pub high: f64,
    /// Above it a cell keeps half of them.
    pub medium: f64,
    /// Above it a cell keeps a quarter of them.
    pub low: f64,
}

impl std::str::FromStr for Thresholds {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let parts: std::result::Result<Vec<f64>, _> =
            text.split(',').map(|part| part.trim().parse()).collect();
        match parts.as_deref() {
            Ok(&[high, medium, low]) => Ok(Self { high, medium, low }),
            _ => Err(Error::usage(format!(
                "'{text}' are not three thresholds: write high,medium,low, for instance 0.1,0.05,0.02"
            ))),
        }
    }
}

impl Default for Thresholds {
    fn default() -> Self {
        Self { high: 0.2, medium: 0.1, low: 0.02 }
    }
}

/// Which cells count as high and medium (paper, Algorithm 3): percentiles of the cells' mean value,
/// 0..100. Cells above `high` are high, those below `medium` low, the rest medium.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellPercentiles {
    /// Percentile above which a cell is high.
    pub high: f64,
    /// Percentile below which a cell is low.
    pub medium: f64,
}

impl Default for CellPercentiles {
    fn default() -> Self {
        // Paper, section 3 (HSLP).
        Self { high: 75.0, medium: 25.0 }
    }
}

impl std::str::FromStr for CellPercentiles {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let parts: std::result::Result<Vec<f64>, _> =
            text.split(',').map(|part| part.trim().parse()).collect();
        match parts.as_deref() {
            Ok(&[high, medium]) => Ok(Self { high, medium }),
            _ => Err(Error::usage(format!(
                "'{text}' are not two percentiles: write high,medium, for instance 75,25"
            ))),
        }
    }
}

/// How to render: everything that decides the bytes of the output, but the input itself.
///
/// ```
/// use polyreel::options::{Options, Points};
/// let options = Options { points: Points::Count(500), seed: 7, ..Options::default() };
/// options.validate().expect("these are sound");
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Options {
    /// Levels one and two. Default [`Method::Hrlp`].
    pub method: Method,
    /// Target seeds for a frame. Default 0.8 % of the pixels (paper, Table 2).
    pub points: Points,
    /// Decides all chance. Default 0.
    pub seed: u64,
    /// How much of the mesh lives on from frame to frame, 0 (each frame alone) to 1 (the first frame's
    /// mesh is locked). Default 0.5.
    pub coherence: f64,
    /// How much work goes into refinement. Default [`Quality::Normal`].
    pub quality: Quality,
    /// Steps of refinement instead of [`Options::quality`], 0..=1000: so many for a still or a frame
    /// alone, and so many for each frame of a stream, the first of a shot getting a few more. Default
    /// `None`.
    pub refine: Option<u32>,
    /// Likeness at which the refinement of a fresh mesh stops, in place of a number of steps; it goes
    /// as far as [`Quality::Best`] where the target is out of reach. The frames that follow it in a
    /// shot are refined as [`Options::quality`] says. Default `None`.
    pub error: Option<Target>,
    /// How much well-shaped triangles count against the error, 0 (not at all) to 1 (nothing else).
    /// Default 0.5.
    pub regularity: f64,
    /// How often the frame is smoothed (3x3 binomial) before its colours are clustered, 0..=8, so that
    /// grain draws no regions; the paper does not. Default 2.
    pub smoothing: u32,
    /// Colour clusters of level one, 2..=64. Default 8.
    pub clusters: u32,
    /// Every how many pixels of a region's boundary one becomes a candidate, 1..=64. Default 3 (see `docs/calibration.md`).
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
    /// Densities that tell dense cells from sparse ones.
    pub thresholds: Thresholds,
    /// Where feature points come from; `None` takes the method's own. Default `None`.
    pub features: Option<FrontEnd>,
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
    /// Colour of lines drawn along the edges of the mesh; `None` draws none. Default `None`.
    pub outline: Option<Colour>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            method: Method::default(),
            points: Points::default(),
            seed: 0,
            coherence: 0.5,
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
            candidates: 0.054,
            min_points: 1,
            percentiles: CellPercentiles::default(),
            entropy_radius: 5,
            diffusion_iterations: 10,
            diffusion_kappa: 50.0,
            diffusion_gamma: 0.25,
            outline: None,
        }
    }
}

impl Options {
    /// The paper to the letter: no smoothing, no refinement, no coherence.
    pub fn paper() -> Self {
        Self {
            smoothing: 0,
            interval: 5,
            quality: Quality::Draft,
            coherence: 0.0,
            ..Self::default()
        }
    }

    /// The preset called `name`.
    ///
    /// # Errors
    /// When there is none of that name; the message lists those that there are.
    pub fn preset(name: &str) -> Result<Self> {
        match name {
            "paper" => Ok(Self::paper()),
            _ => Err(Error::usage(format!("there is no preset '{name}': there is 'paper'"))),
        }
    }

    /// Checks every field against its range.
    ///
    /// # Errors
    /// Names the first field out of range, its value and the range.
    pub fn validate(&self) -> Result<()> {
        match self.points {
            Points::Count(0) => return Err(out_of_range("points", 0, "at least 1")),
            Points::Auto if self.error.is_none() => {
                return Err(Error::usage("points can only be auto beside an error to reach"));
            }
            Points::Auto if self.hex_density.is_some() => {
                return Err(Error::usage("points cannot be auto where hex-density is given"));
            }
            Points::Share(s) if !(s > 0.0 && s <= 1.0) => {
                return Err(out_of_range("points", self.points, "above 0% and at most 100%"));
            }
            _ => {}
        }
        check_range("smoothing", self.smoothing, 0, 8)?;
        check_range("clusters", self.clusters, 2, 64)?;
        check_range("interval", self.interval, 1, 64)?;
        for (name, value) in [
            ("coherence", self.coherence),
            ("regularity", self.regularity),
            ("interior", self.interior),
        ] {
            if !(0.0..=1.0).contains(&value) {
                return Err(out_of_range(name, value, "0 to 1"));
            }
        }
        check_range("refine", self.refine.unwrap_or(0), 0, 1000)?;
        if let Some(target) = self.error.filter(|target| !target.is_sound()) {
            return Err(out_of_range(
                "error",
                target,
                "psnr:1 to psnr:100, or ssim:0.01 to ssim:0.9999",
            ));
        }
        check_range("max-points", self.max_points, 1, 64)?;
        check_range("default-points", self.default_points, 0, self.max_points)?;
        if let Some(density) = self.hex_density
            && !(density > 0.0 && density <= 1.0)
        {
            return Err(out_of_range("hex-density", density, "above 0 and at most 1"));
        }
        let Thresholds { high, medium, low } = self.thresholds;
        if !(1.0 >= high && high >= medium && medium >= low && low >= 0.0) {
            return Err(out_of_range(
                "thresholds",
                format!("{high},{medium},{low}"),
                "high,medium,low, falling, between 0 and 1",
            ));
        }
        self.validate_maps()
    }

    /// The fields of the methods that score every pixel.
    fn validate_maps(&self) -> Result<()> {
        if !(self.candidates > 0.0 && self.candidates <= 1.0) {
            return Err(out_of_range("candidates", self.candidates, "above 0 and at most 1"));
        }
        check_range("min-points", self.min_points, 0, 64)?;
        let CellPercentiles { high, medium } = self.percentiles;
        if !(100.0 >= high && high >= medium && medium >= 0.0) {
            return Err(out_of_range(
                "percentiles",
                format!("{high},{medium}"),
                "high,medium, falling, between 0 and 100",
            ));
        }
        check_range("entropy-radius", self.entropy_radius, 1, 32)?;
        check_range("diffusion-iterations", self.diffusion_iterations, 0, 1000)?;
        let (kappa, gamma) = (self.diffusion_kappa, self.diffusion_gamma);
        if !(kappa > 0.0 && kappa <= 1000.0) {
            return Err(out_of_range("diffusion-kappa", kappa, "above 0 and at most 1000"));
        }
        if !(gamma > 0.0 && gamma <= 0.25) {
            return Err(out_of_range("diffusion-gamma", gamma, "above 0 and at most 0.25"));
        }
        Ok(())
    }
}

fn check_range(name: &str, value: u32, least: u32, most: u32) -> Result<()> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(out_of_range(name, value, format!("{least} to {most}")))
}

fn out_of_range(name: &str, value: impl std::fmt::Display, range: impl std::fmt::Display) -> Error {
    Error::usage(format!("{name} is {value}; it can be {range}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_counts_or_shares() {
        assert_eq!("2000".parse::<Points>().expect("a count"), Points::Count(2000));
        assert_eq!("0.8%".parse::<Points>().expect("a share"), Points::Share(0.008));
        assert_eq!(Points::Share(0.008).to_string(), "0.8%");
        assert!("0.8".parse::<Points>().is_err());
        assert!("many".parse::<Points>().is_err());
        assert_eq!(Points::Share(0.008).target(Size::new(1024, 1024)), 8388);
        assert_eq!(Points::Count(9).target(Size::new(2, 2)), 4);
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
        assert!(said(Options { points: Points::Auto, ..base() }).contains("auto"));
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
        let percentiles = CellPercentiles { high: 20.0, medium: 30.0 };
        assert!(said(Options { percentiles, ..base() }).contains("percentiles"));
        let thresholds = Thresholds { high: 0.1, medium: 0.2, low: 0.0 };
        assert!(said(Options { thresholds, ..base() }).contains("thresholds"));
    }

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
