//! Contours: the boundaries between regions as chains of points, from one meeting of three regions to the next.
//!
//! They run between pixels, so that two neighbours have the boundary between them in common, and it stays in common
//! when it is [simplified](super::simplify).

use super::mask::Mask;
use crate::geom::Size;
use crate::plane::Plane;

/// A boundary between two regions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contour {
    /// Its points: `(x, y)` is the upper left corner of the pixel `(x, y)`. A closed contour begins and ends with the
    /// same point.
    pub points: Vec<(u32, u32)>,
}

impl Contour {
    /// Whether it has no ends.
    pub fn is_closed(&self) -> bool {
        self.points.len() > 2 && self.points.first() == self.points.last()
    }
}

/// The contours between regions of `labels`; the frame's border is none.
pub fn contours<T: Copy + PartialEq>(labels: &Plane<T>) -> Vec<Contour> {
    let size = labels.size();
    if size.pixels() == 0 {
        return Vec::new();
    }
    let mut steps = Steps::new(labels);
    let mut found = Vec::new();
    let corners = || (0..=size.height).flat_map(move |y| (0..=size.width).map(move |x| (x, y)));
    for at in corners().filter(|&at| steps.is_node(at)).collect::<Vec<_>>() {
        while let Some(contour) = steps.follow(at) {
            found.push(contour);
        }
    }
    // What is left are closed contours without a node.
    for at in corners() {
        while let Some(contour) = steps.follow(at) {
            found.push(contour);
        }
    }
    found
}

/// The sides of pixels where labels differ and no contour has passed yet.
struct Steps {
    size: Size,
    /// From `(x, y)` to the right.
    across: Mask,
    /// From `(x, y)` downwards.
    down: Mask,
    nodes: Mask,
}

impl Steps {
    fn new<T: Copy + PartialEq>(labels: &Plane<T>) -> Self {
        let size = labels.size();
        let corners = Size::new(size.width + 1, size.height + 1);
        let empty = || Mask::new(corners);
        let mut steps = Self { size, across: empty(), down: empty(), nodes: empty() };
        for y in 0..size.height {
            for x in 0..size.width {
                let label = labels.at(x, y);
                if y > 0 && labels.at(x, y - 1) != label {
                    steps.across.insert(x, y);
                }
                if x > 0 && labels.at(x - 1, y) != label {
                    steps.down.insert(x, y);
                }
            }
        }
        for y in 0..=size.height {
            for x in 0..=size.width {
                if !matches!(steps.around((x, y)).len(), 0 | 2) {
                    steps.nodes.insert(x, y);
                }
            }
        }
        steps
    }

    /// Whether contours begin and end at a corner: more or less than two sides meet there.
    fn is_node(&self, (x, y): (u32, u32)) -> bool {
        self.nodes.contains(x, y)
    }

    /// The corners that open sides lead to.
    fn around(&self, (x, y): (u32, u32)) -> Vec<(u32, u32)> {
        let Size { width, height } = self.size;
        let ways = [
            (x < width && self.across.contains(x, y)).then(|| (x + 1, y)),
            (y < height && self.down.contains(x, y)).then(|| (x, y + 1)),
            (x > 0 && self.across.contains(x - 1, y)).then(|| (x - 1, y)),
            (y > 0 && self.down.contains(x, y - 1)).then(|| (x, y - 1)),
        ];
        ways.into_iter().flatten().collect()
    }

    fn close(&mut self, from: (u32, u32), to: (u32, u32)) {
        let (x, y) = (from.0.min(to.0), from.1.min(to.1));
        let sides = if from.1 == to.1 { &mut self.across } else { &mut self.down };
        sides.remove(x, y);
    }

    /// The contour from `from` to the next node, or round to `from`. None if no side is open there.
    fn follow(&mut self, from: (u32, u32)) -> Option<Contour> {
        let mut points = vec![from];
        let mut at = from;
        while let Some(&next) = self.around(at).first() {
            self.close(at, next);
            points.push(next);
            at = next;
            if at == from || self.is_node(at) {
                break;
            }
        }
        (points.len() > 1).then_some(Contour { points })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(rows: &[&str]) -> Plane<u8> {
        let size = Size::new(rows[0].len() as u32, rows.len() as u32);
        Plane::new(size, rows.concat().into_bytes()).expect("rows of one length")
    }

    #[test]
    fn an_island_has_one_closed_contour() {
        let found = contours(&labels(&[".....", ".aa..", ".aa..", "....."]));
        assert_eq!(found.len(), 1);
        assert!(found[0].is_closed());
        assert_eq!(found[0].points.len(), 9);
        assert_eq!(found[0].points[0], (1, 1));
    }

    #[test]
    fn contours_end_where_three_regions_meet_and_at_the_border() {
        let found = contours(&labels(&["aabb", "aabb", "cccc"]));
        let mut ends: Vec<_> = found
            .iter()
            .map(|c| (c.points[0], c.points[c.points.len() - 1], c.points.len()))
            .collect();
        ends.sort_unstable();
        assert_eq!(ends, [((0, 2), (2, 2), 3), ((2, 0), (2, 2), 3), ((2, 2), (4, 2), 3)]);
    }

    #[test]
    fn every_side_is_passed_once() {
        let plane = labels(&["abab", "baba", "aabb", "cabc"]);
        let sides: usize = contours(&plane).iter().map(|c| c.points.len() - 1).sum();
        let mut expected = 0;
        for y in 0..4 {
            for x in 0..4 {
                expected += usize::from(x > 0 && plane.at(x, y) != plane.at(x - 1, y));
                expected += usize::from(y > 0 && plane.at(x, y) != plane.at(x, y - 1));
            }
        }
        assert_eq!(sides, expected);
    }

    #[test]
    fn one_region_has_none() {
        assert!(contours(&Plane::filled(Size::new(7, 5), 3)).is_empty());
        assert!(contours(&Plane::filled(Size::new(1, 1), 3)).is_empty());
    }
}
