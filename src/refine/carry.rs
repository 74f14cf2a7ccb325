//! A mesh travels with the picture.

use crate::geom::{Point, orient};
use crate::mesh::{CORNERS, Mesh, Place};

/// Moves each vertex of `mesh` towards its entry in `targets`, as far as the mesh stays sound: corners
/// stay, vertices on the border slide along their side, and where triangles would turn over or lose
/// their area the ways of their corners are halved until they do not. The triangles keep their
/// vertices. Returns how many vertices moved.
///
/// Ways that agree with their neighbours', as those of a picture that moves do, are hardly ever
/// shortened: triangles are judged after all of them are made, not one by one.
pub fn carry(mesh: &mut Mesh, targets: &[Point]) -> usize {
    let far = mesh.size.far();
    let starts = mesh.vertices.clone();
    let mut ways: Vec<(i32, i32)> = starts
        .iter()
        .zip(targets)
        .enumerate()
        .map(|(v, (from, to))| {
            // What is inside stays inside, by a step of the grid at least.
            let x = to.x.clamp(1, (far.x - 1).max(1)) - from.x;
            let y = to.y.clamp(1, (far.y - 1).max(1)) - from.y;
            match Place::of(*from, mesh.size) {
                _ if v < CORNERS => (0, 0),
                Place::Corner => (0, 0),
                Place::SideBorder => (0, y),
                Place::LevelBorder => (x, 0),
                Place::Interior => (x, y),
            }
        })
        .collect();
    ways.resize(starts.len(), (0, 0));
    loop {
        for ((vertex, from), way) in mesh.vertices.iter_mut().zip(&starts).zip(&ways) {
            *vertex = Point::new(from.x + way.0, from.y + way.1);
        }
        let mut turned: Vec<u32> = Vec::new();
        for &[a, b, c] in &mesh.triangles {
            let [p, q, r] = [a, b, c].map(|v| mesh.vertices[v as usize]);
            if orient(p, q, r) <= 0 {
                turned.extend([a, b, c]);
            }
        }
        if turned.is_empty() {
            break;
        }
        turned.sort_unstable();
        turned.dedup();
        // Halves towards nought: after 23 rounds every way is, and the mesh is what it was.
        for v in turned {
            let way = &mut ways[v as usize];
            *way = (way.0 / 2, way.1 / 2);
        }
    }
    ways.iter().filter(|&&way| way != (0, 0)).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{SUBPIXEL, Size};
    use crate::triangulate::triangulate;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]

        #[test]
        fn any_targets_leave_the_mesh_sound(
            (width, height) in (1u32..40, 1u32..40),
            places in proptest::collection::vec((0.0f64..=1.0, 0.0f64..=1.0), 0..60),
            ways in proptest::collection::vec((-9000i32..9000, -9000i32..9000), 64),
            calm in 1i32..500,
        ) {
            let size = Size::new(width, height);
            let far = size.far();
            let mut seeds: Vec<_> = places
                .iter()
                .map(|&(x, y)| Point::new((x * f64::from(far.x)) as i32, (y * f64::from(far.y)) as i32))
                .filter(|p| !Mesh::corners(size).contains(p))
                .collect();
            seeds.sort_unstable();
            seeds.dedup();
            let mut mesh = triangulate(size, &seeds).expect("distinct seeds");
            let before = mesh.clone();
            let targets: Vec<_> = mesh
                .vertices
                .iter()
                .zip(ways)
                .map(|(p, way)| Point::new(p.x + way.0 / calm, p.y + way.1 / calm))
                .collect();
            carry(&mut mesh, &targets);
            prop_assert_eq!(mesh.check(), Ok(()));
            prop_assert_eq!(&mesh.triangles, &before.triangles);
            for (a, b) in before.vertices.iter().zip(&mesh.vertices) {
                prop_assert_eq!(Place::of(*a, size), Place::of(*b, size));
            }
        }
    }

    #[test]
    fn a_shift_of_the_whole_picture_is_followed_by_all_but_the_border() {
        let size = Size::new(100, 100);
        let seeds: Vec<_> =
            (0..81).map(|i| Point::pixel_centre(20 + i % 9 * 7, 20 + i / 9 * 7)).collect();
        let mut mesh = triangulate(size, &seeds).expect("distinct seeds");
        let shift = |p: &Point| Point::new(p.x + 9 * SUBPIXEL, p.y + 3 * SUBPIXEL);
        let targets: Vec<_> = mesh.vertices.iter().map(shift).collect();
        assert_eq!(carry(&mut mesh, &targets), 81);
        assert_eq!(mesh.vertices[CORNERS..], targets[CORNERS..]);
        assert_eq!(mesh.check(), Ok(()));
    }
}
