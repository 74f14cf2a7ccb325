//! What is chosen by name: method, front end, quality, edges.

/// Level one and two of the chain, by the names of the paper (its section 3; the last three are the
/// methods that it compares itself with in section 4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "lowercase")
)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
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
    /// See `sample/bands.rs`.
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "lowercase")
)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub enum FrontEnd {
    /// Sobel's gradient.
    Sobel,
    /// The Laplacian.
    Laplacian,
    /// Canny's edges.
    Canny,
    /// Corners of SLIC superpixels.
    Slic,
    /// Boundaries of k-means colour regions.
    Regions,
    /// Entropy after anisotropic diffusion.
    Entropy,
    /// Spectral-residual saliency.
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

/// How much work goes into refinement, where [`super::Options::refine`] does not say it in steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "lowercase")
)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
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

/// How one triangle ends and the next begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "lowercase")
)]
#[cfg_attr(not(feature = "unstable"), non_exhaustive)]
pub enum Edges {
    /// A step of colour is spread over two pixels, as antialiasing does: less error, and less flicker where
    /// edges move.
    #[default]
    Smooth,
    /// Each pixel has the colour of its one triangle.
    Hard,
}

impl Edges {
    /// Both.
    pub const ALL: [Edges; 2] = [Edges::Smooth, Edges::Hard];

    /// The name on the command line and in presets.
    pub const fn name(self) -> &'static str {
        match self {
            Edges::Smooth => "smooth",
            Edges::Hard => "hard",
        }
    }
}
