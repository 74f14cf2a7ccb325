//! Thresholds that divide the cells of the grid into classes, by density and by value.

use crate::error::{Error, Result};

/// Density above which a cell of the grid counts as high, medium or low (paper, Algorithm 1):
/// candidates per pixel of the cell, 0..1, falling.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
            _ => Err(Error::options(format!(
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
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
            _ => Err(Error::options(format!(
                "'{text}' are not two percentiles: write high,medium, for instance 75,25"
            ))),
        }
    }
}
