//! Vertices on a grid that is coarser than 1/256 pixel, where that leaves the mesh sound.

use crate::geom::{Point, SUBPIXEL, orient};
use crate::mesh::Mesh;

/// The distance of the grid's lines, as a power of two in 1/256 pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Grid(u8);

impl Grid {
    /// Coordinates as they are.
    pub const EXACT: Self = Self(0);

    /// A grid of `parts` lines a pixel: 1, 2, 4 and so on up to 256, which is [`Grid::EXACT`].
    pub fn of_parts(parts: u32) -> Option<Self> {
        let sound = parts.is_power_of_two() && parts <= SUBPIXEL as u32;
        sound.then(|| Self(8 - parts.ilog2() as u8))
    }

    /// Lines a pixel.
    pub const fn parts(self) -> u32 {
        1 << (8 - self.0)
    }

    /// The grid whose lines are 2^`power` / 256 pixel apart.
    pub(super) fn of_power(power: u8) -> Option<Self> {
        (power <= 8).then_some(Self(power))
    }

    /// The distance of its lines is 2^this, in 1/256 pixel.
    pub(super) fn power(self) -> u32 {
        u32::from(self.0)
    }

    /// The number of the line that is nearest to `v`; of two as near the one above.
    pub(super) fn nearest(self, v: i32) -> i32 {
        let half = (1i64 << self.0) >> 1;
        // At most as large as v.
        ((i64::from(v) + half) >> self.0) as i32
    }

    /// Where the line of this number lies.
    pub(super) fn line(self, number: i32) -> i32 {
        number.wrapping_shl(self.power())
    }

    pub(super) fn round(self, p: Point) -> Point {
        let round = |v| self.line(self.nearest(v));
        Point::new(round(p.x), round(p.y))
    }

    /// Whether `p` is one of its points.
    pub(super) fn has(self, p: Point) -> bool {
        self.round(p) == p
    }
}

/// The vertices of `mesh`, those moved to the grid that leave all triangles their turn. Such a mesh covers its frame
/// as before.
pub(super) fn rounded(mesh: &Mesh, grid: Grid) -> Vec<Point> {
    if grid == Grid::EXACT {
        return mesh.vertices.clone();
    }
    let mut points: Vec<Point> = mesh.vertices.iter().map(|&p| grid.round(p)).collect();
    loop {
        let mut turned = Vec::new();
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| points[v as usize]);
            if orient(a, b, c) <= 0 {
                turned.extend(t.map(|v| v as usize));
            }
        }
        let mut mended = false;
        for v in turned {
            mended |= points[v] != mesh.vertices[v];
            points[v] = mesh.vertices[v];
        }
        if !mended {
            return points;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Purpose, rank};
    use crate::geom::Size;
    use crate::triangulate::triangulate;

    #[test]
    fn a_rounded_mesh_is_sound_and_near() {
        let size = Size::new(40, 30);
        let mut seeds: Vec<Point> = (0..400)
            .map(|i| {
                let bits = rank(3, Purpose::Noise, i, 2);
                let (x, y) = (bits as u32 as i32, (bits >> 32) as i32);
                Point::new(x.rem_euclid(size.far().x - 1) + 1, y.rem_euclid(size.far().y - 1) + 1)
            })
            .collect();
        seeds.sort_unstable();
        seeds.dedup();
        let mesh = triangulate(size, &seeds).expect("distinct");
        for parts in [1, 2, 16, 128, 256] {
            let grid = Grid::of_parts(parts).expect("a power of two");
            let points = rounded(&mesh, grid);
            let on_grid = points.iter().filter(|&&p| grid.has(p)).count();
            assert!(3 * on_grid > points.len(), "{on_grid} of {} at {parts}", points.len());
            let half = 128 / parts as i32;
            let near =
                |(a, b): (&Point, &Point)| (a.x - b.x).abs() <= half && (a.y - b.y).abs() <= half;
            assert!(points.iter().zip(&mesh.vertices).all(near));
            let mesh = Mesh { vertices: points, ..mesh.clone() };
            assert_eq!(mesh.check(), Ok(()));
        }
        assert_eq!(Grid::of_parts(3), None);
        assert_eq!(Grid::of_parts(512), None);
    }
}
