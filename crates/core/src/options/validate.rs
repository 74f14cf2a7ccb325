//! The ranges of options.

use super::{CellPercentiles, FillMode, Length, Options, Points, Shape, Thresholds};
use crate::error::{Error, Result};

impl Options {
    /// Checks every field against its range.
    ///
    /// # Errors
    /// Names the first field out of range, its value and the range.
    pub fn validate(&self) -> Result<()> {
        match self.points {
            Points::Count(0) | Points::Scaled(0) => {
                return Err(out_of_range("points", 0, "at least 1"));
            }
            Points::Auto if self.hex_density.is_some() => {
                return Err(Error::options("points cannot be auto where hex-density is given"));
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
            ("scatter", self.scatter),
            ("wash", self.wash),
            ("outline-opacity", self.outline_opacity),
            ("outline-tint", self.outline_tint),
        ] {
            if !(0.0..=1.0).contains(&value) {
                return Err(out_of_range(name, value, "0 to 1"));
            }
        }
        for (name, value) in
            [("saturation", self.saturation), ("contrast", self.contrast), ("chroma", self.chroma)]
        {
            if !(0.0..=4.0).contains(&value) {
                return Err(out_of_range(name, value, "0 to 4"));
            }
        }
        if let Some(focus) = &self.focus {
            focus.validate()?;
        }
        if let Some(palette) = &self.palette {
            palette.validate()?;
        }
        if self.fill.is_gradient() && self.shape != Shape::Triangles {
            return Err(Error::options(format!(
                "fill {} is for triangles, and {} have one colour each: leave out shape, or take another fill",
                self.fill.name(),
                self.shape.name()
            )));
        }
        if self.fill == FillMode::None && self.error.is_some() {
            return Err(Error::options(
                "a picture without fill has no likeness: leave out error, or fill",
            ));
        }
        let is_wide = match self.outline_width {
            Length::Pixels(pixels) => pixels > 0.0 && pixels <= 256.0,
            Length::Share(share) => share > 0.0 && share <= 0.1,
        };
        if !is_wide {
            let range = "above 0 and at most 256 pixels, or 10% of the shorter side";
            return Err(out_of_range("outline-width", self.outline_width, range));
        }
        self.check_facets()?;
        check_range("outline-contrast", self.outline_contrast, 0, 255)?;
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

    /// Checks the fields of the methods that score every pixel.
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
        if !(TINIEST..=1000.0).contains(&kappa) {
            let range = format!("{TINIEST:e} to 1000");
            return Err(out_of_range("diffusion-kappa", format!("{kappa:e}"), range));
        }
        if !(TINIEST..=0.25).contains(&gamma) {
            let range = format!("{TINIEST:e} to 0.25");
            return Err(out_of_range("diffusion-gamma", format!("{gamma:e}"), range));
        }
        Ok(())
    }
}

/// The smallest value of options that must stay above 0 as 32-bit floats.
const TINIEST: f64 = 1e-30;

fn check_range(name: &str, value: u32, least: u32, most: u32) -> Result<()> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(out_of_range(name, value, format!("{least} to {most}")))
}

fn out_of_range(name: &str, value: impl std::fmt::Display, range: impl std::fmt::Display) -> Error {
    Error::out_of_range(name, value, range)
}
