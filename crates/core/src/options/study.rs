//! Studies: earlier systems as the paper's Table 1 lists them, each as options.

use super::{
    FillMode, Focus, FrontEnd, Method, Options, Points, Prefilter, Preset, Quality, Target,
};
use crate::error::Result;

/// The studies, in the order of the paper's Table 1, and the paper's own methods after them. What their publications
/// leave open, and what was chosen, is in `docs/studies.md`.
pub const STUDIES: [Preset; 14] = [
    Preset::new(
        "gai-2015",
        "edges simplified, points between them closer where it is salient, median colours",
        gai_2015,
    ),
    Preset::new("zhang-2016", "Sobel's edges, colours at the centres of mass", zhang_2016),
    Preset::new("qian-2016", "a blur and the Laplacian, colours at the centroids", qian_2016),
    Preset::new(
        "uasmith-2017",
        "a bilateral filter, contours of k-means regions, simplified",
        uasmith_2017,
    ),
    Preset::new("ma-2017", "corners of superpixels, thinned by saliency; more contrast", ma_2017),
    Preset::new("ng-2017", "Canny's edges and salient points, more on faces", ng_2017),
    Preset::new(
        "lawonn-2018",
        "seeds by saliency, moved and added until the error is met",
        lawonn_2018,
    ),
    Preset::new(
        "pic2polyart-2021",
        "edges and salient points, as many from each band of saliency, more on faces",
        pic2polyart_2021,
    ),
    Preset::new("laske-2024", "sharpened, Sobel's edges, colours at the centroids", laske_2024),
    Preset::new(
        "joseph-entropy-2024",
        "diffusion, entropy, its maxima suppressed by Gaussians",
        joseph_entropy_2024,
    ),
    Preset::new(
        "joseph-region-2024",
        "boundaries of k-means regions, thinned at random",
        joseph_region_2024,
    ),
    Preset::new("hrlp", "the paper: k-means regions on the hexagonal grid", Options::paper),
    Preset::new("help", "the paper: diffusion and entropy on the hexagonal grid", help),
    Preset::new("hslp", "the paper: saliency on the hexagonal grid", hslp),
];

/// The paper's settings, at its number of points, with another `method`.
fn by(method: Method) -> Options {
    Options { method, ..Options::paper() }
}

/// Faces, where the engine is built with their detector; what is salient otherwise.
const FACES: Focus = if cfg!(feature = "faces") { Focus::Faces } else { Focus::Saliency };

fn gai_2015() -> Options {
    Options { fill: FillMode::Median, focus: Some(Focus::Saliency), ..by(Method::Stippling) }
}

fn zhang_2016() -> Options {
    Options {
        features: Some(FrontEnd::Sobel),
        scatter: 0.05,
        fill: FillMode::Centroid,
        // Its seeds survive from frame to frame.
        coherence: Options::default().coherence,
        ..by(Method::Rlp)
    }
}

fn qian_2016() -> Options {
    Options {
        prefilter: Some(Prefilter::Blur),
        features: Some(FrontEnd::Laplacian),
        fill: FillMode::Centroid,
        ..by(Method::Rlp)
    }
}

fn uasmith_2017() -> Options {
    Options { prefilter: Some(Prefilter::Bilateral), ..by(Method::Ranked) }
}

fn ma_2017() -> Options {
    Options { focus: Some(Focus::Saliency), contrast: 1.2, ..by(Method::Thinning) }
}

fn ng_2017() -> Options {
    Options { features: Some(FrontEnd::SalientEdges), focus: Some(FACES), ..by(Method::Rlp) }
}

fn lawonn_2018() -> Options {
    Options {
        features: Some(FrontEnd::Saliency),
        points: Points::Auto,
        error: Some(Target::Psnr(20.0)),
        quality: Quality::Normal,
        ..by(Method::Rlp)
    }
}

fn pic2polyart_2021() -> Options {
    Options { focus: Some(FACES), ..by(Method::Pic2polyart) }
}

fn laske_2024() -> Options {
    Options {
        prefilter: Some(Prefilter::Sharpen),
        features: Some(FrontEnd::Sobel),
        fill: FillMode::Centroid,
        ..by(Method::Rlp)
    }
}

fn joseph_entropy_2024() -> Options {
    by(Method::Entropy)
}

fn joseph_region_2024() -> Options {
    by(Method::Rlp)
}

fn help() -> Options {
    by(Method::Help)
}

fn hslp() -> Options {
    by(Method::Hslp)
}

impl Options {
    /// The study called `name`.
    ///
    /// # Errors
    /// When there is no study of this name; the message lists those that there are.
    pub fn study(name: &str) -> Result<Self> {
        Preset::find(&STUDIES, name, "study", "")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn studies_are_sound_and_distinct() {
        crate::options::preset::tests::are_sound_and_distinct(&STUDIES, Options::study);
        let said = Options::study("gai").expect_err("none").to_string();
        assert!(said.contains("gai-2015") && said.contains("hslp"), "{said}");
    }

    #[test]
    fn the_papers_own_methods_are_its_preset() {
        for (name, method) in
            [("hrlp", Method::Hrlp), ("help", Method::Help), ("hslp", Method::Hslp)]
        {
            let paper = Options { method, ..Options::paper() };
            assert_eq!(Options::study(name).expect(name), paper);
        }
    }
}
