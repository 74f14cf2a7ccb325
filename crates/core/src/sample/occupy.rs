//! Changes the number of seeds of a mesh: cells of the grid are vacated or occupied.

use super::spread::spread;
use crate::chance::{Purpose, rank};
use crate::geom::Point;
use crate::hex::HexGrid;
use crate::mesh::{CORNERS, Mesh, Place};

/// Seeds, the survivors of the last frame first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Occupied {
    /// Distinct points of the closed frame, none of them a corner.
    pub(super) seeds: Vec<Point>,
    /// The [ids](Mesh::ids) of the survivors.
    pub(super) survivors: Vec<u64>,
}

/// The seeds of `mesh`, changed to `target` (border points stay, so that there may be more). Every cell of `grid` has
/// a random rank, the same in every frame. If there are too many seeds, cells of the highest ranks lose theirs; if
/// there are too few, the emptiest cells get new ones at random positions.
pub(super) fn occupy(mesh: &Mesh, target: usize, grid: &HexGrid, seed: u64) -> Occupied {
    let size = mesh.size;
    let inner = |p: &Point| Place::of(*p, size) == Place::Interior;
    let border = mesh.seeds().iter().filter(|p| !inner(p)).count();
    let mut ranked: Vec<_> = mesh
        .seeds()
        .iter()
        .enumerate()
        .filter(|(_, p)| inner(p))
        .map(|(i, p)| {
            let (x, y) = p.pixel(size);
            (rank(seed, Purpose::Trim, grid.cell_of_pixel(x, y) as u32, 0), i)
        })
        .collect();
    let room = target.saturating_sub(border);
    if ranked.len() > room {
        ranked.sort_unstable();
    }
    let mut gone = vec![false; mesh.seeds().len()];
    ranked.iter().skip(room).for_each(|&(_, i)| gone[i] = true);
    let numbered = mesh.seeds().iter().copied().zip(mesh.ids[CORNERS..].iter().copied());
    let staying = numbered.zip(gone).filter(|(_, gone)| !gone).map(|(numbered, _)| numbered);
    let (mut seeds, survivors): (Vec<_>, Vec<_>) = staying.unzip();
    let mut pixels: Vec<_> = seeds.iter().map(|p| p.pixel(size)).collect();
    spread(&mut pixels, target, grid, seed);
    seeds.extend(pixels[survivors.len()..].iter().map(|&(x, y)| Point::pixel_centre(x, y)));
    Occupied { seeds, survivors }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;
    use crate::triangulate::triangulate;

    const SIZE: Size = Size::new(200, 120);

    fn mesh(count: u32) -> Mesh {
        let at = |i: u32| {
            let bits = rank(4, Purpose::Noise, i, 0);
            Point::new((bits % (200 * 256)) as i32, ((bits >> 20) % (120 * 256)) as i32)
        };
        let mut seeds: Vec<_> = (0..count).map(at).collect();
        seeds.extend([Point::new(99 * 256, 0), Point::new(0, 60 * 256)]);
        seeds.sort_unstable();
        seeds.dedup();
        triangulate(SIZE, &seeds).expect("distinct seeds")
    }

    #[test]
    fn fewer_are_a_part_of_more_and_the_border_stays() {
        let (mesh, grid) = (mesh(400), HexGrid::new(SIZE, 8.0));
        let half = occupy(&mesh, 200, &grid, 7);
        let few = occupy(&mesh, 100, &grid, 7);
        assert_eq!((half.seeds.len(), few.seeds.len()), (200, 100));
        assert_eq!(half.survivors.len(), 200);
        assert!(few.seeds.iter().all(|p| half.seeds.contains(p)));
        assert!(few.seeds.contains(&Point::new(99 * 256, 0)));
        // Cells are given up all over the frame. Binomial: mean 100, standard deviation 7.
        let left = half.seeds.iter().filter(|p| p.x < 100 * 256).count();
        assert!((72..128).contains(&left), "{left}");
    }

    #[test]
    fn more_keep_all_that_were_there() {
        let (mesh, grid) = (mesh(150), HexGrid::new(SIZE, 8.0));
        let count = mesh.seeds().len();
        let more = occupy(&mesh, 300, &grid, 7);
        assert_eq!((more.seeds.len(), more.survivors.len()), (300, count));
        assert_eq!(more.seeds[..count], *mesh.seeds());
        assert_eq!(triangulate(SIZE, &more.seeds).expect("distinct").check(), Ok(()));
        assert_eq!(occupy(&mesh, count, &grid, 7).seeds, mesh.seeds());
    }
}
