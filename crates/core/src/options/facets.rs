//! How small and how large facets may be.

use super::{Length, Options};
use crate::error::{Error, Result};
use crate::geom::{MAX_SIDE, Size};

/// The area of an equilateral triangle whose sides are 1.
const EQUILATERAL: f64 = 0.433_012_701_892_219_3;

/// Of the number of facets of one size that fit, the share that is aimed at where facets of several sizes must fit.
const ROOM: f64 = 0.5;

/// The sides of the smallest and of the largest facet, where they are limited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetSides {
    least: Option<Length>,
    most: Option<Length>,
}

impl FacetSides {
    /// Any.
    pub const FREE: Self = Self { least: None, most: None };

    /// Whether there is a limit.
    pub(crate) fn are_limited(self) -> bool {
        self.least.is_some() || self.most.is_some()
    }

    /// The least and the largest area of a facet of a picture of `size`, in pixels. 0 and infinity where there is no
    /// limit; the largest is at least twice the least, so that a picture can be covered.
    pub(crate) fn areas(self, size: Size) -> (f64, f64) {
        let area = |side: Length| {
            let side = side.of(size.width.min(size.height));
            EQUILATERAL * side * side
        };
        let least = self.least.map_or(0.0, area);
        (least, self.most.map_or(f64::INFINITY, area).max(2.0 * least))
    }
}

impl Options {
    /// The sides that facets may have.
    pub(crate) fn facet_sides(&self) -> FacetSides {
        FacetSides { least: self.min_facet, most: self.max_facet }
    }

    /// The number of seeds of a picture of `size`: what [`Options::points`] ask for, as far as facets have room for them,
    /// and as many more as small facets need.
    #[doc(hidden)]
    pub fn seeds(&self, size: Size) -> usize {
        let asked = self.points.target(size);
        let sides = self.facet_sides();
        if !sides.are_limited() {
            return asked;
        }
        let (least, most) = sides.areas(size);
        let pixels = size.pixels() as f64;
        // There are about two triangles for each seed.
        let seeds = |area: f64| pixels / area / 2.0;
        let (few, many) = (seeds(most) / ROOM, seeds(least.max(1.0)) * ROOM);
        (asked as f64).min(many).max(few).min(pixels) as usize
    }

    pub(super) fn check_facets(&self) -> Result<()> {
        let facets = [("min-facet", self.min_facet), ("max-facet", self.max_facet)];
        for (name, length) in facets {
            let is_sound = length.is_none_or(|length| match length {
                Length::Pixels(pixels) => (1.0..=f64::from(MAX_SIDE)).contains(&pixels),
                Length::Share(share) => share > 0.0 && share <= 1.0,
            });
            if let Some(length) = length.filter(|_| !is_sound) {
                return Err(Error::options(format!(
                    "{name} {length} is out of range: 1 to {MAX_SIDE} pixels, or more than 0 and at most 100% of the shorter side"
                )));
            }
        }
        let is_less = match (self.min_facet, self.max_facet) {
            (Some(Length::Pixels(least)), Some(Length::Pixels(most)))
            | (Some(Length::Share(least)), Some(Length::Share(most))) => 1.5 * least <= most,
            _ => true,
        };
        if is_less {
            return Ok(());
        }
        Err(Error::options(
            "max-facet has to be at least 1.5 times min-facet: facets of one size alone do not follow a picture",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Points;

    #[test]
    fn numbers_follow_from_sizes() {
        let size = Size::new(1000, 1000);
        let with = |points, least: Option<f64>, most: Option<f64>| Options {
            points: Points::Count(points),
            min_facet: least.map(Length::Pixels),
            max_facet: most.map(Length::Share),
            ..Options::default()
        };
        assert_eq!(with(1200, None, None).seeds(size), 1200);
        let few = with(20_000, Some(40.0), None).seeds(size);
        assert!((250..500).contains(&few), "{few}");
        let many = with(100, None, Some(0.03)).seeds(size);
        assert!((2300..3000).contains(&many), "{many}");
        assert_eq!(with(1200, Some(5.0), Some(0.2)).seeds(size), 1200);
    }

    #[test]
    fn sizes_out_of_range_or_order_are_refused() {
        let with = |least, most| Options {
            min_facet: Some(least),
            max_facet: Some(most),
            ..Options::default()
        };
        let (small, large) = (Length::Share(0.02), Length::Share(0.1));
        assert!(with(small, large).validate().is_ok());
        assert!(with(large, small).validate().is_err());
        assert!(with(Length::Pixels(0.0), large).validate().is_err());
        assert!(with(small, Length::Share(1.5)).validate().is_err());
    }
}
