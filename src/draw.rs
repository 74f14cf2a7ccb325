//! Lines on pictures.

use crate::frame::Rgba;
use crate::geom::{Point, Size};
use crate::mesh::Mesh;

/// Calls `visit(x, y)` for the pixels of the line from the pixel of `a` to that of `b`, both included:
/// Bresenham's, walked from the smaller end, so that a line and its reverse are the same pixels.
pub fn line(size: Size, a: Point, b: Point, mut visit: impl FnMut(u32, u32)) {
    let (a, b) = (a.min(b), a.max(b));
    let ((ax, ay), (bx, by)) = (a.pixel(size), b.pixel(size));
    let (mut x, mut y) = (i64::from(ax), i64::from(ay));
    let (bx, by) = (i64::from(bx), i64::from(by));
    let (dx, dy) = ((bx - x).abs(), -(by - y).abs());
    let (sx, sy) = ((bx - x).signum(), (by - y).signum());
    let mut error = dx + dy;
    loop {
        visit(x as u32, y as u32);
        if x == bx && y == by {
            return;
        }
        let doubled = 2 * error;
        if doubled >= dy {
            error += dy;
            x += sx;
        }
        if doubled <= dx {
            error += dx;
            y += sy;
        }
    }
}

/// Draws every edge of `mesh` on `pixels`, which are of the mesh's size, in `colour`. Returns the
/// number of pixels drawn, those drawn twice counted twice.
pub fn edges(pixels: &mut [Rgba], mesh: &Mesh, colour: Rgba) -> u32 {
    let width = mesh.size.width as usize;
    let mut drawn = 0;
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            // The neighbour has the same edge the other way round; those on the border stand alone.
            let (p, q) = (mesh.vertices[from as usize], mesh.vertices[to as usize]);
            if from < to || mesh.on_one_border(from, to) {
                line(mesh.size, p, q, |x, y| {
                    pixels[y as usize * width + x as usize] = colour;
                    drawn += 1;
                });
            }
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_connected_and_the_same_both_ways() {
        let size = Size::new(40, 40);
        for (to_x, to_y) in [(39, 3), (3, 39), (0, 20), (20, 0), (39, 39), (0, 39)] {
            let (a, b) = (Point::pixel_centre(12, 9), Point::pixel_centre(to_x, to_y));
            let (mut there, mut back) = (Vec::new(), Vec::new());
            line(size, a, b, |x, y| there.push((x, y)));
            line(size, b, a, |x, y| back.push((x, y)));
            assert_eq!(there, back);
            assert!(there.contains(&(12, 9)) && there.contains(&(to_x, to_y)));
            let near =
                |p: &[(u32, u32)]| p[0].0.abs_diff(p[1].0) <= 1 && p[0].1.abs_diff(p[1].1) <= 1;
            assert!(there.windows(2).all(near));
        }
    }
}
