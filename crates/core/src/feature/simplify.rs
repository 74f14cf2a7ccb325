//! Which points of a chain matter: Ramer-Douglas-Peucker (Ramer, "An iterative procedure for the polygonal
//! approximation of plane curves", 1972; Douglas and Peucker, "Algorithms for the reduction of the number of points
//! required to represent a digitized line or its caricature", 1973).
//!
//! The method splits a chain at the point that is farthest from the straight line between its ends, and its parts
//! again, as long as that point is farther than a tolerance. Here each point gets the largest tolerance at which it is
//! kept: the points above any tolerance are those of the method, and a number of points can be asked for in place of a
//! tolerance, over many chains at once.

/// How chains are split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simplify {
    /// The length of a straight piece counts as this share of it as distance, 0..1: long pieces are split, too, at their
    /// middle. 0 is Ramer-Douglas-Peucker.
    pub straight_share: f32,
}

impl Simplify {
    /// Ramer-Douglas-Peucker.
    pub const PLAIN: Self = Self { straight_share: 0.0 };

    /// For each of `points` the tolerance in pixels up to which it is kept; points that lie on straight lines have 0.
    /// Ends, and two points of a closed chain, which begins and ends with the same one, have half the chain's extent: a
    /// speck vanishes before an outline does.
    pub fn significance(&self, points: &[(u32, u32)]) -> Vec<f32> {
        let mut found = vec![0.0; points.len()];
        let Some(last) = points.len().checked_sub(1) else { return found };
        let extent = extent(points) / 2.0;
        (found[0], found[last]) = (extent, extent);
        if last > 1 && points[0] == points[last] {
            // A point counts once.
            found[last] = 0.0;
            let far = (1..last).max_by_key(|&i| squared(points[0], points[i]));
            if let Some(far) = far {
                found[far] = extent;
                self.split(points, (0, far), extent, &mut found);
                self.split(points, (far, last), extent, &mut found);
            }
        } else {
            self.split(points, (0, last), extent, &mut found);
        }
        found
    }

    /// Finds the significance of the points between those of `piece`; none has more than `most`.
    fn split(&self, points: &[(u32, u32)], piece: (usize, usize), most: f32, found: &mut [f32]) {
        let mut open = vec![(piece.0, piece.1, most)];
        while let Some((first, last, most)) = open.pop() {
            if last - first < 2 {
                continue;
            }
            let (far, distance) = farthest(points, first, last);
            let chord = (squared(points[first], points[last]) as f32).sqrt();
            let (at, value) = match self.straight_share * chord {
                straight if straight > distance => ((first + last) / 2, straight),
                _ => (far, distance),
            };
            if value <= 0.0 {
                continue;
            }
            // No point outlives the one whose split has made its piece.
            let value = value.min(most);
            found[at] = value;
            open.push((first, at, value));
            open.push((at, last, value));
        }
    }
}

/// The point between two others that is farthest from the line through them, and its distance.
fn farthest(points: &[(u32, u32)], first: usize, last: usize) -> (usize, f32) {
    let (a, b) = (points[first], points[last]);
    let (dx, dy) = (difference(b.0, a.0), difference(b.1, a.1));
    let length = squared(a, b);
    let mut best = (first + 1, -1);
    for (i, &p) in points.iter().enumerate().take(last).skip(first + 1) {
        let (px, py) = (difference(p.0, a.0), difference(p.1, a.1));
        let along = px * dx + py * dy;
        // Beyond an end of the line, the distance is that from the end.
        let far = if along <= 0 {
            squared(p, a) * length.max(1)
        } else if along >= length {
            squared(p, b) * length
        } else {
            (px * dy - py * dx).pow(2)
        };
        if far > best.1 {
            best = (i, far);
        }
    }
    (best.0, (best.1 as f64 / length.max(1) as f64).sqrt() as f32)
}

fn difference(a: u32, b: u32) -> i64 {
    i64::from(a) - i64::from(b)
}

fn squared(a: (u32, u32), b: (u32, u32)) -> i64 {
    difference(a.0, b.0).pow(2) + difference(a.1, b.1).pow(2)
}

/// The diagonal of the rectangle around all `points`.
fn extent(points: &[(u32, u32)]) -> f32 {
    let range = |v: fn(&(u32, u32)) -> u32| {
        let (least, most) = (points.iter().map(v).min(), points.iter().map(v).max());
        difference(most.unwrap_or(0), least.unwrap_or(0)) as f32
    };
    range(|p| p.0).hypot(range(|p| p.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};

    /// The method as it is written, with a tolerance.
    fn by_tolerance(
        points: &[(u32, u32)],
        first: usize,
        last: usize,
        tolerance: f32,
    ) -> Vec<usize> {
        if last - first < 2 {
            return vec![first, last];
        }
        let (far, distance) = farthest(points, first, last);
        if distance <= tolerance {
            return vec![first, last];
        }
        let mut kept = by_tolerance(points, first, far, tolerance);
        kept.pop();
        kept.extend(by_tolerance(points, far, last, tolerance));
        kept
    }

    #[test]
    fn points_above_a_tolerance_are_those_of_the_method() {
        let mut at = (500u32, 500u32);
        let points: Vec<_> = (0..400)
            .map(|i| {
                let bits = rank(2, Purpose::Noise, i, 0);
                at = (at.0 + (bits % 3) as u32, at.1 + (bits / 3 % 3) as u32 - 1);
                at
            })
            .collect();
        let significance = Simplify::PLAIN.significance(&points);
        for tolerance in [0.5, 1.0, 2.0, 5.0, 12.0] {
            let kept: Vec<_> = (0..400).filter(|&i| significance[i] > tolerance).collect();
            assert_eq!(kept, by_tolerance(&points, 0, 399, tolerance), "{tolerance}");
        }
    }

    #[test]
    fn corners_of_a_square_matter_and_its_sides_do_not() {
        let side = |i: u32| match (i / 10, i % 10) {
            (0, d) => (d, 0),
            (1, d) => (10, d),
            (2, d) => (10 - d, 10),
            (_, d) => (0, 10 - d),
        };
        let mut points: Vec<_> = (0..40).map(side).collect();
        points.push(points[0]);
        let significance = Simplify::PLAIN.significance(&points);
        let kept: Vec<_> = (0..=40).filter(|&i| significance[i] > 0.0).collect();
        assert_eq!(kept, [0, 10, 20, 30]);
        let even = Simplify { straight_share: 0.1 }.significance(&points);
        assert!((0..40).filter(|&i| even[i] > 0.4).count() >= 8, "sides are split: {even:?}");
    }

    #[test]
    fn the_shortest_chains_have_their_ends() {
        assert!(Simplify::PLAIN.significance(&[]).is_empty());
        assert_eq!(Simplify::PLAIN.significance(&[(3, 4)]), [0.0]);
        assert_eq!(Simplify::PLAIN.significance(&[(0, 0), (3, 4)]), [2.5, 2.5]);
        assert_eq!(Simplify::PLAIN.significance(&[(0, 0), (3, 4), (0, 0)]), [2.5, 2.5, 0.0]);
    }
}
