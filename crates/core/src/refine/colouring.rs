//! Classes of vertices that can move at once.

use super::surface::{Fan, Surface, around_each, next};

/// Vertices in classes, no two of a class joined by an edge: what one of them does leaves the
/// surroundings of the others as they are, so that a class moves in parallel and the outcome does not
/// depend on the number of threads.
#[derive(Debug, Default)]
pub(super) struct Colouring {
    colour: Vec<u8>,
    /// The classes; later ones may be empty.
    pub(super) classes: Vec<Vec<u32>>,
}

/// More classes than any mesh needs; a vertex that finds none free waits for the next step.
const MAX_CLASSES: u32 = 64;

const UNCOLOURED: u8 = u8::MAX;

impl Colouring {
    /// Colours those of `order` for which `wanted` holds, greedily in that order.
    pub(super) fn colour(
        &mut self,
        surface: &Surface,
        order: &[u32],
        wanted: impl Fn(u32) -> bool,
    ) {
        // Before the resize: the classes are those of the last mesh, which may have had more vertices.
        for class in &mut self.classes {
            class.drain(..).for_each(|v| self.colour[v as usize] = UNCOLOURED);
        }
        self.colour.resize(surface.at.len(), UNCOLOURED);
        let wanted = order.iter().copied().filter(|&v| wanted(v));
        around_each(surface, wanted, |&v| v, |v, leaving| self.put(surface, v, leaving));
    }

    /// Puts `v`, which half-edges are `leaving`, into the first class that none of its neighbours is in.
    fn put(&mut self, surface: &Surface, v: u32, leaving: Fan) {
        let mut taken = 0u64;
        let mut take = |w: u32| {
            let colour = self.colour[w as usize];
            if colour != UNCOLOURED {
                taken |= 1 << colour;
            }
        };
        let mut last = 0;
        leaving.for_each(|h| {
            take(surface.to(h));
            last = h;
        });
        // On the border the last neighbour has no half-edge that leaves for it.
        take(surface.to(next(last)));
        let free = taken.trailing_ones();
        if free >= MAX_CLASSES {
            return;
        }
        self.colour[v as usize] = free as u8;
        if self.classes.len() <= free as usize {
            self.classes.push(Vec::new());
        }
        self.classes[free as usize].push(v);
    }
}
