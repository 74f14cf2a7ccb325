//! The vertices that a step visits.

use crate::options::EIGHTHS;

/// Neighbours in the same stripe, so that they can follow an edge of the picture together.
const PATCH: usize = 96;

/// The vertices that a step, or a part of one, visits. Patches of neighbours are distributed over as many stripes as
/// a step has parts, and each part visits the next stripes. Every stripe is spread evenly over the picture, and has
/// about as many vertices as the others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    first: u32,
    stripes: u32,
}

impl Share {
    /// All vertices.
    pub(super) const ALL: Self = Self { first: 0, stripes: EIGHTHS };

    /// The vertices of `stripes` stripes from the `first` on.
    pub(super) fn new(first: u32, stripes: u32) -> Self {
        Self { first, stripes }
    }

    /// The stripe after these.
    pub(super) fn next(self) -> u32 {
        (self.first + self.stripes) % EIGHTHS
    }

    /// The same share of `whole`, rounded up.
    pub(super) fn count(self, whole: usize) -> usize {
        (whole * self.stripes as usize).div_ceil(EIGHTHS as usize)
    }

    /// The number of steps of this share that visit all vertices.
    pub(super) fn turns(self) -> u32 {
        EIGHTHS.div_ceil(self.stripes.max(1))
    }

    /// The vertices of this share. `order` has all vertices, neighbours close together.
    pub(super) fn of(self, order: &[u32]) -> impl Iterator<Item = u32> {
        let stripes = (0..EIGHTHS).cycle();
        let ours = move |stripe: u32| (stripe + EIGHTHS - self.first) % EIGHTHS < self.stripes;
        let patches = order.chunks(PATCH).zip(stripes).filter(move |(_, stripe)| ours(*stripe));
        patches.flat_map(|(patch, _)| patch).copied()
    }
}

/// Which vertices and triangles a pass may re-place, by their numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    slices: u32,
    slice: u32,
    round: u32,
}

impl Turn {
    /// All of them.
    pub(super) const ALL: Self = Self { slices: 1, slice: 0, round: 0 };

    /// The turn of pass number `pass`, of passes that cover one of `slices` slices each.
    pub(super) fn new(slices: u32, pass: u32) -> Self {
        Self { slices, slice: pass % slices, round: pass / slices }
    }

    pub(super) fn has(self, number: u32) -> bool {
        number % self.slices == self.slice
    }

    /// Whether `number` is in the quarter of this turn's numbers that this round covers.
    pub(super) fn has_in_quarter(self, number: u32) -> bool {
        (number / self.slices).wrapping_add(self.round).is_multiple_of(4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarters_of_all_slices_take_turns() {
        for slices in [1, 3, 8] {
            let mut turns = [0; 96];
            for turn in (5..5 + 4 * slices).map(|pass| Turn::new(slices, pass)) {
                let ours = (0..96).filter(|&v| turn.has(v) && turn.has_in_quarter(v));
                ours.for_each(|v| turns[v as usize] += 1);
            }
            assert_eq!(turns, [1; 96], "{slices} slices");
        }
    }

    #[test]
    fn in_eight_parts_every_vertex_has_its_turn_once() {
        let order: Vec<u32> = (0..5000).rev().collect();
        for stripes in [1, 2, 4, 8] {
            let (mut first, mut turns) = (3, vec![0; order.len()]);
            for _ in 0..EIGHTHS / stripes {
                let share = Share::new(first, stripes);
                let before = turns.iter().sum::<u32>() as usize;
                share.of(&order).for_each(|v| turns[v as usize] += 1);
                let visited = turns.iter().sum::<u32>() as usize - before;
                assert!(visited.abs_diff(share.count(order.len())) <= 2 * PATCH, "{visited}");
                first = share.next();
            }
            assert!(turns.iter().all(|&turns| turns == 1), "{stripes} stripes");
            assert_eq!(Share::new(first, stripes).turns() * stripes, EIGHTHS);
        }
        assert!(Share::ALL.of(&order).eq(order.iter().copied()));
    }
}
