//! Points on the frame's border, so that the mesh covers the frame with triangles of the usual size.

use crate::geom::{Point, SUBPIXEL, Size};

/// About `count` points, evenly spaced on the four sides without the corners. Distinct; at most one for each pixel.
pub fn border_points(size: Size, count: usize) -> Vec<Point> {
    let far = size.far();
    let perimeter = 2.0 * (f64::from(size.width) + f64::from(size.height));
    let on_side = |length: u32| {
        let share = count as f64 * f64::from(length) / perimeter;
        (share.floor() as u32).min(length.saturating_sub(1))
    };
    let along = |length: u32| {
        let n = i64::from(on_side(length));
        let far = i64::from(length) * i64::from(SUBPIXEL);
        (1..=n).map(move |i| (far * i / (n + 1)) as i32)
    };
    let level = along(size.width).flat_map(|x| [Point::new(x, 0), Point::new(x, far.y)]);
    let upright = along(size.height).flat_map(|y| [Point::new(0, y), Point::new(far.x, y)]);
    level.chain(upright).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, Place};

    #[test]
    fn points_lie_on_the_border_and_are_distinct() {
        for size in [Size::new(1, 1), Size::new(2, 1), Size::new(30, 17), Size::new(1000, 3)] {
            for count in [0, 1, 7, 100, 5000] {
                let mut points = border_points(size, count);
                assert!(points.len() <= count);
                assert!(points.iter().all(|&p| {
                    size.contains(p)
                        && !matches!(Place::of(p, size), Place::Interior | Place::Corner)
                }));
                assert!(points.iter().all(|p| !Mesh::corners(size).contains(p)));
                let all = points.len();
                points.sort_unstable();
                points.dedup();
                assert_eq!(points.len(), all, "{size} {count}");
            }
        }
    }
}
