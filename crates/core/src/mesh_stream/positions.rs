//! Where vertices stand: of a key frame all of them, row by row; of others what moved, what went and what came.

use super::grid::Grid;
use super::half_edges::HalfEdges;
use super::range_coder::{Bits, Byte, Difference, Model, Number};
use super::{Fault, NONE};
use crate::geom::{Point, SUBPIXEL, Size};
use crate::mesh::{CORNERS, Place};

/// What the coder has learnt of points that come row by row.
#[derive(Clone, Debug, Default)]
pub(super) struct RowModels {
    down: Number,
    along: Number,
    across: Number,
    /// Inside the frame, and on its border.
    fractions: [[Byte; 2]; 2],
    /// Whether a point lies off the grid.
    off_grid: Model,
}

/// Passes points in the order of [`by_rows`].
pub(super) fn pass_rows(
    bits: &mut impl Bits,
    models: &mut RowModels,
    (size, grid): (Size, Grid),
    points: &mut [Point],
) -> Result<(), Fault> {
    let pixel = |v: i32| v.div_euclid(SUBPIXEL);
    let (mut last_x, mut last_y) = (0i32, 0i32);
    for point in points {
        let step = models.down.pass(bits, pixel(point.y).wrapping_sub(last_y) as u32) as i32;
        let y = last_y.wrapping_add(step);
        let x = if step == 0 {
            last_x.wrapping_add(models.along.pass(bits, (pixel(point.x) - last_x) as u32) as i32)
        } else {
            models.across.pass(bits, pixel(point.x) as u32) as i32
        };
        let [width, height] = [size.width, size.height].map(|side| side as i32);
        if !(0..=width).contains(&x) || !(0..=height).contains(&y) || bits.is_beyond_end() {
            return Err(Fault::Vertex);
        }
        let border = x == 0 || y == 0 || x >= width - 1 || y >= height - 1;
        let [for_x, for_y] = &mut models.fractions[usize::from(border)];
        let left_out = left_out(bits, &mut models.off_grid, grid, *point);
        let fx = for_x.pass(bits, point.x.rem_euclid(SUBPIXEL) as u8, left_out);
        let fy = for_y.pass(bits, point.y.rem_euclid(SUBPIXEL) as u8, left_out);
        *point = Point::new(x * SUBPIXEL + i32::from(fx), y * SUBPIXEL + i32::from(fy));
        if !size.contains(*point) {
            return Err(Fault::Vertex);
        }
        (last_x, last_y) = (x, y);
    }
    Ok(())
}

/// Passes whether `point` lies off the grid; returns how many of its coordinates' bits are not passed.
fn left_out(bits: &mut impl Bits, model: &mut Model, grid: Grid, point: Point) -> u32 {
    let exact = grid == Grid::EXACT || bits.bit(model, !grid.has(point));
    if exact { 0 } else { grid.power() }
}

/// The order of points row by row: by their pixels, then inside them.
pub(super) fn by_rows(p: Point) -> (i32, i32, i32, i32) {
    (p.y.div_euclid(SUBPIXEL), p.x.div_euclid(SUBPIXEL), p.y, p.x)
}

/// What became of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    /// It stands where it stood.
    Stays,
    /// It moved to here.
    Moves(Point),
    /// It is there no more.
    Dies,
}

/// What the coder has learnt of vertices that live on.
#[derive(Clone, Debug, Default)]
pub(super) struct MoveModels {
    moves: [Model; 16],
    dies: [Model; 4],
    /// Whether it moves to a place off the grid.
    off_grid: Model,
    across: [Difference; 6],
    down: [Difference; 6],
}

/// Passes what became of each of `points`, the corners left out; `fates` has a place for each. Neighbours in the
/// mesh so far, `edges`, predict it.
pub(super) fn pass_fates(
    bits: &mut impl Bits,
    models: &mut MoveModels,
    (size, grid, points): (Size, Grid, &[Point]),
    edges: &HalfEdges,
    fates: &mut [Fate],
) -> Result<(), Fault> {
    for v in CORNERS..points.len() {
        if bits.is_beyond_end() {
            return Err(Fault::Vertex);
        }
        let around = Around::of(v, points, edges, &fates[..v]);
        let fate = fates[v];
        let moves = &mut models.moves[around.context()];
        if !bits.bit(moves, fate != Fate::Stays) {
            fates[v] = Fate::Stays;
            continue;
        }
        if bits.bit(&mut models.dies[around.dead.min(3)], fate == Fate::Dies) {
            fates[v] = Fate::Dies;
            continue;
        }
        let from = points[v];
        let to = if let Fate::Moves(to) = fate { to } else { from };
        let (expected_x, expected_y) = around.expected();
        let class = around.class();
        let (mut x, mut y) = (from.x, from.y);
        let place = Place::of(from, size);
        let left_out = left_out(bits, &mut models.off_grid, grid, to);
        let grid = if left_out == 0 { Grid::EXACT } else { grid };
        // How many of the grid's lines it went further than expected.
        let mut pass = |model: &mut Difference, from: i32, way: i32, to: i32| {
            let expected = grid.nearest(from.wrapping_add(way));
            let by = model.pass(bits, grid.nearest(to).wrapping_sub(expected));
            grid.line(expected.wrapping_add(by))
        };
        if place != Place::SideBorder {
            x = pass(&mut models.across[class], from.x, expected_x, to.x);
        }
        if place != Place::LevelBorder {
            y = pass(&mut models.down[class], from.y, expected_y, to.y);
        }
        let to = Point::new(x, y);
        if !size.contains(to) {
            return Err(Fault::Vertex);
        }
        fates[v] = Fate::Moves(to);
    }
    Ok(())
}

/// The neighbours of a vertex whose fates are known.
#[derive(Debug, Default)]
struct Around {
    known: usize,
    moved: usize,
    dead: usize,
    sum: (i64, i64),
    spread: i64,
}

impl Around {
    fn of(v: usize, points: &[Point], edges: &HalfEdges, fates: &[Fate]) -> Self {
        let mut around = Self::default();
        let mut first: Option<(i64, i64)> = None;
        for &(u, _, _) in edges.from(v as u32) {
            let u = u as usize;
            if u < CORNERS || u >= fates.len() {
                continue;
            }
            let step = match fates[u] {
                Fate::Dies => {
                    around.dead += 1;
                    continue;
                }
                Fate::Stays => (0, 0),
                Fate::Moves(to) => {
                    around.moved += 1;
                    (i64::from(to.x - points[u].x), i64::from(to.y - points[u].y))
                }
            };
            around.known += 1;
            around.sum.0 += step.0;
            around.sum.1 += step.1;
            let (x, y) = *first.get_or_insert(step);
            around.spread = around.spread.max((x - step.0).abs().max((y - step.1).abs()));
        }
        around
    }

    /// By how many neighbours are known, and how many of them moved.
    fn context(&self) -> usize {
        4 * self.known.min(3) + self.moved.min(3)
    }

    /// The mean way of the neighbours that are known.
    fn expected(&self) -> (i32, i32) {
        let mean = |sum: i64| {
            let count = self.known.max(1) as i64;
            (2 * sum + count).div_euclid(2 * count) as i32
        };
        (mean(self.sum.0), mean(self.sum.1))
    }

    /// How far the neighbours agree.
    fn class(&self) -> usize {
        match (self.known, self.spread) {
            (0, _) => 5,
            (1, _) => 4,
            (_, 0..16) => 0,
            (_, 16..64) => 1,
            (_, 64..256) => 2,
            _ => 3,
        }
    }
}

/// The numbers that vertices of the frame before have now, [`NONE`] where they died, and how many live.
///
/// Numbers of the dead are given to those that come, lowest first; if more come than died they go behind all
/// others. If fewer come, what is above a number that is left over moves down.
pub(super) fn renumbered(fates: &[Fate], born: usize) -> (Vec<u32>, Vec<u32>) {
    let dead: Vec<usize> = (0..fates.len()).filter(|&v| fates[v] == Fate::Dies).collect();
    let given = &dead[..born.min(dead.len())];
    let (mut numbers, mut births, mut next) = (Vec::with_capacity(fates.len()), Vec::new(), 0);
    for (v, fate) in fates.iter().enumerate() {
        if *fate == Fate::Dies {
            numbers.push(NONE);
            if given.binary_search(&v).is_ok() {
                births.push(next);
                next += 1;
            }
        } else {
            numbers.push(next);
            next += 1;
        }
    }
    births.extend((next..).take(born - births.len()));
    (numbers, births)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_the_dead_are_given_again() {
        use Fate::{Dies, Stays};
        let fates = [Stays, Dies, Stays, Dies, Stays];
        assert_eq!(renumbered(&fates, 1), (vec![0, NONE, 2, NONE, 3], vec![1]));
        assert_eq!(renumbered(&fates, 3), (vec![0, NONE, 2, NONE, 4], vec![1, 3, 5]));
        assert_eq!(renumbered(&fates, 0), (vec![0, NONE, 1, NONE, 2], vec![]));
    }
}
