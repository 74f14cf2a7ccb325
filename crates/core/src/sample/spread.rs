//! Adds points where there are no features, so that a flat picture also gets its number of seeds.

use crate::chance::{Purpose, rank};
use crate::feature::mask::Mask;
use crate::hex::HexGrid;

/// Random positions that are tried in each cell. A cell that still lacks points then is nearly full.
const ROUNDS: u32 = 16;

/// Adds distinct pixels to `points` until there are `target` (at most the frame's pixels): in the emptiest cells of
/// `grid` first, at random positions that are the same in every frame; then any free pixels, by their rank.
pub fn spread(points: &mut Vec<(u32, u32)>, target: usize, grid: &HexGrid, seed: u64) {
    if points.len() >= target {
        return;
    }
    let size = grid.size();
    let mut taken = Mask::of(size, points);
    let mut held = vec![0u32; grid.cells()];
    for &(x, y) in points.iter() {
        held[grid.cell_of_pixel(x, y)] += 1;
    }
    let order = |cell: usize, held: u32| (held, rank(seed, Purpose::Phase, cell as u32, 0), cell);
    for round in 0..ROUNDS {
        let mut cells: Vec<_> = (0..grid.cells()).map(|cell| order(cell, held[cell])).collect();
        cells.sort_unstable();
        for (_, _, cell) in cells {
            let Some((x, y)) = throw(grid, cell, round, seed) else { continue };
            if taken.put(x, y) {
                held[cell] += 1;
                points.push((x, y));
                if points.len() == target {
                    return;
                }
            }
        }
    }
    let all = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    let mut free: Vec<_> = all
        .filter(|&(x, y)| !taken.contains(x, y))
        .map(|(x, y)| (rank(seed, Purpose::Phase, x, y), x, y))
        .collect();
    free.sort_unstable();
    points.extend(free.iter().map(|&(_, x, y)| (x, y)).take(target - points.len()));
}

/// A random pixel in the middle of the cell, if it lies in the frame.
pub(super) fn throw(grid: &HexGrid, cell: usize, round: u32, seed: u64) -> Option<(u32, u32)> {
    let bits = rank(seed, Purpose::Interior, cell as u32, round);
    let offset = |bits: u64| (bits & 0xffff) as f64 / 65536.0 - 0.5;
    let (x, y) = grid.centre(cell);
    let (x, y) = (x + grid.width() * offset(bits), y + grid.width() * offset(bits >> 16));
    let size = grid.size();
    let inside = x >= 0.0 && y >= 0.0 && x < f64::from(size.width) && y < f64::from(size.height);
    inside.then_some((x as u32, y as u32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Size;

    #[test]
    fn any_number_of_pixels_can_be_filled() {
        let size = Size::new(23, 17);
        for target in [0, 1, 50, 300, 23 * 17] {
            let mut points = vec![(3, 4)];
            spread(&mut points, target, &HexGrid::new(size, 4.0), 9);
            assert_eq!(points.len(), target.max(1));
            points.sort_unstable();
            points.dedup();
            assert_eq!(points.len(), target.max(1));
            assert!(points.iter().all(|&(x, y)| x < size.width && y < size.height));
        }
    }

    #[test]
    fn empty_cells_are_filled_first() {
        let size = Size::new(200, 200);
        let grid = HexGrid::new(size, 20.0);
        let mut points: Vec<_> = (0..200).map(|x| (x, 10)).collect();
        spread(&mut points, 260, &grid, 1);
        let near = points[200..].iter().filter(|p| p.1 < 30).count();
        assert!(near <= 3, "{near} of 60 new points are next to the old ones");
    }
}
