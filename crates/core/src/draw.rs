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

/// Draws every edge of `mesh` on `pixels`, which are of the mesh's size, in `colour`, `width` pixels
/// wide. Returns the number of pixels drawn, those drawn twice counted twice.
pub fn edges(pixels: &mut [Rgba], mesh: &Mesh, colour: Rgba, width: u32) -> u32 {
    let brush = brush(width);
    let mut drawn = 0;
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            // The neighbour has the same edge reversed; border edges occur once.
            let (p, q) = (mesh.vertices[from as usize], mesh.vertices[to as usize]);
            if from < to || mesh.on_one_border(from, to) {
                drawn += stroke(pixels, mesh.size, (p, q), colour, &brush);
            }
        }
    }
    drawn
}

/// The sides of all triangles: the smaller end, the larger, and the triangle, sorted.
pub(crate) fn sides(mesh: &Mesh) -> Vec<(u32, u32, u32)> {
    let mut sides: Vec<(u32, u32, u32)> = (0u32..)
        .zip(&mesh.triangles)
        .flat_map(|(t, &[a, b, c])| [(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), p.max(q), t)))
        .collect();
    sides.sort_unstable();
    sides
}

/// The edges between two triangles, in order: the ends, the smaller first, and the triangles.
pub(crate) fn inner_edges(mesh: &Mesh) -> Vec<([u32; 2], [u32; 2])> {
    let sides = sides(mesh);
    let pairs = sides.windows(2).map(|pair| (pair[0], pair[1]));
    pairs
        .filter(|((a, b, _), (c, d, _))| (a, b) == (c, d))
        .map(|((a, b, t), (_, _, u))| ([a, b], [t, u]))
        .collect()
}

/// The rows of a disc, from the top: how far below the middle each is, its first and its last column.
type Brush = Vec<(i64, (i64, i64))>;

/// Draws the line between two points with `brush`; returns the pixels drawn, each as often as it was drawn.
fn stroke(
    pixels: &mut [Rgba],
    size: Size,
    (from, to): (Point, Point),
    colour: Rgba,
    brush: &Brush,
) -> u32 {
    let row = size.width as usize;
    let mut drawn = 0;
    line(size, from, to, |x, y| {
        for &(dy, (left, right)) in brush {
            let y = i64::from(y) + dy;
            let left = (i64::from(x) + left).max(0) as usize;
            let right = (i64::from(x) + right + 1).clamp(0, i64::from(size.width)) as usize;
            if (0..i64::from(size.height)).contains(&y) && left < right {
                pixels[y as usize * row..][left..right].fill(colour);
                drawn += (right - left) as u32;
            }
        }
    });
    drawn
}

/// A disc `width` pixels across, of one pixel at least. One of even width reaches one pixel further to
/// the right and down.
fn brush(width: u32) -> Brush {
    let width = i64::from(width.max(1));
    let first = -((width - 1) / 2);
    // Twice the distance from the disc's middle.
    let off = |d: i64| 2 * (d - first) + 1 - width;
    let inside = |dx: i64, dy: i64| off(dx).pow(2) + off(dy).pow(2) <= width * width;
    let row = |dy: i64| {
        let mut columns = (first..first + width).filter(|&dx| inside(dx, dy));
        let left = columns.next()?;
        Some((dy, (left, columns.next_back().unwrap_or(left))))
    };
    (first..first + width).filter_map(row).collect()
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

    #[test]
    fn wide_lines_are_as_wide_as_asked_and_stay_in_the_frame() {
        let size = Size::new(40, 30);
        for width in [1u32, 2, 3, 4, 7] {
            let mut pixels = vec![[0; 4]; size.pixels()];
            let ends = (Point::pixel_centre(0, 15), Point::pixel_centre(39, 15));
            stroke(&mut pixels, size, ends, [255; 4], &brush(width));
            let column = (0..30).filter(|y| pixels[y * 40 + 20] == [255; 4]).count();
            assert_eq!(column as u32, width);
            let mut pixels = vec![[0; 4]; size.pixels()];
            let ends = (Point::pixel_centre(20, 0), Point::pixel_centre(20, 29));
            stroke(&mut pixels, size, ends, [255; 4], &brush(width));
            let row = (0..40).filter(|x| pixels[15 * 40 + x] == [255; 4]).count();
            assert_eq!(row as u32, width);
        }
    }
}
