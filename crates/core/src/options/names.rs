//! Options that are chosen by name: method, front end, quality, edges, fill.

/// Declares an enum of named values, with the list of all values and the name of each.
macro_rules! named {
    (
        $(#[$about:meta])*
        pub enum $type:ident { $( $(#[$doc:meta])* $variant:ident = $name:literal, )* }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[non_exhaustive]
        pub enum $type {
            $(
                $(#[$doc])*
                #[cfg_attr(feature = "serde", serde(rename = $name))]
                $variant,
            )*
        }

        impl $type {
            /// All values, in the order of lists and of help texts.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// The name on the command line and in presets.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

named! {
    /// Levels one and two of the paper, by its names: the methods of its section 3, and the last three, which
    /// section 4 compares them with.
    #[derive(Default)]
    pub enum Method {
        /// K-means colour regions, thinned by density on the hexagonal grid (HRLP; Algorithm 1).
        #[default]
        Hrlp = "hrlp",
        /// Anisotropic diffusion, then local entropy; cells share by their mean entropy (HELP; Algorithm 3).
        Help = "help",
        /// Spectral-residual saliency; cells share by their mean saliency (HSLP; Algorithm 3).
        Hslp = "hslp",
        /// The colour regions of HRLP, thinned at random, without a grid (baseline RLP).
        Rlp = "rlp",
        /// The entropy of HELP, its maximum taken again and again, each time suppressed by a Gaussian (baseline
        /// ENTROPY).
        Entropy = "entropy",
        /// Canny's edges and salient points, a quarter of the seeds for each band of saliency (baseline
        /// Pic2PolyArt).
        Pic2polyart = "pic2polyart",
        /// The feature points with the highest scores; of contours and drawn edges those that matter most to their
        /// shape.
        Ranked = "ranked",
        /// Adaptive thinning: of many feature points the one goes, again and again, without which the error rises
        /// least.
        Thinning = "thinning",
        /// Weighted Voronoi stippling: half of the seeds are the feature points with the highest scores, and the others
        /// settle evenly between them, closer where [`super::Options::focus`] says.
        Stippling = "stippling",
    }
}

impl Method {
    /// The methods of the paper, those that it compares among them.
    pub const PAPER: [Self; 6] =
        [Self::Hrlp, Self::Help, Self::Hslp, Self::Rlp, Self::Entropy, Self::Pic2polyart];

    /// The front end that belongs to the method. [`Method::Pic2polyart`] adds salient points to its own.
    pub const fn own_features(self) -> FrontEnd {
        match self {
            Method::Hrlp | Method::Rlp => FrontEnd::Regions,
            Method::Help | Method::Entropy => FrontEnd::Entropy,
            Method::Hslp => FrontEnd::Saliency,
            Method::Pic2polyart => FrontEnd::Canny,
            Method::Ranked => FrontEnd::Contours,
            Method::Thinning => FrontEnd::Slic,
            Method::Stippling => FrontEnd::EdgeDrawing,
        }
    }
}

named! {
    /// Ways to find feature points: those of the paper's methods, and those of the related work that it names in
    /// section 2. Any of them can stand before any method's level two.
    pub enum FrontEnd {
        /// Sobel's gradient.
        Sobel = "sobel",
        /// The Laplacian.
        Laplacian = "laplacian",
        /// Canny's edges.
        Canny = "canny",
        /// Corners of SLIC superpixels.
        Slic = "slic",
        /// Boundaries of k-means colour regions.
        Regions = "regions",
        /// Entropy after anisotropic diffusion.
        Entropy = "entropy",
        /// Spectral-residual saliency.
        Saliency = "saliency",
        /// Edges that Edge Drawing finds, simplified.
        EdgeDrawing = "edge-drawing",
        /// Contours of k-means colour regions, simplified (Ramer-Douglas-Peucker).
        Contours = "contours",
        /// Canny's edges and salient points, scored by saliency.
        SalientEdges = "salient-edges",
    }
}

named! {
    /// What a frame goes through before features are looked for.
    pub enum Prefilter {
        /// A blur along the rows and one along the columns, each over five pixels.
        Blur = "blur",
        /// The difference from the neighbours is added.
        Sharpen = "sharpen",
        /// The bilateral filter: smooth areas, sharp edges.
        Bilateral = "bilateral",
    }
}

named! {
    /// How much work goes into refinement, where [`super::Options::refine`] gives no number of steps. In rising
    /// order after the first.
    #[derive(Default)]
    pub enum Quality {
        /// The best of a still, normal of frames of a stream.
        #[default]
        Auto = "auto",
        /// No refinement.
        Draft = "draft",
        /// Most of the gain for a third of the time.
        Normal = "normal",
        /// Until nothing is left to gain.
        Best = "best",
    }
}

named! {
    /// How two triangles meet.
    #[derive(Default)]
    pub enum Edges {
        /// A step of colour is spread over two pixels, as antialiasing does: less error, and less flicker where
        /// edges move.
        #[default]
        Smooth = "smooth",
        /// Each pixel has the colour of its one triangle.
        Hard = "hard",
    }
}

named! {
    /// What a triangle is filled with.
    #[derive(Default)]
    pub enum FillMode {
        /// The mean colour of its pixels.
        #[default]
        Mean = "mean",
        /// The median of its pixels, channel by channel: the colour of the larger side where a contour runs through
        /// it.
        Median = "median",
        /// The colour of the pixel at its centroid.
        Centroid = "centroid",
        /// The plane of colour that is nearest to its pixels (least squares). The mesh is refined for it.
        Linear = "linear",
        /// Colours at the vertices, the nearest to the pixels (least squares), mixed in between: no steps at edges.
        Gouraud = "gouraud",
        /// Nothing: lines on transparency.
        None = "none",
    }
}

named! {
    /// What is filled and outlined together.
    #[derive(Default)]
    pub enum Shape {
        /// Each triangle.
        #[default]
        Triangles = "triangles",
        /// Neighbours of like colour, as closed panes.
        Polygons = "polygons",
        /// The cells of the Voronoi diagram of the triangles' centres.
        Voronoi = "voronoi",
    }
}

impl FillMode {
    /// Whether a triangle has more than one colour.
    pub const fn is_gradient(self) -> bool {
        matches!(self, FillMode::Linear | FillMode::Gouraud)
    }
}
