//! Delaunay triangulation of seeds and corners.

use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::error::{Error, Result};
use crate::geom::{Point, Size};
use crate::mesh::Mesh;

/// A vertex for spade, whose `bulk_load` reorders vertices: it holds its own number.
struct Numbered {
    at: Point2<f64>,
    number: u32,
}

impl HasPosition for Numbered {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// Triangulates the frame's corners and `seeds` (distinct points of the closed frame, none of them a corner). If more
/// than three points are on one circle spade chooses the diagonal, always the same for the same points. O(n log n).
///
/// # Errors
/// When two seeds are equal or one is a corner.
pub fn triangulate(size: Size, seeds: &[Point]) -> Result<Mesh> {
    let mut vertices = Vec::with_capacity(seeds.len() + 4);
    vertices.extend(Mesh::corners(size));
    vertices.extend_from_slice(seeds);
    let (distinct, triangles) = delaunay(vertices.iter().map(|p| (p.x.into(), p.y.into())));
    if distinct != vertices.len() {
        return Err(Error::DuplicateSeeds);
    }
    Ok(Mesh::new(size, vertices, triangles))
}

/// The number of distinct `points`, which are finite, and their Delaunay triangles in canonical order.
pub(crate) fn delaunay(points: impl Iterator<Item = (f64, f64)>) -> (usize, Vec<[u32; 3]>) {
    let numbered = (0u32..)
        .zip(points)
        .map(|(number, (x, y))| Numbered { at: Point2::new(x, y), number })
        .collect();
    let delaunay = DelaunayTriangulation::<Numbered>::bulk_load(numbered)
        .expect("coordinates are finite and of a size that spade accepts");
    let mut triangles: Vec<[u32; 3]> = delaunay
        .inner_faces()
        .map(|face| face.vertices().map(|vertex| vertex.data().number))
        .collect();
    Mesh::canonicalise(&mut triangles);
    (delaunay.num_vertices(), triangles)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::geom::{SUBPIXEL, in_circle};
    use proptest::prelude::*;

    /// The mesh of seeds at `places`, shares of width and height 0..=1, on a grid of `snap` / 256 pixel.
    pub(crate) fn mesh_of(size: Size, places: &[(f64, f64)], snap: i32) -> Mesh {
        let far = size.far();
        let on_grid = |share: f64, far: i32| (share * f64::from(far)) as i32 / snap * snap;
        let mut seeds: Vec<_> = places
            .iter()
            .map(|&(x, y)| Point::new(on_grid(x, far.x), on_grid(y, far.y)))
            .filter(|p| !Mesh::corners(size).contains(p))
            .collect();
        seeds.sort_unstable();
        seeds.dedup();
        triangulate(size, &seeds).expect("distinct seeds")
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn any_seeds_give_a_sound_delaunay_mesh(
            (width, height) in (1u32..40, 1u32..40),
            places in proptest::collection::vec((0.0f64..=1.0, 0.0f64..=1.0), 0..60),
            snap in prop_oneof![Just(1), Just(SUBPIXEL / 2), Just(SUBPIXEL)],
        ) {
            let size = Size::new(width, height);
            let mesh = mesh_of(size, &places, snap);
            prop_assert_eq!(mesh.check(), Ok(()));
            for t in 0..mesh.triangles.len() {
                let [a, b, c] = mesh.triangle(t);
                prop_assert!(mesh.vertices.iter().all(|&d| !in_circle(a, b, c, d)));
            }
        }
    }

    #[test]
    fn no_seeds_give_two_triangles_down_to_one_pixel() {
        for size in [Size::new(1, 1), Size::new(1, 16384), Size::new(640, 480)] {
            let mesh = triangulate(size, &[]).expect("corners alone");
            assert_eq!(mesh.triangles.len(), 2);
            assert_eq!(mesh.check(), Ok(()));
        }
    }

    #[test]
    fn equal_seeds_are_an_error() {
        let p = Point::pixel_centre(1, 1);
        assert!(triangulate(Size::new(4, 4), &[p, p]).is_err());
        assert!(triangulate(Size::new(4, 4), &[Point::new(0, 0)]).is_err());
    }
}
