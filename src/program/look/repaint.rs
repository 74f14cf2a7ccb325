//! The look of a mesh stream that is painted anew.

use polyreel::error::{Error, Result};
use polyreel::options::{FillMode, Options};

use super::LookArgs;
use super::load::preset;

impl LookArgs {
    /// The options of painting: those given, else those of `look`.
    ///
    /// # Errors
    /// When an option is given that needs a new mesh.
    pub(crate) fn repaint(&self, look: &Options) -> Result<Options> {
        if self.asks_for_a_mesh() {
            return Err(Error::usage(
                "a mesh stream is painted, not triangulated anew: of the looks only --edges, --outline, \
                 --outline-width, --outline-contrast, --outline-opacity, --outline-tint, --saturation, --wash, --contrast, --chroma, --duotone, --palette, \
                 --fill none and --preset have an effect on it",
            ));
        }
        let base = match &self.preset {
            Some(name) => preset(name)?,
            None => look.clone(),
        };
        let options = Options {
            edges: self.edges.unwrap_or(base.edges),
            outline: self.ink().or(base.outline).or(self.implied_outline()),
            outline_width: self.outline_width.unwrap_or(base.outline_width),
            outline_contrast: self.outline_contrast.unwrap_or(base.outline_contrast),
            outline_opacity: self.outline_opacity.unwrap_or(base.outline_opacity),
            outline_tint: self.tint().unwrap_or(base.outline_tint),
            saturation: self.saturation.unwrap_or(base.saturation),
            wash: self.wash.unwrap_or(base.wash),
            fill: self.repainted_fill(&base, look)?,
            contrast: self.contrast.unwrap_or(base.contrast),
            chroma: self.chroma.unwrap_or(base.chroma),
            duotone: self.duotone.or(base.duotone),
            palette: self.palette.clone().or_else(|| base.palette.clone()),
            ..look.clone()
        };
        options.validate()?;
        Ok(options)
    }

    /// The fill of a mesh stream that is painted anew: it has one colour a triangle.
    fn repainted_fill(&self, base: &Options, look: &Options) -> Result<FillMode> {
        match self.fill {
            Some(fill) if fill != look.fill && fill != FillMode::None => {
                Err(Error::usage(format!(
                    "a mesh stream has the colours that it was written with, here of --fill {}; it can be painted with \
                 them, or with --fill none",
                    look.fill.name()
                )))
            }
            Some(fill) => Ok(fill),
            None if base.fill == FillMode::None => Ok(FillMode::None),
            None => Ok(look.fill),
        }
    }

    /// Whether an option is given that decides the mesh.
    fn asks_for_a_mesh(&self) -> bool {
        let given = [
            self.study.is_some(),
            self.method.is_some(),
            self.points.is_some(),
            self.seed.is_some(),
            self.coherence.is_some(),
            self.quality.is_some(),
            self.refine.is_some(),
            self.error.is_some(),
            self.regularity.is_some(),
            self.min_facet.is_some(),
            self.max_facet.is_some(),
            self.shape.is_some(),
            self.focus.is_some(),
            self.smoothing.is_some(),
            self.clusters.is_some(),
            self.interval.is_some(),
            self.interior.is_some(),
            self.hex_density.is_some(),
            self.max_points.is_some(),
            self.default_points.is_some(),
            self.thresholds.is_some(),
            self.features.is_some(),
            self.prefilter.is_some(),
            self.scatter.is_some(),
            self.candidates.is_some(),
            self.min_points.is_some(),
            self.percentiles.is_some(),
            self.entropy_radius.is_some(),
            self.diffusion_iterations.is_some(),
            self.diffusion_kappa.is_some(),
            self.diffusion_gamma.is_some(),
        ];
        given.contains(&true)
    }
}
